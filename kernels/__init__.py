"""Taichi kernels: all that is computed for each cell, node or pixel. They hold no state and import relatively.

How it works. Kernels take flat one-dimensional arrays and are compiled once for every combination of element, law and
options (memoised factories such as `step.internal_force.make_step`), never per scene. Their signatures are made from
bundles of named arrays (`language.bundles`, `language.signatures`). Each file opens with its formula and its source.
The rooms, from top to bottom; each imports only what stands below it:

    pictures    triangles to pixels
    step        whole steps: the parallel force pass with the motion of the nodes, and everything else in one launch;
                on a GPU a thread per cell and a thread per node (`step.device_step`)
    layer       the implicit step of many friction layers
    static      the static solve of the massless contact nodes: measure, tangent, sweeps or MPRGP, and what surrounds it
    contact     constraint rows, the obstacles that fill them, contact loads, friction, viscosity of contact cells
    cells       passes over packs of cells, points and tangents of the implicit schemes, von Mises stress
    nodes       sum of the forces, kick and drift of the nodes, supports, damping, periodic images, rigid bodies
    elements    one file for every element: the force of one cell from its corners
    materials   one file for every law: stress, energy, stiffness
    language    tensors, vectors of lanes, bundles, signatures, options of the compiler, formulas of users
    columns     the table of all numbers that a step measures and of all columns of the history
    node_places places of the data of MPRGP; host and kernels share it
    pair_places places of the rows of pairs of bodies; host and kernels share it
    rigid_places  places of the numbers of rigid bodies; host and kernels share it
    volume_places  places of volume changes averaged at nodes; host and kernels share it
    load_places places of the data of loads; host and kernels share it
    layer_places  places of friction layers on a GPU; host and kernels share it
    sweep_places  places of the numbers that control sweeps; host and kernels share it
    lanes       sizes and places that the host and the kernels agree on
    engine      the one module that imports the compiler, Taichi

`cells.cell_phase` adds the corner forces of a chunk of cells only into rows of that chunk, without atomics, and
`nodes.node_phase` sums the rows of all chunks in order, so that the bits depend on the number of chunks alone.
"""
