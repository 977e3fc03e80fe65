"""Table of places: where the rows of pairs of bodies stand in `Coupling.lists` and `Coupling.values` (pair_rows.py).

Host and kernels share the table; it is plain data.
"""

# `lists` begins with the number of rows; with the places in `lists` of: the slave of every row (boundary node), first
# entry of every row and the end, masters (boundary nodes) and 2 * pair + (0 if the slave is the pair's first body) of
# the entries, first face of every row and the end, faces (4 nodes each; a triangle has its last node twice), row of
# every contact node (-1: none), boundary nodes of all surfaces and their number; with the places in `values` of:
# weights of the entries, weights of the faces, numbers of the rows, displacements (3) of the surface nodes at the
# search; with the number of pairs; and, with friction, with the place in `values` of the velocities (3) [m/s] of the
# boundary nodes after the kick
ROWS, SLAVES, FIRST_ENTRY, MASTERS, SIDES, FIRST_FACE, FACES, NODE_ROW, SURFACE, SURFACE_NODES = range(10)
WEIGHTS, FACE_WEIGHTS, NUMBERS, SEARCHED = range(10, 14)
PAIRS = 14  # number of pairs
VELOCITIES = 15
LISTS_HEADER = 16
# `values` begins with a point near the surfaces (3) [m], to which positions are relative; the displacement [m] at which
# the search must be repeated; 1 if the rows must be built anew; the largest slip [m]; which contact
# node is deep in which of its constraint rows while another one presses it (static/chosen_rows.py), 0 without any
CENTRE, MARGIN, STALE, SLIP, SQUEEZED = 0, 3, 4, 5, 6
VALUES_HEADER = 7
# numbers of a row: vector from the masters to the slave when it was built (3) [m]; its normal (3) if it is the same in
# the whole run, else 0; gap that counts as closed [m]; slip at which it is built anew [m]; area [m^2]; depth in an
# obstacle [m] beyond which its slave is squeezed
ORIGIN, NORMAL, CLOSED, SLIP_LIMIT, AREA, DEEP = 0, 3, 6, 7, 8, 9
ROW_NUMBERS = 10
# numbers that a pair of faces has after its integration (clipping.py): integrals of N_s N_s' (4 x 4) and N_s N_m'
# (4 x 4) [m^2], the area in common [m^2], the smallest distance [m], and the smallest gap [m] of the points of
# integration and of the corners of the part in common
SLAVE_PRODUCTS, MASTER_PRODUCTS, COMMON_AREA, DISTANCE, POINT_GAP, CORNER_GAP = 0, 16, 32, 33, 34, 35
INTEGRALS = 36
