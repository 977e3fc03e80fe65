"""What a step does beside the parallel force pass, and whole steps of small bodies, in one launch on one thread.

    pass       cells and ordinary nodes: kick, drift            (cell_phase.py, node_phase.py)
    boundary   contact load; then friction, reactions, kick and drift of the boundary nodes, a raw row of sums
    place      massless nodes: predicted, then measured and solved until they are in equilibrium

A large body starts at `boundary` after its parallel pass and does one row. Its contact cells are measured here too
where they are few; where they are many it ends at a measure, and starts again at `measured` after one more parallel
pass, over them. A small body starts at `pass` and does many rows: one loop over cells serves passes and measures, every
turn of the outer loop is one of the two and what follows it. The loop ends early at a row that a guard has to look at.
With friction layers it also ends after the contact load, for them to take their step, and starts again at `kick`.
Viscous contact cells (cell_viscosity.py) take their force where contact measures it: before a row and in every measure,
here or, where they are many, in a parallel pass before the launch; started at `viscous` the kernel does that alone.

`control`: numbers below. `raw_out` [rows, width]: raw_rows.py.
"""

import functools

import taichi as ti

from .bundles import ContactOptions
from .cell_phase import make_cell_phase
from .columns import raw_places
from .compile_options import KEEP_VECTORS, LEAVE_TO_LLVM, compiled_with
from .lanes import CHUNK_COUNT, GRAVITY, MOST_SLOTS
from .node_phase import node_phase
from .raw_rows import log_row, row_width
from .signatures import Signature, kernel_of

# numbers of `control`
START, ROWS, BEFORE, AFTER, EXACT, JACOBIAN_LIMIT, ENERGY_LIMIT = 0, 1, 2, 3, 4, 5, 6
ROWS_DONE, FIRST, WANTS_MEASURE, WANTS_LAYERS = 7, 8, 9, 10
RATE_LIMIT = 11
CONTROL = 12
# values of control[START]
PASS, BOUNDARY, PLACE, PRODUCT, MEASURED, KICK = 0, 1, 2, 3, 4, 5
STOP, VISCOUS = 6, 7


@ti.func
def suspicious(raw: ti.template(), number, control: ti.template(), touching: ti.template(), viscous: ti.template()):
    """1 at a row that a guard has to look at: not finite, an inverted cell, much energy, too viscous for the step."""
    place = number * row_width(touching, viscous)
    places = ti.static(raw_places(viscous or touching.options.viscous))
    energy = raw[place + places.nodes.kinetic] + raw[place + places.cells.elastic]
    energy += raw[place + places.shared.kinetic]
    calm = energy <= control[ENERGY_LIMIT] and raw[place + places.cells.jacobian_min] > control[JACOBIAN_LIMIT]
    if ti.static(viscous):
        calm = calm and raw[place + places.cells.viscous_rate] <= control[RATE_LIMIT]
    return ti.select(calm, 0, 1)


@functools.cache
def make_serial_step(
    signature: Signature,
    cells: tuple[tuple[str, str], ...],
    contact: str | None,
    kinds: ContactOptions,
    plain: bool,
    listed_nodes: bool,
    supports: bool,
    passes: bool,
    measures: bool,
    damped: str = "",
    viscous: bool = False,
    tied: bool = False,
):
    """Kernel for kinds of cells (element, law) with these terms, memoised.

    signature: of the bundles of `serial_step` in order, each with what the scene has of it.
    contact: "massless", "penalty", "impulse", "gaps" or None; kinds, plain: of contact (bundles.py); listed_nodes,
    supports: whether there are any; passes: with the loop over cells, for small bodies; measures: with that over the
    contact cells, where they are few;
    damped: name of the law of damping (damping.py); viscous: with bulk viscosity; tied: with images of a periodic body.
    """
    touches = contact is not None
    block, slots, loads = kinds.block, kinds.slots, contact not in (None, "gaps")
    rubs = loads and kinds.friction != ""
    kicked = rubs and kinds.kicked
    sticks_still = contact == "massless" and kinds.static_friction
    resists = contact == "massless" and kinds.viscous
    cell_phase = make_cell_phase(cells, viscous) if passes or measures else None
    cell_kinds, cornered = len(cells), contact == "massless"
    # only what the scene needs is imported; Taichi wants the other names too
    kick_and_drift = support_reactions = choose_candidates = smallest_gap = impulse_load = penalty_load = None
    gather = follow = damp = massless_load = predict = move_out = resolve = CONVERGED = MEASURE = NEXT = None
    set_pose = fill_rows = hand_over = hand_over_friction = obstacle_loads = any_island = None
    clear_work = kick_friction = layer_slip = restart_slip = sliding_work = STEP = None
    viscous_load = viscous_phase = RATE = POWER = None
    if listed_nodes:
        from .boundary_nodes import damp, kick_and_drift, support_reactions
    if tied:
        from .images import follow, gather
    if touches:
        from .constraint_rows import hand_over, hand_over_friction
        from .obstacle_rows import choose_candidates, fill_rows, obstacle_loads, smallest_gap
        from .obstacles import set_pose
    if rubs:
        from .friction import clear_work
    if kicked:
        from .kick_friction import kick_friction, layer_slip
    if sticks_still:
        from .friction import STEP
        from .static_friction import restart_slip, sliding_work
    if contact in ("penalty", "impulse"):
        from .contact_load import impulse_load, penalty_load
    if resists:
        from .cell_viscosity import POWER, RATE, make_viscous_phase, viscous_load

        viscous_phase = make_viscous_phase(cells) if passes or measures else None
    if contact == "massless":
        from .massless_contact import massless_load, move_out, predict
        from .static_control import CONVERGED, MEASURE, NEXT, any_island
        from .static_solve import make_resolve

        resolve = make_resolve(cells, block, plain)

    @ti.func
    def push_back(body: ti.template(), listed: ti.template(), obstacles: ti.template(), rows: ti.template(),
                  touching: ti.template(), system: ti.template(), control: ti.template()):  # fmt: skip
        if ti.static(contact in ("penalty", "impulse") and slots == MOST_SLOTS):
            choose_candidates(obstacles, touching, body.u)
        if ti.static(loads):
            fill_rows(obstacles, rows, touching, body.u)
        if ti.static(touches):
            smallest_gap(obstacles, rows, touching, body.u)
        if ti.static(contact == "massless"):
            massless_load(body, listed, touching, rows, system)
        if ti.static(contact == "penalty"):
            penalty_load(touching, rows)
        if ti.static(contact == "impulse"):
            before, after = control[BEFORE], control[AFTER]
            span = ti.select(after > 0.0, 0.5 * (before + after), before)
            impulse_load(body, listed, touching, rows, span)
        if ti.static(loads):
            hand_over(body, touching, rows)
        if ti.static(rubs):
            clear_work(touching)
        if ti.static(sticks_still):
            sliding_work(body, touching, rows)
        if ti.static(kicked and kinds.layered and not sticks_still):
            layer_slip(body, listed, touching, rows, damped)

    @ti.func
    def kick(
        body: ti.template(),
        listed: ti.template(),
        supported: ti.template(),
        obstacles: ti.template(),
        rows: ti.template(),
        touching: ti.template(),
    ):
        if ti.static(kicked):
            kick_friction(body, listed, touching, rows, damped)
            hand_over_friction(body, touching, rows)
        if ti.static(touches and kinds.tracked):
            obstacle_loads(obstacles, rows, touching, body.u)
        if ti.static(listed_nodes and damped != ""):
            damp(body, listed, damped)
        if ti.static(supports):
            support_reactions(body, listed, supported)
        if ti.static(listed_nodes):
            kick_and_drift(body, listed)

    @ti.func
    def place(
        body: ti.template(),
        obstacles: ti.template(),
        rows: ti.template(),
        touching: ti.template(),
        viscous_cells: ti.template(),
        control: ti.template(),
        start,
    ):
        if ti.static(slots == MOST_SLOTS):
            choose_candidates(obstacles, touching, body.u)
        before, after = control[BEFORE], control[AFTER]
        ratio = ti.select(before > 0.0, after / ti.max(before, 1e-300), 1.0)
        time = 0.5 * after * (before + after)
        if start == PLACE:
            ratio, time = 0.0, 0.0
        if ti.static(resists):
            viscous_cells[RATE] = ti.select(start == PLACE, 0.0, 1.0 / ti.max(after, 1e-300))
        if ti.static(sticks_still):
            touching.friction[STEP] = ti.select(start == PLACE, 0.0, after)
            if start == PLACE:
                restart_slip(body, touching)
        predict(body, touching, ratio, time * ti.Vector([body.params[GRAVITY + j] for j in range(3)]))
        if control[EXACT] == 1.0:
            fill_rows(obstacles, rows, touching, body.u)
            move_out(body, touching, rows)

    @ti.func
    def serial_step(
        body: ti.template(),
        listed: ti.template(),
        supported: ti.template(),
        obstacles: ti.template(),
        rows: ti.template(),
        touching: ti.template(),
        pairs: ti.template(),
        system: ti.template(),
        launch: ti.template(),
    ):
        control, raw_out = ti.static(launch.control, launch.raw_out)
        viscous_cells, images, stats = ti.static(launch.viscous_cells, launch.images, system.stats)
        ti.loop_config(serialize=True)
        for _ in range(1):
            chunks = int(body.params[CHUNK_COUNT])
            ordinary = chunks
            if ti.static(cornered):
                ordinary = chunks // 2
            state = int(control[START])
            number, stop, first = 0, 0, int(control[FIRST])
            control[WANTS_MEASURE] = 0.0
            control[WANTS_LAYERS] = 0.0
            while state != STOP:
                if ti.static(passes or measures):
                    if state == PASS or state == PRODUCT or state == MEASURED:
                        first_chunk = ti.select(state == MEASURED, ordinary, 0)
                        cell_phase(first_chunk, chunks, body, 1, ti.select(state == PASS, 1, 0))
                if ti.static(passes):
                    if state == PASS or state == PRODUCT:
                        node_phase(body, ordinary, cell_kinds, 1, damped, cornered)
                if ti.static(resists):
                    if state == PASS or state == BOUNDARY:
                        past = control[BEFORE]
                        viscous_cells[RATE] = ti.select(past > 0.0, 1.0 / ti.max(past, 1e-300), 0.0)
                    if ti.static(passes or measures):
                        if state == PASS or state == BOUNDARY or state == MEASURED or state == VISCOUS:
                            viscous_phase(body, viscous_cells, 1)
                    if state == PASS or state == BOUNDARY:
                        viscous_load(body, listed, viscous_cells)
                if state == PASS or state == BOUNDARY:
                    if ti.static(tied):
                        gather(body.special_force, images)
                    push_back(body, listed, obstacles, rows, touching, system, control)
                    if ti.static(kinds.layered):
                        control[WANTS_LAYERS] = 1.0
                        state = STOP
                if state == PASS or state == BOUNDARY or state == KICK:
                    kick(body, listed, supported, obstacles, rows, touching)
                    cell_power = 0.0
                    if ti.static(resists):
                        cell_power = viscous_cells[POWER]
                    log_row(raw_out, number, body, touching, viscous, cell_power)
                    stop = suspicious(raw_out, number, control, touching, viscous)
                    number += 1
                    if ti.static(touches and kinds.moving):
                        if control[AFTER] > 0.0:
                            set_pose(obstacles, number)
                again = 0  # go on with a measure
                if ti.static(contact == "massless"):
                    if state == MEASURED:
                        fill_rows(obstacles, rows, touching, body.u)
                        resolve(body, listed, touching, rows, pairs, system, viscous_cells, first)
                        first = 0
                        if any_island(stats, NEXT, MEASURE) == 1:
                            again = 1
                        elif any_island(stats, CONVERGED, 0.0) == 1:
                            stop = 1
                    elif state == PLACE or (state != PRODUCT and state != STOP and control[AFTER] > 0.0):
                        place(body, obstacles, rows, touching, viscous_cells, control, state)
                        again, first = 1, 1
                if ti.static(tied):
                    if state != PRODUCT and state != VISCOUS:
                        follow(body.u, body.v, listed.nodes, images)
                if again == 1:
                    state = MEASURED
                    if ti.static(not measures):
                        control[FIRST] = float(first)
                        control[WANTS_MEASURE] = 1.0
                        state = STOP
                elif state == STOP or stop == 1 or number >= int(control[ROWS]) or int(control[START]) != PASS:
                    state = STOP
                else:
                    state = PASS
            control[ROWS_DONE] = float(number)

    # with friction, several obstacles or MPRGP compiling would outlast many a run; else the loop over cells is worth it
    hasty = LEAVE_TO_LLVM if rubs or slots > 1 or kinds.projected or not passes else {}
    return compiled_with(kernel_of(serial_step, signature, options=kinds), **KEEP_VECTORS, **hasty)
