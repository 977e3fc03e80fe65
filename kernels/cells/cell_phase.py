"""The force pass over packs of cells: gather the corners, do the cell's arithmetic, scatter the corner forces.

A pack holds one cell per lane. Its corners are gathered into vectors over the lanes, the arithmetic of the cell works
on vectors, and the corner forces are scattered lane by lane, without atomics, into the force rows of their chunk. The
vectors are explicit SIMD values (KEEP_VECTORS, compile_options.py) and do not depend on a loop vectoriser.

The forces of cells with one point are scattered when the next pack has been gathered, so that the processor overlaps
the scatter of one pack with the arithmetic of the next, whose results wait for each other. Elements with several points
loop over them, and gain nothing by it. The first scatter of a segment adds zeros. Cells with stored shapes read these
numbers instead of positions; the loads stand before the scatter, which hides their latency.

In chunks of contact cells each corner of each cell has its own force row (`corner_rows` lists those of a boundary
node), so that the static solve can read the corner forces; the node phase sums them from there. These rows stand in the
order of the corners: in the scatter the whole numbers at the end of `connectivity` take the place of the nodes.

A chunk has packs of every block of cells (an element with a law and its constants, tcontact/planning/packing.py). Its
segments with cells of kind i, of the kinds the kernel is made for, are chunk_table[chunk * (kinds + 3) + i] up to the
entry of kind i + 1. The next two entries are the start of its force rows less its first node, and 1 for contact cells.

`cell_sums` [chunks, numbers] (columns.py): the smallest det F is over all Gauss points; the hourglass energy is 0 for
elements without hourglass modes. The linear law has no limit on det F: beside nonlinear laws its cells do not enter the
smallest det F. With viscosity the viscous pressure of each cell follows. Laws with plastic flow add the energies that
their points dissipate, which are those of the step that ends at the present state.
"""

import functools

from .. import elements
from ..columns import CELLS, cell_groups, group_size, places
from ..engine import ti
from ..lanes import (
    CHUNK_BITS,
    CHUNK_COUNT,
    CONNECTIVITY,
    COUNTING,
    END_CELL,
    END_PACK,
    FIRST_PACK,
    KICK_AFTER,
    KICK_BEFORE,
    LAME,
    LANE,
    MASSLESS,
    MATERIAL,
    MEMORY,
    ROW,
    SEGMENT,
    SHAPE,
    STEP,
    VISCOSITY,
    WIDTH,
)
from ..language.point_memory import RELEASED, STRAIN, WARMING, WORK, PointMemory, constants_of, heat_points
from ..language.vectors import MASK, load
from ..materials import LAWS
from .mixed_cells import by_kind_of_cell, single_force, single_viscosity
from .node_averages import averages_of

TINY = 1e-100


@ti.func
def gather(body: ti.template(), start, width: ti.template()):
    """Return reference position (3) and displacement (3) of one corner, each component a vector over the lanes."""
    # the mask tells the compiler that node + 1 and node + 2 cannot overflow: one address for the three components
    node = [(3 * body.connectivity[start + lane]) & MASK for lane in range(width)]
    return [ti.Vector([body.position[i + c] for i in node]) for c in range(3)] + [
        ti.Vector([body.u[i + c] for i in node]) for c in range(3)
    ]


@ti.func
def gather_velocity(body: ti.template(), start, width: ti.template()):
    """Return the velocity (3) of one corner, each component a vector over the lanes."""
    node = [(3 * body.connectivity[start + lane]) & MASK for lane in range(width)]
    return [ti.Vector([body.v[i + c] for i in node]) for c in range(3)]


@ti.func
def with_mass(body: ti.template(), start, massless, width: ti.template()):
    """Return 0 in lanes where this corner is a massless node (these are the first boundary nodes), else 1."""
    number = ti.Vector([body.node_info[body.connectivity[start + lane]] >> (2 * CHUNK_BITS) for lane in range(width)])
    zero = ti.Vector([0.0 for _ in range(width)])
    return ti.select(number > massless, zero + 1.0, ti.select(number < 1, zero + 1.0, zero))


@ti.func
def massless_velocity(body: ti.template(), start, velocity, width: ti.template()):
    """Return the velocity (3) of one corner in the last step: of a massless node the difference of its positions."""
    step = body.params[STEP]
    rate = ti.select(step > 0.0, 1.0 / ti.max(step, TINY), 0.0)  # at the start, and in products, they have none
    massless = 1.0 - with_mass(body, start, body.params[MASSLESS], width)
    node = [3 * body.connectivity[start + lane] for lane in range(width)]
    number = [body.node_info[body.connectivity[start + lane]] >> (2 * CHUNK_BITS) for lane in range(width)]
    at = [ti.select(massless[lane] > 0.0, 3 * number[lane] - 2, 1) for lane in range(width)]
    moved = [
        rate * ti.Vector([body.u[node[lane] + c] - body.bulk_viscosity[at[lane] + c] for lane in range(width)])
        for c in range(3)
    ]
    return [ti.select(massless > 0.0, moved[c], velocity[c]) for c in range(3)]


@ti.func
def keep_places(body: ti.template(), boundary: ti.template()):
    """Keep the displacements of the massless nodes until the next time level."""
    for s in range(int(body.params[MASSLESS])):
        for c in ti.static(range(3)):
            body.bulk_viscosity[1 + 3 * s + c] = body.u[3 * boundary.nodes[s] + c]


@ti.func
def add_force(body: ti.template(), place, first_row, force):
    """Add the force (3) of the corner at `place` of `connectivity` to its row."""
    row = (3 * body.connectivity[place] + first_row) & MASK
    old = [body.rows[row + c] for c in range(3)]
    for c in ti.static(range(3)):
        body.rows[row + c] = old[c] + force[c]


def make_block_phase(kind: str, law: str, viscous: bool, cornered: bool, plastic_sums: bool, mixed: bool = False):
    """Return block_phase(body, base, own, first, end, commit): the force pass over cells of a kind and law in a chunk.

    base: start of the force rows of the chunk; own: 1 for contact cells, which the kernel has if cornered; first..end:
    segments; mixed: the arithmetic of the cells is float32 (mixed_cells.py). It returns elastic energy, smallest
    det F - 1, hourglass energy, viscous power and largest viscous rate, then of a law with plastic flow the work and
    heat of the step, the energy that hourglass modes let go, the largest temperature and plastic strain.
    """
    corners, width = elements.CORNERS[kind], WIDTH
    force_of = elements.force_of(kind, law)
    law_of, size = LAWS[law], len(LAWS[law].state)
    constants_end = len(law_of.parameters)
    numbers, plastic = group_size(*cell_groups(viscous, plastic_sums)), law_of.plastic
    point_share, flows = elements.FUNCTIONS[kind].share, plastic is not None
    points = elements.FUNCTIONS[kind].points
    pack_memory = points * size * width
    lane_numbers = list(range(width))
    viscosity_of, averaged = elements.FUNCTIONS[kind].viscosity, elements.FUNCTIONS[kind].averaged
    stored, delays = elements.FUNCTIONS[kind].stored, points == 1
    spills = corners == 8 and points > 1
    if mixed:
        force_of = single_force(force_of, law_of, stored, averaged)
        viscosity_of = single_viscosity(viscosity_of)

    @ti.func
    def answer_of(
        body: ti.template(),
        segment,
        pack,
        x: ti.template(),
        y: ti.template(),
        weight: ti.template(),
        parameters: ti.template(),
        memory: ti.template(),
        shape: ti.template(),
        unit,
    ):
        if ti.static(mixed and averaged):
            averages = averages_of(body, segment, pack, corners, width)
            return force_of(x, y, weight, parameters, memory, unit, averages)
        elif ti.static(mixed and stored):
            return force_of(shape, y, weight, parameters, memory, unit)
        elif ti.static(mixed):
            return force_of(x, y, weight, parameters, memory, unit)
        elif ti.static(averaged):
            averages = averages_of(body, segment, pack, corners, width)
            return force_of(x, y, weight, parameters, law_of, memory, averages)
        elif ti.static(stored):
            return force_of(shape, y, weight, parameters, law_of, memory)
        else:
            return force_of(x, y, weight, parameters, law_of, memory)

    @ti.func
    def viscous_answer(x: ti.template(), y: ti.template(), w: ti.template(), half, speed, square, unit):
        if ti.static(mixed):
            return viscosity_of(x, y, w, half, speed, square, unit)
        else:
            return viscosity_of(x, y, w, half, speed, square)

    @ti.func
    def unit_of(body: ti.template(), material):
        """Return the length in which a pass in mixed precision measures the cells, else 1."""
        if ti.static(mixed):
            return body.params[material + constants_end]
        else:
            return 1.0

    @ti.func
    def scatter(body: ti.template(), at, pack, base, own, force: ti.template()):
        """Add the corner forces of the cells of a pack, component by component of every corner, to their rows."""
        start = body.segments[at + CONNECTIVITY] + pack * (corners * width)
        rows_at, first_row = start, base
        if ti.static(cornered):
            if own == 1:
                rows_at = body.connectivity.shape[0] - COUNTING
                first_row = 3 * (body.segments[at + ROW] + start)
                for i in range(3 * corners * width):
                    body.rows[first_row + i] = 0.0
        rows_at = rows_at & MASK
        if ti.static(spills):
            # lanes are read by a number of the run, not of the compiler: the vectors stand in aligned memory, and so do
            # the registers that a hexahedron spills
            for lane in range(width):
                for k in ti.static(range(corners)):
                    own_force = [force[c * corners + k][lane] for c in range(3)]
                    add_force(body, rows_at + k * width + lane, first_row, own_force)
        else:
            for k in ti.static(range(corners)):
                for lane in ti.static(range(width)):
                    own_force = [force[c * corners + k][lane] for c in range(3)]
                    add_force(body, rows_at + k * width + lane, first_row, own_force)

    @ti.func
    def block_phase(body: ti.template(), base, own, first, end, commit):
        lanes = ti.Vector(lane_numbers)
        zero = ti.Vector([0.0 for _ in range(width)])
        one = zero + 1.0
        energy = zero
        hourglass = zero
        change = zero + 1e300
        power, fastest = zero, zero
        work, heat, released, hottest, longest = zero, zero, zero, zero, zero
        for segment in range(first, end):
            at = segment * SEGMENT
            cell_end, material = body.segments[at + END_CELL], body.segments[at + MATERIAL]
            parameters = constants_of(body, material, law_of)
            unit = unit_of(body, material)
            first_pack, end_pack = body.segments[at + FIRST_PACK], body.segments[at + END_PACK]
            delayed = [zero + 0.0 for _ in range(3 * corners if delays else 0)]  # corner forces of the pack before
            for pack in range(first_pack, end_pack):
                start = body.segments[at + CONNECTIVITY] + pack * (corners * width)
                corner = [gather(body, start + k * width, width) for k in range(corners)]
                x = [[corner[k][c] for k in range(corners)] for c in range(3)]
                y = [[corner[k][3 + c] for k in range(corners)] for c in range(3)]
                # padding lanes repeat the last cell with no weight
                weight = ti.select(lanes + pack * width < cell_end, one, zero)
                memory_at = body.segments[at + MEMORY] + pack * pack_memory
                tally = [zero for _ in range(4)]
                memory = ti.static(
                    PointMemory(body.memory, memory_at, size, width, commit, (), tally if flows else None)
                    if size
                    else None
                )
                shape_at = body.segments[at + SHAPE] + pack * (stored * width)
                shape = [load(body.position, shape_at + i * width, width) for i in range(stored)]
                if ti.static(delays):
                    scatter(body, at, ti.max(pack - 1, first_pack), base, own, delayed)
                answer = answer_of(body, segment, pack, x, y, weight, parameters, memory, shape, unit)
                energy += answer[1]
                change = ti.min(change, answer[2])
                if ti.static(len(answer) > 3):
                    hourglass += answer[3]
                if ti.static(plastic):
                    dissipated = point_share * weight * tally[WORK]
                    work += dissipated
                    heat += parameters[plastic.share] * dissipated
                    released += point_share * weight * tally[RELEASED]
                    hottest = ti.max(hottest, parameters[plastic.initial_temperature] + tally[WARMING])
                    longest = ti.max(longest, tally[STRAIN])
                if ti.static(viscous):
                    velocity = [gather_velocity(body, start + k * width, width) for k in range(corners)]
                    here = weight
                    if ti.static(flows):
                        if ti.static(cornered):
                            if own == 1:
                                for k in ti.static(range(corners)):
                                    moved = massless_velocity(body, start + k * width, velocity[k], width)
                                    for c in ti.static(range(3)):
                                        velocity[k][c] = moved[c]
                    else:
                        for k in ti.static(range(corners)):
                            here *= with_mass(body, start + k * width, body.params[MASSLESS], width)
                    w = [[velocity[k][c] for k in range(corners)] for c in range(3)]
                    constants = [body.params[material + VISCOSITY + i] for i in range(LAME - VISCOSITY)]
                    half = 0.5 * ti.max(body.params[STEP], 0.0)
                    added = viscous_answer(x, y, w, half, constants[0], constants[1], unit)
                    rate = constants[3] * here * added[3]
                    fastest = ti.max(fastest, rate)
                    # cap the viscous pressure so that it at most reverses the strain rate of a cell: until a step above
                    # the stable one is shortened
                    limit = 2.0 / ti.max(body.params[KICK_BEFORE] + body.params[KICK_AFTER], TINY)
                    density = constants[2] * here * ti.min(one, limit / ti.max(rate, TINY))
                    if ti.static(flows and cornered):
                        if own == 1:
                            step = body.params[STEP]
                            density = ti.select(zero + step > 0.0, density, zero)
                            slope = density * added[5] / ti.max(step, TINY)
                            place = 1 + 3 * int(body.params[MASSLESS]) - int(body.bulk_viscosity[0])
                            place += body.segments[at + LANE] + pack * width
                            for lane in ti.static(range(width)):
                                body.bulk_viscosity[place + lane] = slope[lane]
                    pressure = density * added[1]
                    first_lane = body.segments[at + LANE] + pack * width
                    held_at = ti.cast(body.params[CHUNK_COUNT], ti.i32) * numbers + first_lane
                    held = [held_at + lane for lane in range(width)]
                    dissipation = 0.5 * (pressure + ti.Vector([body.cell_sums[i] for i in held])) * added[2]
                    power += dissipation
                    if ti.static(flows):
                        if commit != 0 and parameters[2] > 0.0:
                            rise = parameters[2] * body.params[STEP] * dissipation / added[4]
                            warmest = heat_points(law_of, parameters, memory, points, rise)
                            hottest = ti.max(hottest, parameters[plastic.initial_temperature] + warmest)
                    keeps = commit if ti.static(flows) else 1  # measures of contact cells must not
                    if keeps != 0:
                        for lane in ti.static(range(width)):
                            body.cell_sums[held[lane]] = pressure[lane]
                    for c, k in ti.static(ti.ndrange(3, corners)):
                        answer[0][c][k] += density * added[0][c][k]
                force = [answer[0][c][k] for c in range(3) for k in range(corners)]
                if ti.static(delays):
                    for i in ti.static(range(3 * corners)):
                        delayed[i] = force[i]
                else:
                    scatter(body, at, pack, base, own, force)
            if ti.static(delays):
                scatter(body, at, end_pack - 1, base, own, delayed)
        answer = [energy.sum(), change.min(), hourglass.sum(), power.sum(), fastest.max()]
        if ti.static(plastic):
            return answer + [work.sum(), heat.sum(), released.sum(), hottest.max(), longest.max()]
        else:
            return answer

    return block_phase


def only_places_matter(kinds: tuple[tuple[str, str], ...]) -> bool:
    """Return whether the force of these kinds of cells (without viscosity) is a function of their nodes alone."""
    return not any(LAWS[law].state or elements.FUNCTIONS[kind].averaged for kind, law in kinds)


@functools.cache
def make_cell_phase(kinds: tuple[tuple[str, str], ...], viscous: bool, cornered: bool, mixed: bool = False):
    """Return cell_phase(first, end, body, stride, commit), the force pass over chunks first..end; memoised.

    kinds: of cells, each an element (a name in `elements.FUNCTIONS`) with a law (a name in `materials.LAWS`); viscous:
    with bulk viscosity (bulk_viscosity.py); cornered: with contact cells; stride: GRAIN as an outermost parallel loop,
    1 inside a serial loop over steps; commit: 1 if laws with state store it (point_memory.py); mixed: ordinary cells
    compute in float32, contact cells and products for the stable step in float64 (mixed_cells.py). A kernel that calls
    it needs KEEP_VECTORS (compile_options.py).
    """
    flowing = [LAWS[law].plastic is not None for _, law in kinds]
    plastic = any(flowing)
    phases = [make_block_phase(kind, law, viscous, cornered, plastic) for kind, law in kinds]
    if mixed:
        quick = [make_block_phase(kind, law, viscous, False, plastic, mixed) for kind, law in kinds]
        phases = [
            by_kind_of_cell(exact, rough, LAWS[law].plastic is not None)
            for exact, rough, (_, law) in zip(phases, quick, kinds, strict=True)
        ]
    count, numbers = len(kinds), group_size(*cell_groups(viscous, plastic))
    flow = places(*cell_groups(viscous, plastic))
    limiting = [not LAWS[law].linear for _, law in kinds]
    judged = limiting if any(limiting) else [True] * count

    @ti.func
    def cell_phase(first, end, body: ti.template(), stride: ti.template(), commit):
        for s in range((end - first) * stride):
            if s % stride == 0:
                chunk = first + s // stride
                if ti.static(cornered):
                    # in turns, so that threads that take half of the loop each take half of the work
                    if first == 0 and end == int(body.params[CHUNK_COUNT]):
                        chunk = chunk // 2 + chunk % 2 * (end // 2)
                table = chunk * (count + 3)
                base, own = 3 * body.chunk_table[table + count + 1], body.chunk_table[table + count + 2]
                energy, hourglass, power, fastest, change = 0.0, 0.0, 0.0, 0.0, 1e300
                work, heat, released, hottest, longest = 0.0, 0.0, 0.0, 0.0, 0.0
                for i in ti.static(range(count)):
                    start, stop = body.chunk_table[table + i], body.chunk_table[table + i + 1]
                    part = phases[i](body, base, own, start, stop, commit)
                    energy += part[0]
                    if ti.static(judged[i]):
                        change = ti.min(change, part[1])
                    hourglass += part[2]
                    power += part[3]
                    fastest = ti.max(fastest, part[4])
                    if ti.static(flowing[i]):
                        work += part[5]
                        heat += part[6]
                        released += part[7]
                        hottest, longest = ti.max(hottest, part[8]), ti.max(longest, part[9])
                place = chunk * numbers
                body.cell_sums[place + CELLS.elastic] = energy
                body.cell_sums[place + CELLS.jacobian_min] = 1.0 + change
                body.cell_sums[place + CELLS.hourglass] = hourglass
                if ti.static(viscous):
                    body.cell_sums[place + CELLS.viscous_power] = power
                    body.cell_sums[place + CELLS.viscous_rate] = fastest
                if ti.static(plastic):
                    body.cell_sums[place + flow.plastic_step] = work
                    body.cell_sums[place + flow.heat_step] = heat
                    body.cell_sums[place + flow.hourglass_step] = released
                    body.cell_sums[place + flow.temperature_max] = hottest
                    body.cell_sums[place + flow.plastic_strain_max] = longest

    return cell_phase
