"""Sizes that the host and the kernels agree on: packed cells (tcontact/packing.py), sweeps, sums of a row."""

GRAIN = 512  # a parallel loop gives each thread at least this many iterations: one in so many does the work
CHUNKS = 8  # fixed number of force rows: the same bits at any thread count
WIDTH = 8  # lanes of a pack
TABLE = 5  # numbers per chunk in chunk_table: first pack, end pack, row base, end of its cells, 1 if they own rows
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
LAW_AT, LAW_PARAMETERS = 6, 8  # the parameters of the law in `params`, and how many have room there
# places in `params` that only some bodies have
DAMPING_RATE = LAW_AT + LAW_PARAMETERS  # [1/s]
VISCOSITY = (
    DAMPING_RATE + 1
)  # c1 c [m/s], c2^2, density [kg/m^3], number of massless nodes, mean over smallest corner mass of a cell
VISCOUS_SUMS = 2  # dissipated power [W], largest rate of a cell [1/s]; per chunk they stand after all the cell sums
VISCOUS_START = 2 * CHUNKS * CELL_SUMS
VISCOUS_HELD = VISCOUS_START + 2 * CHUNKS * VISCOUS_SUMS  # and then the viscous pressure of every cell
SWEEP_LANES = 4  # contact nodes of one colour that a sweep takes at once
