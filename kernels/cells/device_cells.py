"""The force of one cell on a GPU, where each thread takes a cell: f = dW/du of its corners, from the packs of the CPU.

The element and the law are those of the force pass (cell_phase.py), called with scalars instead of vectors of lanes.
The cells stand in the same packs [corner][lane]: neighbouring threads take the lanes of a pack, and a pack of numbers
of 8 lanes is 64 contiguous bytes. Each cell stores its corner forces in places of its own, without atomics, in
`corner_forces` [pack, corner, component, lane]; the nodes add them up in a fixed order (nodes/device_nodes.py).
"""

from .. import elements
from ..engine import ti
from ..lanes import PART_CONNECTIVITY, PART_MATERIAL, PART_MEMORY, PART_SHAPE, WIDTH
from ..language.point_memory import RELEASED, STRAIN, WARMING, WORK, PointMemory
from ..materials import LAWS
from ..nodes.device_nodes import first_of_corner

# what `device_cell` returns, by the names of the columns (columns.py)
CELL_NUMBERS = ("elastic", "jacobian_min", "hourglass")
FLOW_NUMBERS = ("plastic_step", "heat_step", "hourglass_step", "temperature_max", "plastic_strain_max")


def make_device_cell(kind: str, law: str):
    """Return device_cell(body, lists, at, cell, before, commit): the force of one cell of an element and a law.

    at: its part in `lists.parts` (lanes.py); cell: its number there; before [s]: the step that ends at the present
    state; commit: 1 if the points store their new state. It stores the corner forces and returns CELL_NUMBERS, with
    det F - 1 for det F, and of a law with plastic flow also FLOW_NUMBERS.
    """
    corners = elements.CORNERS[kind]
    force_of, functions, law_of = elements.thread_force_of(kind, law), elements.FUNCTIONS[kind], LAWS[law]
    size, stored, plastic = len(law_of.state), functions.stored, law_of.plastic
    pack_memory, share, flows = functions.points * size * WIDTH, functions.share, plastic is not None
    count, rates = len(law_of.parameters), law_of.rates

    @ti.func
    def device_cell(body: ti.template(), lists: ti.template(), at, cell, before, commit):
        pack, lane = cell // WIDTH, cell % WIDTH
        material = lists.parts[at + PART_MATERIAL]
        parameters = [body.params[material + i] for i in range(count)] + [before for _ in range(1 if rates else 0)]
        start = lists.parts[at + PART_CONNECTIVITY] + pack * (corners * WIDTH) + lane
        node = [3 * body.connectivity[start + k * WIDTH] for k in range(corners)]
        y = [[body.u[i + c] for i in node] for c in range(3)]
        tally = [0.0 for _ in range(4)]
        memory_at = lists.parts[at + PART_MEMORY] + pack * pack_memory + lane
        memory = ti.static(
            PointMemory(body.memory, memory_at, size, WIDTH, commit, (), tally if flows else None, True)
            if size
            else None
        )
        shape_at = lists.parts[at + PART_SHAPE] + pack * (stored * WIDTH) + lane
        rest = [[body.position[i + c] for i in node] for c in range(0 if stored else 3)]
        shape = [body.position[shape_at + i * WIDTH] for i in range(stored)]
        answer = force_of(rest + shape, y, 1.0, parameters, law_of, memory)  # an element takes one of the two
        for k, c in ti.static(ti.ndrange(corners, 3)):
            lists.corner_forces[first_of_corner(start + k * WIDTH) + c * WIDTH] = answer[0][c][k]
        hourglass = [answer[i] for i in range(3, len(answer))] + [0.0 for _ in range(len(answer), 4)]
        found = [answer[1], answer[2]] + hourglass
        if ti.static(plastic):
            work = share * tally[WORK]
            hottest = parameters[plastic.initial_temperature] + tally[WARMING]
            heat, released = parameters[plastic.share] * work, share * tally[RELEASED]
            return found + [work, heat, released, hottest, tally[STRAIN]]
        else:
            return found

    return device_cell
