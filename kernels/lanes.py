"""Sizes and places that host and kernels share: packed cells (tcontact/planning/packing.py), sweeps, contact."""

GRAIN = 512  # a parallel loop gives each thread at least this many iterations: one in GRAIN does the work of a chunk
CHUNKS = 8  # chunks of ordinary cells, and as many of contact cells, on up to so many threads, which give the same bits
MAXIMUM_CHUNKS = 31  # more threads have as many chunks, up to this number, and other rounding errors
CHUNK_BITS = 5  # bits in node_info for the first chunk of a node, and for the last one; then the boundary node + 1
CHUNK_MASK = (1 << CHUNK_BITS) - 1
WIDTH = 8  # lanes of a pack
COUNTING = 8 * WIDTH  # whole numbers from 0 that end `connectivity` if there are contact cells (cell_phase.py)
# numbers of a segment, the packs of one block of cells in one chunk: first and end pack in the block; end of its cells
# (pack * width + lane); start of pack 0 in `connectivity`; start of its material in `params`; force row of place 0 of
# `connectivity`, for contact cells; its first lane among the lanes of all blocks; start of pack 0 in `memory`, and of
# its stored shapes in `position`
SEGMENT = 9
FIRST_PACK, END_PACK, END_CELL, CONNECTIVITY, MATERIAL, ROW, LANE, MEMORY, SHAPE = range(SEGMENT)
# numbers of a contact block, the contact cells of one block: first and end cell among all contact cells; start of its
# nodes in `cell_nodes`, of the gradients and of the weights of its quadrature points in `shape_gradients`; number of
# points per cell; start of its material in `params`; start of its cell 0 in `memory`; number of its kind of cells; its
# first lane among those of contact cells
CONTACT_BLOCK = 10
FIRST_CELL, LAST_CELL, NODES_AT, GRADIENTS_AT, WEIGHTS_AT, POINTS, MATERIAL_AT, MEMORY_AT = range(CONTACT_BLOCK - 2)
KIND, LANE_AT = CONTACT_BLOCK - 2, CONTACT_BLOCK - 1
OBSTACLE = 33  # numbers of an obstacle (obstacles.py)
LEVEL = 1e-9  # distance over the largest half size of a block up to which a position or surface is level with a face
FRICTION_NODE = 9  # numbers of friction per contact node (friction.py)
# numbers of a law of friction (contact/friction_laws.py): static - kinetic [-]; decay [s/m]; limit [Pa]; place of its
# table from the first record on, number of its speeds and of its pressures
FRICTION_LAW = 6
JUMP, DECAY, SHEAR_LIMIT, TABLE, SPEEDS, PRESSURES = range(FRICTION_LAW)
HELD = -3.0  # law of a row before the start solve of a run that goes on from another one
DRIVEN_AXIS = 4  # numbers of an axis that a function of time drives, at a level (driven_supports.py)
# numbers of all springs, of one, of a node at its end and of a rigid part that carries some of these (springs.py)
SPRING_HEAD, SPRING_NUMBERS, SPRING_ENTRY, SPRING_CARRIER = 4, 28, 3, 5
MAXIMUM_SLOTS = 3  # obstacles that can be in contact with one node at a time
# places in `params`: kicks and drift [s], gravity [m/s^2] (3), constants of the damping law (4), 1 if boundary nodes
# move like ordinary ones (products), number of massless nodes, number of chunks, length of the step that ends at the
# present state [s]; then the materials, each with the constants of its viscosity, if it has any, before the parameters
# of its law: Lame's constants [Pa], then of the bulk viscosity c1 c [m/s], c2^2, density [kg/m^3], mean over smallest
# corner mass of a cell; in mixed precision the length unit of its cells [m] follows (mixed_cells.py)
KICK_BEFORE, KICK_AFTER, DRIFT, GRAVITY, DAMPING = 0, 1, 2, 3, 6
FREE, MASSLESS, CHUNK_COUNT, STEP, MATERIALS = 10, 11, 12, 13, 14
# STEP [s] of a pass at the state of points with which a run starts: too short to flow in at any rate; below 0, as
# nothing has moved in it
RESTING = -1e-30
# places of the bulk viscosity and of Lame's constants, from the parameters of the law on
VISCOSITY, LAME = -6, -2
# numbers of an island (islands.py): its first contact node, pack, node without rows and contact block
ISLAND = 4
SWEEP_LANES = 8  # contact nodes of one colour that a sweep updates at once
MAXIMUM_ROWS = 256  # time levels in one launch of a small domain
# steps on a GPU, a thread per cell and per node (kernels/step/device_step.py): threads of a block; threads of a launch,
# a power of two between these; values that one thread adds up in a stage of the sums over all threads; rows of a block
# of steps whose sums stay on the device
DEVICE_BLOCK, FEWEST_THREADS, MOST_THREADS, FOLD, DEVICE_ROWS = 128, 1024, 1 << 16, 32, 32
# threads of the one block that steps the boundary nodes there (language/threads.py), which has 128 registers for each;
# numbers that the threads of a block combine at once
BLOCK_THREADS, BLOCK_NUMBERS = 256, 16
# sweeps of a static solve by several blocks in one launch of the host, whose time grows with the arrays that it names
SWEEPS_AT_ONCE = 4
# numbers of a part, the ordinary or the contact cells of a block: first and end lane among those of its kind of cells;
# count of cells without the lanes that fill up the last pack; starts of pack 0 in `connectivity`, of the material in
# `params`, of pack 0 in `memory` and of its stored shapes in `position`
PART = 7
FIRST_LANE, END_LANE, PART_CELLS, PART_CONNECTIVITY, PART_MATERIAL, PART_MEMORY, PART_SHAPE = range(PART)
