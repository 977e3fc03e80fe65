"""Sizes that the host and the kernels agree on: packed cells (tcontact/packing.py), sweeps, contact."""

GRAIN = 512  # a parallel loop gives each thread at least this many iterations: one in so many does the work
CHUNKS = 8  # fixed number of force rows: the same bits at any thread count
WIDTHS = dict.fromkeys(  # lanes of a pack
    ("hex8", "hex8-affine", "hex8-reduced", "hex8-mean-dilatation", "hex8-mean-dilatation-affine", "tet4"), 8
)
TABLE = 5  # numbers per chunk in chunk_table: first pack, end pack, row base, end of its cells, 1 if they own rows
OBSTACLE = 33  # of an obstacle (obstacles.py)
FRICTION_NODE, FRICTION_TRACE = 9, 13  # of friction per contact node, and per slot of one (friction.py)
MOST_SLOTS = 3  # obstacles that can hold one node at a time
MODULI = 3  # places in `params` for the constants of the law; some laws leave the last at 0
# places in `params` that only some bodies have
VISCOSITY = 9  # c1 c [m/s], c2^2, density [kg/m^3], number of massless nodes, mean over smallest corner mass of a cell
DAMPING = 14  # constants of the law of damping; the last ones
SWEEP_LANES = 4  # contact nodes of one colour that a sweep takes at once
