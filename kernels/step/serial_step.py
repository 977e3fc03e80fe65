"""The serial kernel: boundary nodes, contact and static solve of a step, and whole steps of small domains.

It runs on one thread, in one launch, as a loop over the phases of a step:

    pass       force pass over all cells; kick and drift of ordinary nodes         (cell_phase.py, node_phase.py)
    boundary   contact load; friction, support reactions, kick and drift of the boundary nodes; raw row of sums
    place      prediction of the massless nodes; then force passes over the contact cells ("measures"), each followed by
               an iteration of the static solve, until the nodes are in equilibrium

A large domain starts at `boundary` after its parallel force pass and does one row (one time level). Few contact cells
are measured here. If they are many, the kernel ends where a measure is needed and is started again at `measured` after
a parallel pass over them. A small domain (few cells in all its bodies) starts at `pass` and does many rows; one loop
over cells serves force passes and measures. The kernel ends early at a row that the host must check (`suspicious`).
With friction layers it ends after the contact load, so that the layers take their step, and is started again at `kick`;
so it does where ranks share the contact, which hand over what the static solve has left. They solve together, outside
of this kernel (tcontact/contact/shared_solve.py), where it ends for a measure.
Loads of the next level are applied once the nodes have moved, before the static solve. Where they depend on positions
and velocities, the kernel ends there, and is started again at `loads` after the host has computed them.
The force of viscous contact cells (cell_viscosity.py) is computed before each row and in each measure, here or, if they
are many, in a parallel pass before the launch; started at `viscous`, the kernel does only that.

Where no node has moved since the last measure, as where all nodes with normal removal stay closed, the next pass leaves
the contact cells out (control[KNOWN]): their forces are those of the measure, bit for bit.

`control`: launch_control.py. `raw_out` [rows, width]: raw_rows.py.
"""

import functools

from ..cells.cell_phase import keep_places, make_cell_phase, only_places_matter
from ..cells.node_averages import ring_changes
from ..cells.node_volumes import make_volume_phase
from ..engine import ti
from ..lanes import CHUNK_COUNT, GRAVITY, MAXIMUM_SLOTS
from ..lanes import STEP as STEP_LENGTH
from ..language.bundles import ContactOptions
from ..language.compile_options import KEEP_VECTORS, LEAVE_TO_LLVM, compiled_with
from ..language.signatures import Signature, kernel_of
from ..materials import LAWS
from ..nodes.node_phase import node_phase
from ..pair_places import SQUEEZED
from .launch_control import (
    AFTER,
    BEFORE,
    BOUNDARY,
    EXACT,
    FIRST,
    KICK,
    KNOWN,
    LOADS,
    MEASURED,
    PASS,
    PLACE,
    PRODUCT,
    ROWS,
    ROWS_DONE,
    START,
    STOP,
    VISCOUS,
    WANTS_LAYERS,
    WANTS_LOADS,
    WANTS_MEASURE,
    WANTS_ROWS,
    suspicious,
)
from .raw_rows import log_row
from .samples import take_sample


@functools.cache
def make_serial_step(
    signature: Signature,
    cells: tuple[tuple[str, str], ...],
    contact_model: str | None,
    options: ContactOptions,
    plain: bool,
    has_boundary: bool,
    has_supports: bool,
    passes: bool,
    measures: bool,
    damped: str = "",
    viscous: bool = False,
    tied: bool = False,
    loaded: str = "",
    driven: bool = False,
    has_springs: bool = False,
    rigid_bodies: bool = False,
    mixed: bool = False,
):
    """Return the serial kernel for a scene with these terms, memoised.

    signature: of the bundles of `serial_step`; cells: kinds of cells (element, law); contact_model: "massless",
    "penalty", "impulse", "gaps" or None; options: compile-time options of contact (bundles.py); plain: the bases of all
    contact nodes are the identity; has_boundary, has_supports: there are boundary nodes, supports; passes: includes the
    force pass, for small domains; measures: includes that over the contact cells, if they are few; damped: name of the
    damping law (damping.py); viscous: with bulk viscosity; tied: with images of a periodic body; loaded: "loads", or ""
    without (loads.py); driven: functions of time drive supports; has_springs: springs act on boundary nodes;
    rigid_bodies: with rigid bodies that move; mixed: in mixed precision (mixed_cells.py).
    """
    has_contact = contact_model is not None
    block, has_load = options.block, contact_model not in (None, "gaps")
    has_friction = has_load and options.friction != ""
    kick_has_friction = has_friction and options.kick_friction
    solve_has_friction = contact_model == "massless" and options.static_friction
    has_viscous_cells = contact_model == "massless" and options.viscous
    # where ranks share the contact, the viscous force is part of the forces that they add up before the row
    loads_viscosity = VISCOUS if options.shared else BOUNDARY
    cornered = contact_model == "massless"
    cell_phase = make_cell_phase(cells, viscous, cornered, mixed and passes) if passes or measures else None
    volume_phase = make_volume_phase(cells)
    cell_kinds = len(cells)
    lasting = contact_model == "massless" and not viscous and only_places_matter(cells)
    plastic = any(LAWS[law].plastic is not None for _, law in cells)
    timed = viscous or any(LAWS[law].rates for _, law in cells)
    # only what the scene needs is imported; Taichi needs the other names to exist
    kick_and_drift = support_reactions = choose_candidates = smallest_gap = impulse_load = penalty_load = None
    apply_loads = measure_loads = asks = None
    spring_forces = measure_springs = accelerate = move_on = None
    gather = follow = damp = massless_load = predict = move_out = resolve = CONVERGED = MEASURE = NEXT = None
    set_pose = fill_rows = apply_rows = apply_kick_friction = obstacle_loads = any_island = None
    fill_pair_rows = count_pairs = apply_to_masters = is_stale = press_all_masters = kick_pair_friction = None
    find_squeezed = layer_slip_of_pairs = None
    clear_work = kick_friction = layer_slip = restart_slip = sliding_work = STEP = None
    note_slip = set_coefficients = None
    viscous_load = viscous_phase = RATE = POWER = None
    move_bodies = gather_forces = carry_nodes = load_free_obstacles = place_free_obstacles = measure_rigid_rate = None
    if has_boundary:
        from ..nodes.boundary_nodes import damp, kick_and_drift, support_reactions
    if loaded:
        from ..nodes.loads import apply_loads, asks, measure_loads
    if has_springs:
        from ..nodes.springs import measure_springs, spring_forces
    if driven:
        from ..nodes.driven_supports import accelerate, move_on
    if tied:
        from ..nodes.images import follow, gather
    if rigid_bodies:
        from ..nodes.rigid_body import move_bodies
        from ..nodes.rigid_parts import carry_nodes, gather_forces
    if options.free:
        from ..contact.free_obstacles import load_free_obstacles, place_free_obstacles
        from .rigid_rate import measure_rigid_rate
    coupled = options.coupled
    if coupled:
        from ..contact.pair_loads import apply_to_masters, count_pairs
        from ..contact.pair_rows import fill_pair_rows, is_stale, press_all_masters
    if has_contact:
        from ..contact.constraint_rows import apply_kick_friction, apply_rows
        from ..contact.obstacle_rows import choose_candidates, fill_rows, obstacle_loads, smallest_gap
        from ..contact.obstacles import set_pose
    if has_friction:
        from ..contact.friction import clear_work
    varied = has_friction and options.varied
    if varied:
        from ..contact.friction_laws import note_slip, set_coefficients
    if kick_has_friction:
        from ..contact.kick_friction import kick_friction, layer_slip
    if kick_has_friction and coupled:
        from ..contact.pair_friction import kick_pair_friction, layer_slip_of_pairs
    if solve_has_friction:
        from ..contact.friction import STEP
        from ..static.sliding import restart_slip, sliding_work
    if contact_model in ("penalty", "impulse"):
        from ..contact.contact_load import impulse_load, penalty_load
    if has_viscous_cells:
        from ..contact.cell_viscosity import POWER, RATE, make_viscous_phase, viscous_load

        viscous_phase = make_viscous_phase(cells) if passes or measures else None
    if contact_model == "massless":
        from ..static.chosen_rows import find_squeezed
        from ..static.control import CONVERGED, MEASURE, NEXT, any_island
        from ..static.massless_contact import massless_load, move_out, predict

        if not options.shared:
            from ..static.solve import make_resolve

            resolve = make_resolve(cells, block, plain)

    @ti.func
    def contact_load(body: ti.template(), boundary: ti.template(), obstacles: ti.template(), rows: ti.template(),
                     coupling: ti.template(), contact: ti.template(), system: ti.template(),
                     control: ti.template()):  # fmt: skip
        if ti.static(contact_model in ("penalty", "impulse") and options.obstacle_slots == MAXIMUM_SLOTS):
            choose_candidates(obstacles, contact, body.u)
        if ti.static(has_load):
            fill_rows(obstacles, rows, contact, body.u)
        if ti.static(coupled):
            fill_pair_rows(coupling, contact, boundary, rows, body)
            if ti.static(rows.at.lift >= 0):
                find_squeezed(coupling, contact, rows, system)
        if ti.static(has_contact):
            smallest_gap(obstacles, rows, contact, body.u)
        if ti.static(contact_model == "massless"):
            massless_load(body, boundary, contact, rows, coupling, system)
        if ti.static(contact_model == "penalty"):
            penalty_load(contact, rows)
            if ti.static(coupled):
                press_all_masters(coupling, body, contact, rows)
        if ti.static(contact_model == "impulse"):
            before, after = control[BEFORE], control[AFTER]
            span = ti.select(after > 0.0, 0.5 * (before + after), before)
            impulse_load(body, boundary, contact, rows, span)
        if ti.static(has_load):
            apply_rows(body, contact, rows)
        if ti.static(coupled):
            count_pairs(coupling, contact, rows)
            apply_to_masters(coupling, boundary, body, contact, rows, rows.at.force)
        if ti.static(has_friction):
            clear_work(contact)
        if ti.static(solve_has_friction):
            sliding_work(body, boundary, contact, rows, coupling)
        if ti.static(varied):
            first = ti.select(control[BEFORE] > 0.0, 0, 1)
            set_coefficients(body, boundary, obstacles, rows, coupling, contact, 1, first, control[AFTER])
        if ti.static(kick_has_friction and options.layered and not solve_has_friction):
            if ti.static(coupled):
                layer_slip_of_pairs(body, boundary, contact, rows, coupling, damped)
            else:
                layer_slip(body, boundary, contact, rows, damped)

    @ti.func
    def kick(body: ti.template(), boundary: ti.template(), supports: ti.template(), obstacles: ti.template(),
             rows: ti.template(), coupling: ti.template(), contact: ti.template(), pairs: ti.template(),
             system: ti.template(), rigid: ti.template(), control: ti.template(), number):  # fmt: skip
        if ti.static(kick_has_friction):
            if ti.static(coupled):
                kick_pair_friction(body, boundary, contact, rows, coupling, damped)
            else:
                kick_friction(body, boundary, contact, rows, obstacles, rigid, damped)
            apply_kick_friction(body, contact, rows)
            if ti.static(coupled):
                apply_to_masters(coupling, boundary, body, contact, rows, rows.at.kick_friction)
        if ti.static(has_contact and options.tracked):
            obstacle_loads(obstacles, rows, contact, rigid, body.u)
        if ti.static(options.free and options.tracked):
            load_free_obstacles(rigid, obstacles, contact)
            measure_rigid_rate(rigid, obstacles, rows, contact, pairs, body, control[BEFORE])
        if ti.static(has_boundary and damped != ""):
            damp(body, boundary, contact, damped)
        if ti.static(has_springs):
            measure_springs(body, boundary, contact, rigid, number + 1, damped)
        if ti.static(has_supports):
            support_reactions(body, boundary, supports, contact)
        if ti.static(loaded != ""):
            measure_loads(body, boundary, contact)
        if ti.static(has_boundary):
            kick_and_drift(body, boundary, contact, loaded)
        if ti.static(driven):
            move_on(body, boundary, supports, contact, number)
        if ti.static(rigid_bodies):
            if ti.static(rigid.tied):
                gather_forces(rigid, body, boundary)
            move_bodies(rigid, body, number + 1, damped, has_supports)
            if ti.static(rigid.tied):
                carry_nodes(rigid, body, boundary)
        if ti.static(varied and not solve_has_friction):
            note_slip(body, boundary, obstacles, rows, coupling, contact)

    @ti.func
    def place(body: ti.template(), obstacles: ti.template(), rows: ti.template(), contact: ti.template(),
              viscous_cells: ti.template(), control: ti.template(), start):  # fmt: skip
        if ti.static(options.obstacle_slots == MAXIMUM_SLOTS):
            choose_candidates(obstacles, contact, body.u)
        before, after = control[BEFORE], control[AFTER]
        ratio = ti.select(before > 0.0, after / ti.max(before, 1e-300), 1.0)
        time = 0.5 * after * (before + after)
        if start == PLACE:
            ratio, time = 0.0, 0.0
        if ti.static(has_viscous_cells):
            viscous_cells[RATE] = ti.select(start == PLACE, 0.0, 1.0 / ti.max(after, 1e-300))
        if ti.static(solve_has_friction):
            contact.friction[STEP] = ti.select(start == PLACE, 0.0, after)
            if start == PLACE:
                restart_slip(body, contact)
        predict(body, contact, ratio, time * ti.Vector([body.params[GRAVITY + j] for j in range(3)]))
        if ti.static(not coupled):
            if control[EXACT] == 1.0:
                fill_rows(obstacles, rows, contact, body.u)
                move_out(body, contact, rows)

    @ti.func
    def serial_step(
        body: ti.template(),
        boundary: ti.template(),
        supports: ti.template(),
        obstacles: ti.template(),
        rows: ti.template(),
        contact: ti.template(),
        coupling: ti.template(),
        pairs: ti.template(),
        system: ti.template(),
        rigid: ti.template(),
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
            control[WANTS_ROWS] = 0.0
            while state != STOP:
                if ti.static(launch.sampled):
                    if state == PASS:
                        take_sample(launch.samples, body, number)
                if ti.static(passes or measures):
                    if state == PASS or state == PRODUCT or state == MEASURED:
                        first_chunk = ti.select(state == MEASURED, ordinary, 0)
                        if ti.static(body.averaged):
                            volume_phase(first_chunk, chunks, body, 1, ti.select(state == MEASURED, 0, 1))
                        end_chunk = chunks
                        if ti.static(lasting):
                            if state == PASS and control[KNOWN] == 1.0:
                                end_chunk = ordinary
                            control[KNOWN] = 0.0
                        cell_phase(first_chunk, end_chunk, body, 1, ti.select(state == PASS, 1, 0))
                if ti.static(passes):
                    if state == PASS or state == PRODUCT:
                        node_phase(body, ordinary, cell_kinds, 1, damped, cornered)
                if ti.static(has_viscous_cells):
                    if state == PASS or state == loads_viscosity:
                        past = control[BEFORE]
                        viscous_cells[RATE] = ti.select(past > 0.0, 1.0 / ti.max(past, 1e-300), 0.0)
                    if ti.static(passes or measures):
                        if state == PASS or state == BOUNDARY or state == MEASURED or state == VISCOUS:
                            viscous_phase(body, viscous_cells, 1)
                    if state == PASS or state == loads_viscosity:
                        viscous_load(body, boundary, contact, viscous_cells)
                if state == PASS or state == BOUNDARY:
                    if ti.static(body.viscous_metal):
                        keep_places(body, boundary)
                    if ti.static(tied):
                        gather(body.special_force, images)
                    if ti.static(driven):
                        accelerate(body, boundary, supports, contact, number)
                    if ti.static(has_springs):
                        spring_forces(body, boundary, contact, rigid, number + 1, damped)
                    contact_load(body, boundary, obstacles, rows, coupling, contact, system, control)
                    if ti.static(options.layered or options.shared):
                        control[WANTS_LAYERS] = 1.0
                        state = STOP
                if state == PASS or state == BOUNDARY or state == KICK:
                    kick(
                        body,
                        boundary,
                        supports,
                        obstacles,
                        rows,
                        coupling,
                        contact,
                        pairs,
                        system,
                        rigid,
                        control,
                        number,
                    )
                    cell_power = 0.0
                    if ti.static(has_viscous_cells):
                        cell_power = viscous_cells[POWER]
                    log_row(raw_out, number, body, contact, viscous, cell_power, plastic)
                    stop = suspicious(raw_out, number, control, contact, viscous, plastic, rigid)
                    if ti.static(coupled):
                        if coupling.values[SQUEEZED] != 0.0:
                            stop = 1
                    number += 1
                    if ti.static(timed):
                        body.params[STEP_LENGTH] = control[AFTER]
                    if ti.static(coupled and contact_model == "penalty"):
                        if control[AFTER] > 0.0 and is_stale(coupling, boundary, contact, rows, body) == 1:
                            control[WANTS_ROWS] = 1.0
                            stop = 1
                    if ti.static(has_contact and options.posed):
                        if control[AFTER] > 0.0:
                            set_pose(obstacles, contact, number)
                    if ti.static(options.free):
                        if control[AFTER] > 0.0:
                            place_free_obstacles(rigid, obstacles)
                again = 0  # 1: a measure is next
                if ti.static(contact_model == "massless"):
                    if state == MEASURED:
                        if ti.static(not options.shared):
                            fill_rows(obstacles, rows, contact, body.u)
                            if ti.static(coupled):
                                fill_pair_rows(coupling, contact, boundary, rows, body)
                            if ti.static(varied and solve_has_friction):
                                here = contact.friction[STEP]
                                set_coefficients(body, boundary, obstacles, rows, coupling, contact, 0, 0, here)
                            still = resolve(
                                body, boundary, contact, rows, coupling, pairs, system, viscous_cells, first
                            )
                            if ti.static(lasting):
                                control[KNOWN] = float(still)
                            first = 0
                            if any_island(stats, NEXT, MEASURE) == 1:
                                again = 1
                            elif any_island(stats, CONVERGED, 0.0) == 1:
                                stop = 1
                    elif state == PLACE or (state != PRODUCT and state != STOP and control[AFTER] > 0.0):
                        if state != LOADS:
                            place(body, obstacles, rows, contact, viscous_cells, control, state)
                        again, first = 1, 1
                if ti.static(coupled and contact_model == "massless"):
                    if again == 1:  # the nodes have moved: rows that slipped too far are built before the measure
                        fill_pair_rows(coupling, contact, boundary, rows, body)
                        if is_stale(coupling, boundary, contact, rows, body) == 1:
                            control[WANTS_ROWS] = 1.0
                if ti.static(tied):
                    if state != PRODUCT and state != VISCOUS:
                        follow(body.u, body.v, boundary.nodes, images)
                if ti.static(loaded != ""):
                    moved = control[AFTER] > 0.0 and (state == PASS or state == BOUNDARY or state == KICK)
                    if state == LOADS or (moved and asks(boundary) == 0):
                        apply_loads(body, boundary, number)
                    elif moved:
                        control[WANTS_LOADS] = 1.0
                        again = 0
                if ti.static(body.averaged and contact_model == "massless"):
                    if again == 1 and first == 1:
                        ring_changes(body)
                if again == 1:
                    state = MEASURED
                    if ti.static(not measures):
                        control[FIRST] = float(first)
                        control[WANTS_MEASURE] = 1.0
                        state = STOP
                    elif control[WANTS_ROWS] == 1.0:
                        control[FIRST] = float(first)
                        state = STOP
                elif state == STOP or stop == 1 or number >= int(control[ROWS]) or int(control[START]) != PASS:
                    state = STOP
                else:
                    state = PASS
            control[ROWS_DONE] = float(number)

    made = kernel_of(serial_step, signature, options=options, driven=driven)
    return compiled_with(made, **KEEP_VECTORS, **LEAVE_TO_LLVM)  # it would take longer than many runs
