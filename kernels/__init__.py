"""Taichi kernels: everything that is done per cell, node or pixel. No state, no Python objects, relative imports only.

How it works. Kernels take flat one-dimensional arrays and are compiled once per kind of cell, law and options
(memoised factories such as `internal_force.make_step`), never per scene. `cell_phase` is the pass over packs of cells,
a lane per cell, that only adds into rows of its own chunk of nodes: no atomics, the same bits at any number of threads;
`node_phase` sums these rows and moves the nodes. `materials` holds the laws, a file each with its stress and stiffness,
`elements` the elements, `static_solve` and `sweeps` the projected Gauss-Seidel sweeps that place nodes
without mass, `friction` the local friction problems, `serial_step` the rest of a step in one launch, `layer1d*` the
friction layers, `implicit_*` the residuals and tangents of implicit steps, and `raster` the pictures. Each file opens
with its formula and its source.
"""
