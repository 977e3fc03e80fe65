"""Sizes that the host and the kernels agree on: packed cells (tcontact/packing.py), sweeps, sums of a row."""

GRAIN = 512  # a parallel loop gives each thread at least this many iterations: one in so many does the work
CHUNKS = 8  # of ordinary cells, and as many of contact cells: the same bits at any thread count. More for more threads:
MOST_CHUNKS = 31
CHUNK_BITS = 5  # of node_info for the first chunk of a node, as many for the last one; then the boundary node + 1
CHUNK_MASK = (1 << CHUNK_BITS) - 1
WIDTH = 8  # lanes of a pack
# numbers of a segment, the packs of one block of cells in one chunk: first and end pack of the block; end of its cells
# (pack * width + lane); where in `connectivity` its pack 0 begins; where in `params` its material stands; the row of
# place 0 of `connectivity`, for contact cells; the number of its first lane among the lanes of all blocks; where in
# `memory` its pack 0 begins
SEGMENT = 8
FIRST_PACK, END_PACK, END_CELL, CONNECTIVITY, MATERIAL, ROW, LANE, MEMORY = range(SEGMENT)
# numbers of a contact block, the contact cells of one block: first and end cell among all contact cells; where its
# nodes begin in `cell_nodes`, the data of its quadrature points in `shape_gradients` and `weights`, and how many points
# there are; where in `params` its material stands; where in `memory` its cell 0 begins; number of its kind of cells
CONTACT_BLOCK = 9
FIRST_CELL, LAST_CELL, NODES_AT, GRADIENTS_AT, WEIGHTS_AT, POINTS, MATERIAL_AT, MEMORY_AT, KIND = range(CONTACT_BLOCK)
# numbers that kernels sum up, and of all of them side by side in a raw row
NODE_SUMS = 10  # kinetic, momentum (3), angular momentum (3), sum m u (3)
CELL_SUMS = 3  # elastic energy, smallest det F, hourglass energy
BOUNDARY_SUMS = 8  # kinetic energy, momentum (3), angular momentum (3), work of the loads
SUPPORT_SUMS = 4  # reaction (3), its power
CONTACT_SUMS = 8  # total force (3), energy, nodes that press, static residual, smallest gap, sweeps
OBSTACLE = 33  # of an obstacle (obstacles.py)
FRICTION_NODE, FRICTION_TRACE = 9, 13  # of friction per contact node, and per slot of one (friction.py)
TRACKED = 6  # force and moment of an obstacle, about its reference point
MOST_SLOTS = 3  # obstacles that can hold one node at a time
FRICTION_SUMS = 2  # work of friction from the row before to this one, and of the half kick after it
# where they stand in `sums`, which all but the force pass share; the loads of obstacles come last
SUPPORT_AT = BOUNDARY_SUMS
CONTACT_AT = SUPPORT_AT + SUPPORT_SUMS
FRICTION_AT = CONTACT_AT + CONTACT_SUMS
LOADS_AT = FRICTION_AT + FRICTION_SUMS
RAW = NODE_SUMS + CELL_SUMS + BOUNDARY_SUMS + SUPPORT_SUMS + CONTACT_SUMS
LAW_PARAMETERS = 8  # room in `params` for the parameters of a law
# places in `params`: kicks and drift [s], gravity [m/s^2] (3), rate of the damping [1/s], 1 where boundary nodes move
# like all others (products), number of massless nodes, number of chunks; then the materials: parameters of the law
# (LAW_PARAMETERS), with viscosity also Lame's constants [Pa] and those of the bulk viscosity: c1 c [m/s], c2^2, density
# [kg/m^3], mean over smallest corner mass of a cell
KICK_BEFORE, KICK_AFTER, DRIFT, GRAVITY, DAMPING_RATE = 0, 1, 2, 3, 6
FREE, MASSLESS, CHUNK_COUNT, MATERIALS = 7, 8, 9, 10
# where these begin in a material, and their end
LAME, VISCOSITY, MATERIAL_NUMBERS = LAW_PARAMETERS, LAW_PARAMETERS + 2, LAW_PARAMETERS + 6
VISCOUS_SUMS = 2  # dissipated power [W], largest rate of a cell [1/s]
CHUNK_SUMS = CELL_SUMS + VISCOUS_SUMS  # of a chunk in `cell_sums`; after all chunks the viscous pressure of every lane
SWEEP_LANES = 4  # contact nodes of one colour that a sweep takes at once
