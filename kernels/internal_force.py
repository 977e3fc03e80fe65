"""The explicit step: internal force of packed cells, then kick and drift of the nodes, in one launch.

    f_i = dW/du_i,   a = g - f/m,   v_n = v + kick_before a,   v <- v_n + kick_after a,   u <- u + drift v

(METHOD 2: leapfrog with kick_before = dt_old/2, kick_after = dt_new/2, drift = dt_new.)
With v = 0, g = 0, kick_before = drift = 0 and kick_after = 1 the same kernel gives v = -f/m and leaves u alone.

Cells: the corners of a pack are gathered into vectors over its lanes, the cell's arithmetic works on vectors, and the
corner forces are scattered lane by lane, without atomics, into the force row of their chunk. The vectors are explicit
SIMD values (`KEEP_VECTORS`), so nothing depends on what a loop vectoriser makes of the host. Nodes: each sums its chunk
rows in chunk order, clears them for the next step and moves. Chunks and node ranges are fixed in number: same bits on
any number of threads.

Chunks that own rows (the contact cells once more, for the static solve) give each corner of each cell a row of its own:
there the corner forces stay apart and no node sums them.

`params`: kick_before [s], kick_after [s], drift [s], gravity [m/s^2] (3), up to 3 moduli of the law [Pa] (laws.py), and
what only some bodies have (lanes.py).
`cell_sums` [chunks*3]: elastic energy [J], smallest det F over the Gauss points (all laws, the linear one too), and the
part of the elastic energy that is hourglass energy [J] (0 for elements without); after all chunks those of viscosity,
then the pressure each cell held.
`node_sums` [chunks*10], ordinary nodes only, at u before the drift and v_n: kinetic, momentum (3), angular momentum
about the origin (3), sum m u (3). Special nodes hand out f in special_force [3*s+c] and are not moved.
"""

import functools

import taichi as ti

from . import elements, laws
from .arguments import ARRAY, INDEX
from .compile_options import KEEP_VECTORS, compiled_with
from .lane_vectors import MASK
from .lanes import (
    CELL_SUMS,
    CHUNKS,
    DAMPING_RATE,
    NODE_SUMS,
    TABLE,
    VISCOSITY,
    VISCOUS_HELD,
    VISCOUS_START,
    VISCOUS_SUMS,
    WIDTHS,
)

GRAIN = 512  # a parallel loop gives each thread at least this many iterations: one chunk per GRAIN iterations
TINY = 1e-100


@ti.func
def node_phase(
    chunk_table: ti.template(),
    node_info: ti.template(),
    position: ti.template(),
    u: ti.template(),
    v: ti.template(),
    mass: ti.template(),
    rows: ti.template(),
    special_force: ti.template(),
    node_sums: ti.template(),
    params: ti.template(),
    ranges,
    stride: ti.template(),
    damped: ti.template(),
):
    """Sum and clear the force rows of every node, then move it; stride: iterations of the outer loop per node range.

    damped: with mass-proportional damping (damping.py).
    """
    for s in range(ranges * stride):
        if s % stride == 0:
            part = s // stride
            nodes = node_info.shape[0]
            kick_before, kick_after, drift = params[0], params[1], params[2]
            gravity = [params[3], params[4], params[5]]
            kinetic = 0.0
            momentum = [0.0, 0.0, 0.0]
            spin = [0.0, 0.0, 0.0]
            moved = [0.0, 0.0, 0.0]
            for i in range(part * nodes // ranges, (part + 1) * nodes // ranges):
                info = node_info[i]
                force = [0.0, 0.0, 0.0]
                for c in range(info & 15, ((info >> 4) & 15) + 1):
                    row = 3 * (chunk_table[c * TABLE + 2] + i)
                    for d in ti.static(range(3)):
                        force[d] += rows[row + d]
                        rows[row + d] = 0.0
                if info >= 256:
                    for d in ti.static(range(3)):
                        special_force[3 * ((info >> 8) - 1) + d] = force[d]
                else:
                    m = mass[i]
                    inverse = 1.0 / m
                    p = [0.0, 0.0, 0.0]
                    x = [0.0, 0.0, 0.0]
                    for d in ti.static(range(3)):
                        acceleration = gravity[d] - force[d] * inverse
                        old = v[3 * i + d]
                        if ti.static(damped):
                            rate = params[DAMPING_RATE]
                            acceleration = (acceleration - rate * old) / (1.0 + rate * kick_before)
                        middle = old + kick_before * acceleration
                        new = old + (kick_before + kick_after) * acceleration
                        here = u[3 * i + d]
                        v[3 * i + d] = new
                        u[3 * i + d] = ti.select(drift == 0.0, here, here + drift * new)
                        p[d] = m * middle
                        x[d] = position[3 * i + d] + here
                        kinetic += 0.5 * p[d] * middle
                        momentum[d] += p[d]
                        moved[d] += m * here
                    spin[0] += x[1] * p[2] - x[2] * p[1]
                    spin[1] += x[2] * p[0] - x[0] * p[2]
                    spin[2] += x[0] * p[1] - x[1] * p[0]
            node_sums[part * NODE_SUMS] = kinetic
            for d in ti.static(range(3)):
                node_sums[part * NODE_SUMS + 1 + d] = momentum[d]
                node_sums[part * NODE_SUMS + 4 + d] = spin[d]
                node_sums[part * NODE_SUMS + 7 + d] = moved[d]


@ti.func
def gather(connectivity: ti.template(), position: ti.template(), u: ti.template(), start, width: ti.template()):
    """Reference position (3) and displacement (3) of one corner, each a vector over the lanes."""
    # the mask tells the compiler that node + 1 and node + 2 cannot overflow: one address for the three components
    node = [(3 * connectivity[start + lane]) & MASK for lane in range(width)]
    return [ti.Vector([position[i + c] for i in node]) for c in range(3)] + [
        ti.Vector([u[i + c] for i in node]) for c in range(3)
    ]


@ti.func
def gather_velocity(connectivity: ti.template(), v: ti.template(), start, width: ti.template()):
    """Velocity (3) of one corner, each a vector over the lanes."""
    node = [(3 * connectivity[start + lane]) & MASK for lane in range(width)]
    return [ti.Vector([v[i + c] for i in node]) for c in range(3)]


@ti.func
def with_mass(connectivity: ti.template(), node_info: ti.template(), start, massless, width: ti.template()):
    """1 in lanes where this corner is not one of the massless nodes, the first special ones; else 0."""
    number = ti.Vector([node_info[connectivity[start + lane]] >> 8 for lane in range(width)])
    zero = ti.Vector([0.0 for _ in range(width)])
    return ti.select(number > massless, zero + 1.0, ti.select(number < 1, zero + 1.0, zero))


@functools.cache
def make_cell_phase(kind: str, law: str, width: int, viscous: bool = False):
    """Cell phase of a kind (names in `elements.FORCES`) with a law (`laws.LAWS`), packed `width` wide; memoised.

    cell_phase(first, end, connectivity, chunk_table, node_info, position, u, v, rows, cell_sums, params, stride) for
    the chunks first..end; a kernel that calls it needs `KEEP_VECTORS`. As an outermost parallel loop stride = GRAIN,
    inside a serial loop over steps stride = 1. viscous: with bulk viscosity (bulk_viscosity.py).
    """
    corners = elements.CORNERS[kind]
    force_of = elements.force_of(kind, law)
    law_of, moduli_count = laws.LAWS[law], laws.MODULI[law]
    lane_numbers = list(range(width))
    viscosity_of = None
    if viscous:
        from .bulk_viscosity import VISCOSITIES

        viscosity_of = VISCOSITIES[kind]

    @ti.func
    def cell_phase(
        first,
        end,
        connectivity: ti.template(),
        chunk_table: ti.template(),
        node_info: ti.template(),
        position: ti.template(),
        u: ti.template(),
        v: ti.template(),
        rows: ti.template(),
        cell_sums: ti.template(),
        params: ti.template(),
        stride: ti.template(),
    ):
        for s in range((end - first) * stride):
            if s % stride == 0:
                chunk = first + s // stride
                base = 3 * chunk_table[chunk * TABLE + 2]
                cell_end, own = chunk_table[chunk * TABLE + 3], chunk_table[chunk * TABLE + 4]
                moduli = [params[6 + i] for i in range(moduli_count)]
                lanes = ti.Vector(lane_numbers)
                zero = ti.Vector([0.0 for _ in range(width)])
                one = zero + 1.0
                energy = zero
                hourglass = zero
                change = zero + 1e300
                power, fastest = zero, zero
                for pack in range(chunk_table[chunk * TABLE], chunk_table[chunk * TABLE + 1]):
                    start = pack * (corners * width)
                    corner = [gather(connectivity, position, u, start + k * width, width) for k in range(corners)]
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
                        velocity = [gather_velocity(connectivity, v, start + k * width, width) for k in range(corners)]
                        here = weight
                        for k in ti.static(range(corners)):
                            here *= with_mass(connectivity, node_info, start + k * width, params[VISCOSITY + 3], width)
                        w = [[velocity[k][c] for k in range(corners)] for c in range(3)]
                        added = viscosity_of(x, y, w, params[VISCOSITY], params[VISCOSITY + 1])
                        rate = params[VISCOSITY + 4] * here * added[3]
                        fastest = ti.max(fastest, rate)
                        # beyond a stable step, until it is shortened: at most what turns the rate of a cell round
                        most = 2.0 / ti.max(params[0] + params[1], TINY)
                        density = params[VISCOSITY + 2] * here * ti.min(one, most / ti.max(rate, TINY))
                        pressure = density * added[1]
                        held = [VISCOUS_HELD + pack * width + lane for lane in range(width)]
                        power += 0.5 * (pressure + ti.Vector([cell_sums[i] for i in held])) * added[2]
                        for lane in ti.static(range(width)):
                            cell_sums[held[lane]] = pressure[lane]
                        for c, k in ti.static(ti.ndrange(3, corners)):
                            answer[0][c][k] += density * added[0][c][k]
                    for k in ti.static(range(corners)):
                        for lane in ti.static(range(width)):
                            place = start + k * width + lane
                            row = (3 * ti.select(own == 1, place, connectivity[place]) + base) & MASK
                            old = [rows[row + c] for c in range(3)]
                            for c in ti.static(range(3)):
                                rows[row + c] = old[c] + answer[0][c][k][lane]
                cell_sums[chunk * CELL_SUMS] = energy.sum()
                cell_sums[chunk * CELL_SUMS + 1] = 1.0 + change.min()
                cell_sums[chunk * CELL_SUMS + 2] = hourglass.sum()
                if ti.static(viscous):
                    cell_sums[VISCOUS_START + chunk * VISCOUS_SUMS] = power.sum()
                    cell_sums[VISCOUS_START + chunk * VISCOUS_SUMS + 1] = fastest.max()

    return cell_phase


@functools.cache
def make_step(kind: str, law: str, width: int | None = None, damped: bool = False, viscous: bool = False):
    """Step kernel of a cell kind with a law, memoised; every array flat, u and v [3n], rows zero on entry and exit.

    step(first, end, ranges, connectivity, chunk_table, node_info, position, mass, params, u, v, rows,
    special_force_out, node_sums_out, cell_sums_out): the cells of chunks first..end, then the nodes in `ranges` parts
    (0: none); index arrays from `packing.pack_cells`, packed `width` wide (default WIDTHS[kind]).
    damped: with mass-proportional damping; viscous: with bulk viscosity.
    """
    cell_phase = make_cell_phase(kind, law, width or WIDTHS[kind], viscous)

    @ti.kernel
    def step(
        first: ti.i32,
        end: ti.i32,
        ranges: ti.i32,
        connectivity: INDEX,
        chunk_table: INDEX,
        node_info: INDEX,
        position: ARRAY,
        mass: ARRAY,
        params: ARRAY,
        u: ARRAY,
        v: ARRAY,
        rows: ARRAY,
        special_force_out: ARRAY,
        node_sums_out: ARRAY,
        cell_sums_out: ARRAY,
    ):
        cell_phase(first, end, connectivity, chunk_table, node_info, position, u, v, rows, cell_sums_out, params, GRAIN)
        node_phase(
            chunk_table,
            node_info,
            position,
            u,
            v,
            mass,
            rows,
            special_force_out,
            node_sums_out,
            params,
            ranges,
            GRAIN,
            damped,
        )

    return compiled_with(step, **KEEP_VECTORS)


@functools.cache
def make_measure(kind: str, law: str):
    """The cells that own their rows alone, on one thread: for few cells, which are not worth waking others."""
    cell_phase = make_cell_phase(kind, law, WIDTHS[kind])

    @ti.kernel
    def measure(
        connectivity: INDEX,
        chunk_table: INDEX,
        node_info: INDEX,
        position: ARRAY,
        params: ARRAY,
        u: ARRAY,
        v: ARRAY,
        rows: ARRAY,
        cell_sums_out: ARRAY,
    ):
        ti.loop_config(serialize=True)
        for _ in range(1):
            cell_phase(
                CHUNKS,
                2 * CHUNKS,
                connectivity,
                chunk_table,
                node_info,
                position,
                u,
                v,
                rows,
                cell_sums_out,
                params,
                1,
            )

    return compiled_with(measure, **KEEP_VECTORS)
