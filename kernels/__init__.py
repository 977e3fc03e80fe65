"""Taichi kernels: all work per cell, node or pixel. They hold no state and no Python objects, and import relatively.

Kernels take flat one-dimensional arrays and are compiled once per kind of cell, law and options (memoised factories
such as `internal_force.make_step`), never per scene. The rooms:

    language    3x3 tensors, lanes, bundles of arrays and the kernel signatures made from them
    materials   laws, one file each: stress, energy, stiffness
    elements    elements, one file each: corner forces from the displacements of one cell
    cells       force pass over packs of cells, one lane per cell; points and tangents of implicit steps
    nodes       sum of forces, kick and drift of nodes; supports, damping, periodic images
    contact     constraint rows, obstacles, friction, penalty and impulse
    static      static solve that places the massless contact nodes
    step        whole steps: the parallel force pass and the serial kernel
    layer       friction layers
    pictures    z-buffer pictures

Cells add their forces to rows of their own chunk of nodes only: no atomics, and the same bits with any number of
threads. Each file opens with its formula and its source.
"""
