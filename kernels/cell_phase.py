"""The force pass over packs of cells: gather the corners, do the cell's arithmetic, scatter the corner forces.

The corners of a pack are gathered into vectors over its lanes, the cell's arithmetic works on vectors, and the corner
forces are scattered lane by lane, without atomics, into the force row of their chunk. The vectors are explicit SIMD
values (KEEP_VECTORS, compile_options.py), so nothing depends on what a loop vectoriser makes of the host.

Chunks that own rows (the contact cells once more, for the static solve) give each corner of each cell a row of its own:
there the corner forces stay apart and no node sums them.

`cell_sums` [chunks*3]: elastic energy [J], smallest det F over the Gauss points (all laws, the linear one too), and the
part of the elastic energy that is hourglass energy [J] (0 for elements without); after all chunks those of viscosity,
then the pressure each cell held.
"""

import functools

import taichi as ti

from . import elements
from .lanes import (
    CELL_SUMS,
    LAW_AT,
    TABLE,
    VISCOSITY,
    VISCOUS_HELD,
    VISCOUS_START,
    VISCOUS_SUMS,
)
from .materials import LAWS
from .point_memory import PointMemory
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
    """Return the cell phase of a kind (`elements.FUNCTIONS`) with a law (`materials.LAWS`), `width` lanes wide.

    cell_phase(first, end, body, stride, commit) does the chunks first..end of a `bundles.Body`; a kernel that calls it
    needs KEEP_VECTORS (compile_options.py). As an outermost parallel loop stride = GRAIN, inside a serial loop over
    steps stride = 1. commit: whether a law with state keeps what it becomes (point_memory.py). viscous: with bulk
    viscosity (bulk_viscosity.py). Memoised.
    """
    corners = elements.CORNERS[kind]
    force_of = elements.force_of(kind, law)
    law_of, count, size = LAWS[law].update, len(LAWS[law].parameters), len(LAWS[law].state)
    lane_numbers = list(range(width))
    viscosity_of = elements.FUNCTIONS[kind].viscosity

    @ti.func
    def cell_phase(first, end, body: ti.template(), stride: ti.template(), commit):
        for s in range((end - first) * stride):
            if s % stride == 0:
                chunk = first + s // stride
                base = 3 * body.chunk_table[chunk * TABLE + 2]
                cell_end, own = body.chunk_table[chunk * TABLE + 3], body.chunk_table[chunk * TABLE + 4]
                parameters = [body.params[LAW_AT + i] for i in range(count)]
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
                    # padding lanes repeat the last cell with no weight
                    weight = ti.select(lanes + pack * width < cell_end, one, zero)
                    first_number = [body.memory_start[pack * width + lane] for lane in range(width if size else 0)]
                    memory = ti.static(PointMemory(body.memory, first_number, size, width, commit) if size else None)
                    answer = force_of(x, y, weight, parameters, law_of, memory)
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
                        held = [VISCOUS_HELD + pack * width + lane for lane in range(width)]
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
                body.cell_sums[chunk * CELL_SUMS] = energy.sum()
                body.cell_sums[chunk * CELL_SUMS + 1] = 1.0 + change.min()
                body.cell_sums[chunk * CELL_SUMS + 2] = hourglass.sum()
                if ti.static(viscous):
                    body.cell_sums[VISCOUS_START + chunk * VISCOUS_SUMS] = power.sum()
                    body.cell_sums[VISCOUS_START + chunk * VISCOUS_SUMS + 1] = fastest.max()

    return cell_phase
