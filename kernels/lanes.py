"""Sizes that the host and the kernels agree on: packed cells (tcontact/planning/packing.py), sweeps, contact."""

GRAIN = 512  # a parallel loop gives each thread at least this many iterations: one in so many does the work
CHUNKS = 8  # of ordinary cells, and as many of contact cells: the same bits at any thread count. More for more threads:
MAXIMUM_CHUNKS = 31
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
OBSTACLE = 33  # numbers of an obstacle (obstacles.py)
FRICTION_NODE = 9  # of friction per contact node (friction.py)
MAXIMUM_SLOTS = 3  # obstacles that can hold one node at a time
LAW_PARAMETERS = 8  # room in `params` for the parameters of a law
# places in `params`: kicks and drift [s], gravity [m/s^2] (3), constants of the law of damping (4), 1 where boundary
# nodes move like all others (products), number of massless nodes, number of chunks; then the materials: parameters of
# the law (LAW_PARAMETERS), with viscosity also Lame's constants [Pa] and those of the bulk viscosity: c1 c [m/s], c2^2,
# density [kg/m^3], mean over smallest corner mass of a cell
KICK_BEFORE, KICK_AFTER, DRIFT, GRAVITY, DAMPING = 0, 1, 2, 3, 6
FREE, MASSLESS, CHUNK_COUNT, MATERIALS = 10, 11, 12, 13
# where these begin in a material, and their end
LAME, VISCOSITY, MATERIAL_NUMBERS = LAW_PARAMETERS, LAW_PARAMETERS + 2, LAW_PARAMETERS + 6
ISLAND = 5  # starts of an island: contact node, pack, contact cell, node without rows, contact block (islands.py)
SWEEP_LANES = 4  # contact nodes of one colour that a sweep takes at once
MAXIMUM_ROWS = 256  # in one launch of a small body
