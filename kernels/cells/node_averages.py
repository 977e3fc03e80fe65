"""Volume changes of cells averaged at nodes: th_a of a volume node, and what the cells of a pack take from theirs.

A volume node is a node with the cells of one block round it, so that an average never crosses bodies or materials; the
images of a periodic body have the average of their master. Its number is the node plus the shift of the block. Every
average is summed in the order of its list: it has the same bits on any number of threads. Places: volume_places.py.
"""

from ..elements.tet4_node_averaged import linear_tet_volume, tet_volume
from ..engine import ti
from ..lanes import CONNECTIVITY, LANE, SEGMENT
from ..language.vectors import load
from ..volume_places import CHANGES, INVERSES, NUMBERS, RING, RING_CELL, RING_CELLS, SHARES, SHIFTS, STARTS


@ti.func
def place(body: ti.template(), number: ti.template()):
    """Return one of the places and counts."""
    return body.volume_lists[number]


@ti.func
def average(body: ti.template(), i):
    """Set th_a of volume node i of the list from the changes of its cells."""
    total, first = 0.0, place(body, STARTS) + i
    for j in range(body.volume_lists[first], body.volume_lists[first + 1]):
        total += body.volumes[body.volume_lists[j]]
    number = body.volume_lists[place(body, NUMBERS) + i]
    body.volumes[place(body, CHANGES) + number] = total * body.volumes[place(body, INVERSES) + i]


@ti.func
def averages_of(body: ti.template(), segment, pack, corners: ti.template(), width: ti.template()):
    """Return w_e, and [J_a - 1 of each corner], of the cells of a pack of a segment."""
    start = body.segments[segment * SEGMENT + CONNECTIVITY] + pack * (corners * width)
    lane = body.segments[segment * SEGMENT + LANE] + pack * width
    shift = place(body, CHANGES) + body.volume_lists[place(body, SHIFTS) + segment]
    number = [[shift + body.connectivity[start + k * width + i] for i in range(width)] for k in range(corners)]
    changes = [ti.Vector([body.volumes[i] for i in number[k]]) for k in range(corners)]
    return [load(body.volumes, place(body, SHARES) + lane, width), changes]


@ti.func
def ring_changes(body: ti.template()):
    """Store the changes of the cells round the ring that are no contact cells; a static solve does not change them."""
    for i in range(place(body, RING_CELLS)):
        at = place(body, RING) + i * RING_CELL
        lane = body.volume_lists[at]
        node = [3 * body.volume_lists[at + 2 + k] for k in range(4)]
        x = [[body.position[node[k] + c] for k in range(4)] for c in range(3)]
        u = [[body.u[node[k] + c] for k in range(4)] for c in range(3)]
        change = tet_volume(x, u)
        if body.volume_lists[at + 1] == 1:
            change = linear_tet_volume(x, u)
        body.volumes[lane] = change * body.volumes[place(body, SHARES) + lane]
