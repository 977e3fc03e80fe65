"""Places of the data of loads behind the loads [s, 3] of the boundary nodes; host and kernels share them.

The data begin with the numbers below: counts and switches, whole numbers as floating-point ones. Then follow
    nodes    [NODES, NODE]: boundary node; FORCE on it now, the force FORCE_BEFORE and the displacement PLACE_BEFORE of
             the last level (3 each)
    entries  [ENTRIES, ENTRY]: number among these nodes, weight, place in a row of the three numbers it multiplies
    faces    [FACES, FACE]: four nodes of the domain, four numbers among the nodes above, place of the pressure in a row
    rows     [levels, STRIDE]: numbers of a time level: gravity (3) if it is a function of time, then those of the loads
"""

# row length, 0 if one row holds at every level; counts; place of their sums in `sums`; 1: gravity is a function of
# time; 1: some forces depend on positions and velocities, so that the host computes the row as soon as the nodes have
# moved; 1: a level has been measured
STRIDE, NODES, ENTRIES, FACES, SUMS_AT, PULLS, ASKS, STARTED = range(8)
HEAD = 8
NODE, ENTRY, FACE = 10, 3, 9
FORCE, FORCE_BEFORE, PLACE_BEFORE = 1, 4, 7
