"""Places in `Body.volume_lists` and `Body.volumes`: cells whose volume change is averaged at nodes.

Host (tcontact/planning/node_volumes.py) and kernels (cells/node_averages.py, static/averaged_tangent.py) share them.

`volume_lists` begins with the numbers below: counts, or places. Then it holds, at
    SHIFTS   [segments]: the number of a volume node of this segment less that of the node
    NUMBERS  [COUNT]: numbers of the volume nodes, the RING_COUNT first ones those next to contact cells, the "ring"
    STARTS   [COUNT + 1]: where the lanes of the cells round each of them begin, and behind these the lanes
    RING     [RING_CELLS, RING_CELL]: cells round the ring but for contact cells: lane, 1 for the linear law, corners
    BLOCKS   [contact blocks, 2]: shift as above, and lane of the first contact cell
    MEMBERS  [k + 1]: the first member of each contact node: a contact node and a volume node that share a cell
    TERMS    [members + 1]: where the terms of each member begin, and behind these the terms: contact cell * 4 + corner
    PRODUCTS [e + 1]: where the products of each entry of K_KK begin, and behind these the products: two members
`volumes` holds w_e V_e (J_e - 1) of every lane from 0 on, then, at
    SHARES   [lanes]: w_e
    CHANGES  [numbers]: th_a
    INVERSES [COUNT]: 1/V_a
    SPREADS  [contact cells, 4, 3]: w_e dv_e/du of the corners
    SLOPES   [members, 4]: the sum of these over the terms in the massless directions, and parameters[0]/V_a
"""

COUNT, RING_COUNT, RING_CELLS = 0, 1, 2
SHIFTS, NUMBERS, STARTS, RING, BLOCKS, MEMBERS, TERMS, PRODUCTS = 3, 4, 5, 6, 7, 8, 9, 10
SHARES, CHANGES, INVERSES, SPREADS, SLOPES = 11, 12, 13, 14, 15
HEAD = 16
RING_CELL = 6
SLOPE = 4
CORNERS = 4
