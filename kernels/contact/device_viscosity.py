"""The viscous force of one contact cell on a GPU, where each thread takes a cell (cell_viscosity.py).

In the array `viscous` the lanes stand kind by kind, as they are counted in `DeviceLists.contact_parts`; the corner
forces [pack, corner, component, lane] stand as `corner_forces` of the cells, from the first contact cell on; behind eta
by cells follows, for every kind of cells, its first lane.
"""

from .. import elements
from ..engine import ti
from ..lanes import CHUNK_BITS, LAME, PART_CONNECTIVITY, PART_MATERIAL, WIDTH
from ..nodes.device_nodes import first_of_corner
from .cell_viscosity import FIRST_ROW, NUMBERS, eta_place, rows_place, step_parts


def make_device_viscosity(kind: str, law: str, number: int, kinds: int):
    """Return device_viscosity(body, lists, viscous, rate, at, lane, cell): it sets the viscous corner forces of a cell.

    number: of its kind among `kinds` kinds of cells; rate [1/s]: inverse of the step that ends at the present state;
    at: its part in `lists.contact_parts`; lane: its lane among those of its kind; cell: its number in the part.
    """
    corners = elements.CORNERS[kind]
    force_of, law_of, place_of = step_parts(kind, law, thread=True)

    @ti.func
    def device_viscosity(body: ti.template(), lists: ti.template(), viscous: ti.template(), rate, at, lane, cell):
        start = lists.contact_parts[at + PART_CONNECTIVITY] + cell // WIDTH * (corners * WIDTH) + cell % WIDTH
        material = lists.contact_parts[at + PART_MATERIAL] + LAME
        node = [body.connectivity[start + k * WIDTH] for k in range(corners)]
        now = [[body.u[3 * i + c] for i in node] for c in range(3)]
        rest = [[body.position[3 * i + c] for i in node] for c in range(3)]
        before = [NUMBERS + 3 * ((body.node_info[i] >> (2 * CHUNK_BITS)) - 1) for i in node]
        d = [[now[c][k] - viscous[before[k] + c] for k in range(corners)] for c in range(3)]
        corner = [[rest[c][k] for c in range(3)] + [now[c][k] for c in range(3)] for k in range(corners)]
        x = [[place_of(corner[k], c) for k in range(corners)] for c in range(3)]
        first_lane = int(viscous[viscous.shape[0] - kinds + number])
        eta = viscous[eta_place(viscous) + first_lane + lane]
        stiffness = [rate * body.params[material], rate * body.params[material + 1]]
        answer = force_of(x, d, eta, stiffness, law_of, None)
        first = rows_place(viscous) + first_of_corner(start - int(viscous[FIRST_ROW]))
        for k, c in ti.static(ti.ndrange(corners, 3)):
            viscous[first + (3 * k + c) * WIDTH] = answer[0][c][k]

    return device_viscosity
