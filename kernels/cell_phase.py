"""The force pass over packs of cells: gather the corners, do the cell's arithmetic, scatter the corner forces.

The corners of a pack are gathered into vectors over its lanes, the cell's arithmetic works on vectors, and the corner
forces are scattered lane by lane, without atomics, into the force row of their chunk. The vectors are explicit SIMD
values (KEEP_VECTORS, compile_options.py), so nothing depends on what a loop vectoriser makes of the host.

Chunks that own rows (the contact cells once more, for the static solve) give each corner of each cell a row of its own:
there the corner forces stay apart and no node sums them.

`cell_sums` [2 CHUNKS, numbers] (columns.py): the smallest det F is that of all Gauss points (all laws, the
linear one too), the hourglass energy 0 for elements without. With viscosity the pressure that each cell held follows.
"""

import functools

import taichi as ti

from . import elements, laws
from .columns import CELLS, cell_groups, group_size
from .lanes import CHUNKS, TABLE, VISCOSITY
from .vectors import MASK

TINY = 1e-100


@ti.func
def gather(body: ti.template(), start, width: ti.template()):
    """Reference position (3) and displacement (3) of one corner, each a vector over the lanes."""
    # the mask tells the compiler that node + 1 and node + 2 cannot overflow: one address for the three components
    node = [(3 * body.connectivity[start + lane]) & MASK for lane in range(width)]
    return [ti.Vector([body.position[i + c] for i in node]) for c in range(3)] + [
        ti.Vector([body.u[i + c] for i in node]) for c in range(3)
    ]


@ti.func
def gather_velocity(body: ti.template(), start, width: ti.template()):
    """Velocity (3) of one corner, each a vector over the lanes."""
    node = [(3 * body.connectivity[start + lane]) & MASK for lane in range(width)]
    return [ti.Vector([body.v[i + c] for i in node]) for c in range(3)]


@ti.func
def with_mass(body: ti.template(), start, massless, width: ti.template()):
    """1 in lanes where this corner is not one of the massless nodes, the first special ones; else 0."""
    number = ti.Vector([body.node_info[body.connectivity[start + lane]] >> 8 for lane in range(width)])
    zero = ti.Vector([0.0 for _ in range(width)])
    return ti.select(number > massless, zero + 1.0, ti.select(number < 1, zero + 1.0, zero))


@functools.cache
def make_cell_phase(kind: str, law: str, width: int, viscous: bool = False):
    """Cell phase of a kind (names in `elements.FORCES`) with a law (`laws.LAWS`), packed `width` wide; memoised.

    cell_phase(first, end, body, stride) for the chunks first..end of a `bundles.Body`; a kernel that calls it needs
    KEEP_VECTORS (compile_options.py). As an outermost parallel loop stride = GRAIN, inside a serial loop over steps
    stride = 1. viscous: with bulk viscosity (bulk_viscosity.py).
    """
    corners = elements.CORNERS[kind]
    force_of = elements.force_of(kind, law)
    law_of, moduli_count = laws.LAWS[law], laws.MODULI[law]
    lane_numbers = list(range(width))
    numbers = group_size(*cell_groups(viscous))
    viscosity_of = None
    if viscous:
        from .bulk_viscosity import VISCOSITIES

        viscosity_of = VISCOSITIES[kind]

    @ti.func
    def cell_phase(first, end, body: ti.template(), stride: ti.template()):
        for s in range((end - first) * stride):
            if s % stride == 0:
                chunk = first + s // stride
                base = 3 * body.chunk_table[chunk * TABLE + 2]
                cell_end, own = body.chunk_table[chunk * TABLE + 3], body.chunk_table[chunk * TABLE + 4]
                moduli = [body.params[6 + i] for i in range(moduli_count)]
                lanes = ti.Vector(lane_numbers)
                zero = ti.Vector([0.0 for _ in range(width)])
                one = zero + 1.0
                energy = zero
                hourglass = zero
                change = zero + 1e300
                power, fastest = zero, zero
                for pack in range(body.chunk_table[chunk * TABLE], body.chunk_table[chunk * TABLE + 1]):
                    start = pack * (corners * width)
                    corner = [gather(body, start + k * width, width) for k in range(corners)]
                    x = [[corner[k][c] for k in range(corners)] for c in range(3)]
                    y = [[corner[k][3 + c] for k in range(corners)] for c in range(3)]
                    # padding lanes repeat the last cell without stiffness
                    weight = ti.select(lanes + pack * width < cell_end, one, zero)
                    answer = force_of(x, y, [modulus * weight for modulus in moduli], law_of)
                    energy += answer[1]
                    change = ti.min(change, answer[2])
                    if ti.static(len(answer) > 3):
                        hourglass += answer[3]
                    if ti.static(viscous):
                        velocity = [gather_velocity(body, start + k * width, width) for k in range(corners)]
                        here = weight
                        for k in ti.static(range(corners)):
                            here *= with_mass(body, start + k * width, body.params[VISCOSITY + 3], width)
                        w = [[velocity[k][c] for k in range(corners)] for c in range(3)]
                        added = viscosity_of(x, y, w, body.params[VISCOSITY], body.params[VISCOSITY + 1])
                        rate = body.params[VISCOSITY + 4] * here * added[3]
                        fastest = ti.max(fastest, rate)
                        # beyond a stable step, until it is shortened: at most what turns the rate of a cell round
                        most = 2.0 / ti.max(body.params[0] + body.params[1], TINY)
                        density = body.params[VISCOSITY + 2] * here * ti.min(one, most / ti.max(rate, TINY))
                        pressure = density * added[1]
                        held = [2 * CHUNKS * numbers + pack * width + lane for lane in range(width)]
                        power += 0.5 * (pressure + ti.Vector([body.cell_sums[i] for i in held])) * added[2]
                        for lane in ti.static(range(width)):
                            body.cell_sums[held[lane]] = pressure[lane]
                        for c, k in ti.static(ti.ndrange(3, corners)):
                            answer[0][c][k] += density * added[0][c][k]
                    for k in ti.static(range(corners)):
                        for lane in ti.static(range(width)):
                            place = start + k * width + lane
                            row = (3 * ti.select(own == 1, place, body.connectivity[place]) + base) & MASK
                            old = [body.rows[row + c] for c in range(3)]
                            for c in ti.static(range(3)):
                                body.rows[row + c] = old[c] + answer[0][c][k][lane]
                body.cell_sums[chunk * numbers + CELLS.elastic] = energy.sum()
                body.cell_sums[chunk * numbers + CELLS.jacobian_min] = 1.0 + change.min()
                body.cell_sums[chunk * numbers + CELLS.hourglass] = hourglass.sum()
                if ti.static(viscous):
                    body.cell_sums[chunk * numbers + CELLS.viscous_power] = power.sum()
                    body.cell_sums[chunk * numbers + CELLS.viscous_rate] = fastest.max()

    return cell_phase
