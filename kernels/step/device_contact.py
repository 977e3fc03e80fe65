"""The boundary nodes of a step on a GPU: load, kick, drift, prediction and static solve by one block of threads.

After the loops over cells and ordinary nodes (device_step.py) one block takes the boundary nodes, with the functions of
the CPU, whose loops its threads share (language/threads.py), or several where they are many (device_blocks.py):

    viscous cells     with viscous contact cells: their force of the step that ends here, a thread per cell
    boundary block    contact load lambda_k = max(0, nu.(f_k - f_ext,k)); friction; kick and drift, of obstacles that
                      move freely too; x_K predicted; loads of the next level   (METHOD 2 and 3)
    pass              force of the contact cells at x_K, a thread per cell; then one block: residual, tangent where it
                      is due, sweeps, x_K += B d; as often as the solve needs (static/control.py)

Contact by penalty or impulses, and supports or springs without contact, have the boundary block alone, and no pass.
Which of the launches does something is decided on the device (device_control.py).
"""

import functools

from ..contact.cell_viscosity import POWER, RATE, viscous_load
from ..contact.constraint_rows import apply_kick_friction, apply_rows
from ..contact.contact_load import impulse_load, penalty_load
from ..contact.free_obstacles import load_free_obstacles, place_free_obstacles
from ..contact.friction import STEP, clear_work
from ..contact.friction_laws import note_slip, set_coefficients
from ..contact.kick_friction import kick_friction, layer_slip
from ..contact.obstacle_rows import choose_candidates, fill_rows, obstacle_loads, smallest_gap
from ..contact.obstacles import RECORD, set_pose
from ..contact.pair_friction import kick_pair_friction
from ..contact.pair_loads import apply_to_masters
from ..contact.pair_rows import fill_pair_rows
from ..engine import ti
from ..lanes import BLOCK_THREADS, DEVICE_BLOCK, GRAVITY, MAXIMUM_SLOTS
from ..language.bundles import ContactOptions, Rigid
from ..language.compile_options import LEAVE_TO_LLVM, compiled_with
from ..language.signatures import Signature, kernel_of
from ..language.threads import item, leader, meet, turns
from ..layer.device_layers import begin_layers, end_layers, measure_layers
from ..layer_places import ROW as LAYER_ROW
from ..nodes.boundary_nodes import damp, kick_and_drift, support_reactions
from ..nodes.device_nodes import step_numbers
from ..nodes.driven_supports import accelerate, move_on
from ..nodes.loads import measure_loads
from ..nodes.rigid_body import move_bodies
from ..nodes.shared_loads import apply_shared_loads
from ..nodes.springs import measure_springs, spring_forces
from ..static.control import MEASURE, NEXT, any_island
from ..static.massless_contact import massless_load
from ..static.sliding import sliding_work
from ..static.solve import make_resolve
from .device_blocks import make_boundary_launches, make_solve_launches
from .device_control import (
    A_LAYER,
    A_PASS,
    DEVICE_CONTROL,
    FIRST,
    NOTHING,
    TAKEN,
    WANTS,
    begin_counts,
    end_pass,
    row_of,
    takes_pass,
    takes_step,
    want_layers,
    want_pass,
)
from .device_pairs import begin_pairs, load_pairs, look_at_pairs, press_pairs, squeezed
from .device_placing import placed, rate_of
from .device_step import STEPS, make_loops
from .device_surface import make_surface_cells
from .shared_rigid_rate import measure_shared_rigid_rate

CONTACT_STEPS = (*STEPS, "after")
NO_PARTS = Rigid()  # rigid parts step in another way (tcontact/planning/device_path.py)
# stages of a step, in launches of their own where something comes between: messages of other ranks, friction layers
FORCES, LOADS, MOTION = "forces", "loads", "motion"


@ti.func
def moves(lists: ti.template(), contact: ti.template(), before, after):
    """Return 1 if the boundary nodes are kicked and moved: in a step that is taken, behind the friction layers."""
    found = 0
    if ti.static(contact.options.layered):
        if lists.control[WANTS] == A_LAYER:
            found = end_layers(contact, before, after)
    else:
        found = takes_step(lists)
    return found


@ti.func
def contact_load(
    body: ti.template(), boundary: ti.template(), obstacles: ti.template(), rows: ti.template(),
    contact: ti.template(), system: ti.template(), before, after,
):  # fmt: skip
    """Fill the rows, and set and apply the contact force at the present positions."""
    if ti.static(contact.options.model != "massless" and contact.options.obstacle_slots == MAXIMUM_SLOTS):
        choose_candidates(obstacles, contact, body.u)
    fill_rows(obstacles, rows, contact, body.u)
    begin_pairs(body, boundary, contact, rows, system)
    smallest_gap(obstacles, rows, contact, body.u)
    if ti.static(contact.options.model == "massless"):
        massless_load(body, boundary, contact, rows, contact.coupling, system)
    elif ti.static(contact.options.model == "penalty"):
        penalty_load(contact, rows)
        press_pairs(body, contact, rows)
    else:
        impulse_load(body, boundary, contact, rows, ti.select(after > 0.0, 0.5 * (before + after), before))
    apply_rows(body, contact, rows)
    load_pairs(body, boundary, contact, rows)


@ti.func
def friction_work(
    body: ti.template(), boundary: ti.template(), obstacles: ti.template(), rows: ti.template(),
    contact: ti.template(), before, after,
):  # fmt: skip
    """Sum up the work of friction in the step that ends, and set the coefficients of the kick."""
    clear_work(contact)
    if ti.static(contact.options.static_friction):
        sliding_work(body, boundary, contact, rows, contact.coupling)
    if ti.static(contact.options.varied):
        first = ti.select(before > 0.0, 0, 1)
        set_coefficients(body, boundary, obstacles, rows, contact.coupling, contact, 1, first, after)


@ti.func
def friction_load(
    body: ti.template(), boundary: ti.template(), obstacles: ti.template(), rows: ti.template(),
    contact: ti.template(), rigid: ti.template(), damped: ti.template(),
):  # fmt: skip
    """Apply the friction of the kick to the contact nodes."""
    if ti.static(contact.options.kick_friction):
        if ti.static(contact.options.coupled):
            kick_pair_friction(body, boundary, contact, rows, contact.coupling, damped)
        else:
            kick_friction(body, boundary, contact, rows, obstacles, rigid, damped)
        apply_kick_friction(body, contact, rows)
        if ti.static(contact.options.coupled):
            apply_to_masters(contact.coupling, boundary, body, contact, rows, rows.at.kick_friction)


@ti.func
def set_loads(
    number, body: ti.template(), boundary: ti.template(), supports: ti.template(), obstacles: ti.template(),
    rows: ti.template(), contact: ti.template(), system: ti.template(), launch: ti.template(), before, after,
    driven: ti.template(), has_springs: ti.template(), damped: ti.template(),
):  # fmt: skip
    """Set what acts on the boundary nodes at the level but friction and damping; number: of the row."""
    if ti.static(contact.options.viscous):
        if leader(contact) == 1:
            launch.viscous_cells[RATE] = rate_of(before)
        viscous_load(body, boundary, contact, launch.viscous_cells)
    if ti.static(driven):
        accelerate(body, boundary, supports, contact, number)
    if ti.static(has_springs):
        spring_forces(body, boundary, contact, NO_PARTS, 0, damped)
    if ti.static(contact.options.model != ""):
        contact_load(body, boundary, obstacles, rows, contact, system, before, after)
    if ti.static(contact.options.friction != ""):
        friction_work(body, boundary, obstacles, rows, contact, before, after)


@ti.func
def load_freely(
    body: ti.template(), obstacles: ti.template(), rows: ti.template(), contact: ti.template(), pairs: ti.template(),
    rigid: ti.template(), before,
):  # fmt: skip
    """Set the load of the obstacles that move freely, and their rate for the stable step."""
    if leader(contact) == 1:
        load_free_obstacles(rigid, obstacles, contact)
    meet(contact)
    count = obstacles.records.shape[0] // RECORD
    measure_shared_rigid_rate(rigid, obstacles, rows, contact, pairs, body, before, count)


@functools.cache
def make_device_contact_step(
    kinds: tuple[tuple[str, str], ...], signature: Signature, threads: int, options: ContactOptions, exact: bool,
    has_supports: bool, driven: bool, has_springs: bool, measured: tuple[int, ...] = (), surface_threads: int = 0,
    loaded: str = "", damped: str = "", blocks: int = 1, stages: tuple[str, ...] = (FORCES, MOTION),
):  # fmt: skip
    """Return the step kernel of a domain with contact, memoised.

    step(offer, commit, *CONTACT_STEPS, *arrays): offer: number of the step among those offered in its block; commit
    and steps [s]: see `make_device_step`, after: the step that begins, 0 after the last row; options.model: "massless",
    "penalty", "impulse", or "" without contact; exact: massless without a penalty;
    has_supports: supports hold or move components; driven: functions of time move some of them;
    has_springs: springs act on boundary nodes; measured, surface_threads: with viscous contact cells, as in
    `make_device_pass`; loaded: "loads", "gravity" if that is a function of time, or "" without (loads.py); blocks: of
    threads that share the boundary nodes (device_blocks.py); stages: of the step in this launch: FORCES of the cells at
    all nodes, with which ordinary nodes move, LOADS of the boundary nodes up to what friction layers need
    (device_layers.py), MOTION of the boundary nodes, with their loads where there are no layers.
    """
    pulled = loaded == "gravity"
    cell_loop, node_loop = make_loops(kinds, threads, damped, True, pulled)
    viscous_cells_of = make_surface_cells(kinds, measured, surface_threads, False, options.viscous)
    viscous = int(options.viscous)  # number of a row behind the sums: the power of viscous cells; then those of layers
    extra = viscous + len(LAYER_ROW) * options.layered
    boundary_launches = make_boundary_launches(options, blocks, exact, has_supports, damped)

    @ti.func
    def viscous_loop(
        n: ti.template(), before: ti.template(), body: ti.template(), lists: ti.template(), launch: ti.template()
    ):
        ti.loop_config(block_dim=DEVICE_BLOCK)
        for t in range(surface_threads):
            if takes_step(lists) == 1:
                viscous_cells_of(n, t, rate_of(before), body, lists, launch.viscous_cells)

    @ti.func
    def load_block(
        offer: ti.template(), before: ti.template(), after: ti.template(), steps: ti.template(), body: ti.template(),
        lists: ti.template(), boundary: ti.template(), supports: ti.template(), obstacles: ti.template(),
        rows: ti.template(), contact: ti.template(), system: ti.template(), launch: ti.template(),
    ):  # fmt: skip
        ti.loop_config(block_dim=BLOCK_THREADS)
        for _ in range(BLOCK_THREADS):
            if takes_step(lists) == 1:
                number = row_of(lists, offer)
                numbers = step_numbers(body, steps, pulled)
                own = ti.static(body._replace(params=numbers))
                set_loads(
                    number, own, boundary, supports, obstacles, rows, contact, system, launch, before, after, driven,
                    has_springs, damped,
                )  # fmt: skip
                if ti.static(options.kick_friction and not options.static_friction):
                    layer_slip(own, boundary, contact, rows, damped)
                    meet(contact)
                begin_layers(contact, rows, obstacles, before, after)
                if leader(contact) == 1:
                    want_layers(lists, offer)

    @ti.func
    def boundary_block(
        offer: ti.template(), before: ti.template(), after: ti.template(), steps: ti.template(), body: ti.template(),
        lists: ti.template(), boundary: ti.template(), supports: ti.template(), obstacles: ti.template(),
        rows: ti.template(), contact: ti.template(), pairs: ti.template(), system: ti.template(),
        rigid: ti.template(), launch: ti.template(),
    ):  # fmt: skip
        ti.loop_config(block_dim=BLOCK_THREADS)
        for _ in range(BLOCK_THREADS):
            if moves(lists, contact, before, after) == 1:
                number = row_of(lists, offer)
                numbers = step_numbers(body, steps, pulled)
                own = ti.static(body._replace(params=numbers))
                if ti.static(not options.layered):
                    set_loads(
                        number, own, boundary, supports, obstacles, rows, contact, system, launch, before, after,
                        driven, has_springs, damped,
                    )  # fmt: skip
                if ti.static(options.friction != ""):
                    friction_load(own, boundary, obstacles, rows, contact, rigid, damped)
                if ti.static(options.tracked):
                    obstacle_loads(obstacles, rows, contact, rigid, own.u)
                if ti.static(options.free):
                    load_freely(own, obstacles, rows, contact, pairs, rigid, before)
                if ti.static(damped != ""):
                    damp(own, boundary, contact, damped)
                if ti.static(has_springs):
                    measure_springs(own, boundary, contact, NO_PARTS, 0, damped)
                if ti.static(has_supports):
                    support_reactions(own, boundary, supports, contact)
                if ti.static(loaded != ""):
                    measure_loads(own, boundary, contact)
                kick_and_drift(own, boundary, contact, loaded)
                if ti.static(driven):
                    move_on(own, boundary, supports, contact, number)
                if ti.static(options.free):
                    if leader(contact) == 1:
                        move_bodies(rigid, own, number + 1, damped, has_supports)
                if ti.static(options.varied and not options.static_friction):
                    note_slip(own, boundary, obstacles, rows, contact.coupling, contact)
                meet(contact)
                width = contact.sums.shape[0]
                if ti.static(options.layered):
                    measure_layers(contact, lists.control, DEVICE_CONTROL + number * (width + extra) + width + viscous)
                for turn in range(turns(contact, width)):
                    j = item(contact, turn)
                    lists.control[DEVICE_CONTROL + number * (width + extra) + j] = contact.sums[j]
                if leader(contact) == 1:
                    if ti.static(options.viscous):
                        power = launch.viscous_cells[POWER]
                        lists.control[DEVICE_CONTROL + number * (width + extra) + width] = power
                    lists.control[TAKEN] = number + 1.0
                    if ti.static(options.layered):
                        lists.control[WANTS] = NOTHING
                    if offer == 0:
                        begin_counts(lists)
                if ti.static(options.posed):
                    if after > 0.0:
                        set_pose(obstacles, contact, number + 1)
                if ti.static(options.free):
                    if after > 0.0 and leader(contact) == 1:
                        place_free_obstacles(rigid, obstacles)
                    meet(contact)
                if ti.static(options.model == "massless"):
                    if after > 0.0:
                        ratio = ti.select(before > 0.0, after / ti.max(before, 1e-300), 1.0)
                        fall = 0.5 * after * (before + after) * ti.Vector([numbers[GRAVITY + j] for j in range(3)])
                        placed(own, obstacles, rows, contact, launch, ratio, fall, after, exact)
                        if leader(contact) == 1:
                            want_pass(lists)
                        look_at_pairs(own, lists, boundary, contact, rows, True)
                elif ti.static(options.coupled):
                    if after > 0.0:
                        look_at_pairs(own, lists, boundary, contact, rows, False)
                if ti.static(loaded != ""):
                    if after > 0.0:
                        apply_shared_loads(ti.static(body if pulled else own), boundary, contact, number + 1, pulled)

    @ti.func
    def device_contact_step(
        offer: ti.template(), commit: ti.template(), before: ti.template(), kick_before: ti.template(),
        kick_after: ti.template(), drift: ti.template(), g0: ti.template(), g1: ti.template(), g2: ti.template(),
        after: ti.template(), body: ti.template(), lists: ti.template(), boundary: ti.template(),
        supports: ti.template(), obstacles: ti.template(), rows: ti.template(), contact: ti.template(),
        pairs: ti.template(), system: ti.template(), rigid: ti.template(), launch: ti.template(),
    ):  # fmt: skip
        steps = ti.static([kick_before, kick_after, drift, g0, g1, g2])
        if ti.static(FORCES in stages):
            for i in ti.static(range(len(kinds))):
                cell_loop(i, offer, commit, before, body, lists)
            node_loop(offer, steps, body, lists)
            for n in ti.static(range(len(measured))):
                viscous_loop(n, before, body, lists, launch)
        if ti.static(LOADS in stages):
            load_block(
                offer, before, after, steps, body, lists, boundary, supports, obstacles, rows, contact, system, launch
            )
        if ti.static(MOTION in stages and blocks > 1):
            boundary_launches(
                offer, before, after, steps, body, lists, boundary, supports, obstacles, rows, contact, system, launch
            )
        elif ti.static(MOTION in stages):
            boundary_block(
                offer, before, after, steps, body, lists, boundary, supports, obstacles, rows, contact, pairs, system,
                rigid, launch,
            )  # fmt: skip

    parts = {"options": options, "driven": driven}
    made = kernel_of(device_contact_step, signature, ("offer", "commit"), CONTACT_STEPS, **parts)
    return compiled_with(made, **LEAVE_TO_LLVM)


@functools.cache
def make_device_start(signature: Signature, options: ContactOptions, exact: bool):
    """Return the kernel that asks for a static solve at the start of a run, where nothing moves, memoised."""

    @ti.func
    def device_start(
        body: ti.template(), lists: ti.template(), boundary: ti.template(), obstacles: ti.template(),
        rows: ti.template(), contact: ti.template(), launch: ti.template(),
    ):  # fmt: skip
        ti.loop_config(block_dim=BLOCK_THREADS)
        for _ in range(BLOCK_THREADS):
            placed(body, obstacles, rows, contact, launch, 0.0, ti.Vector.zero(ti.f64, 3), 0.0, exact)
            if leader(contact) == 1:
                want_pass(lists)
            look_at_pairs(body, lists, boundary, contact, rows, True)

    return compiled_with(kernel_of(device_start, signature, options=options), **LEAVE_TO_LLVM)


@functools.cache
def make_device_pass(
    kinds: tuple[tuple[str, str], ...], measured: tuple[int, ...], signature: Signature, threads: int,
    options: ContactOptions, plain: bool, blocks: int = 1, colours: int = 0,
):  # fmt: skip
    """Return the kernel of one pass of the static solve, memoised.

    measured: the kinds, by number, that have contact cells; threads: of the loops over these; plain: every basis is the
    identity; blocks: as in `make_device_contact_step`; colours: of sweeps that are launched one by one, else 0.
    """
    cells_of = make_surface_cells(kinds, measured, threads, True, options.viscous)
    resolve = make_resolve(kinds, options.block, plain, options.threads)
    solve_launches = make_solve_launches(kinds, options, blocks, plain, colours)

    @ti.func
    def surface_loop(n: ti.template(), body: ti.template(), lists: ti.template(), launch: ti.template()):
        ti.loop_config(block_dim=DEVICE_BLOCK)
        for t in range(threads):
            if takes_pass(lists) == 1:
                rate = 0.0
                if ti.static(options.viscous):
                    rate = launch.viscous_cells[RATE]
                cells_of(n, t, rate, body, lists, launch.viscous_cells)

    @ti.func
    def solve_block(
        body: ti.template(), lists: ti.template(), boundary: ti.template(), obstacles: ti.template(),
        rows: ti.template(), contact: ti.template(), pairs: ti.template(), system: ti.template(),
        launch: ti.template(),
    ):  # fmt: skip
        ti.loop_config(block_dim=BLOCK_THREADS)
        for _ in range(BLOCK_THREADS):
            if lists.control[WANTS] == A_PASS:
                first = ti.cast(lists.control[FIRST], ti.i32)
                fill_rows(obstacles, rows, contact, body.u)
                if ti.static(options.coupled):
                    fill_pair_rows(contact.coupling, contact, boundary, rows, body)
                if ti.static(options.varied and options.static_friction):
                    here = contact.friction[STEP]
                    set_coefficients(body, boundary, obstacles, rows, contact.coupling, contact, 0, 0, here)
                resolve(body, boundary, contact, rows, contact.coupling, pairs, system, launch.viscous_cells, first)
                if leader(contact) == 1:
                    end_pass(lists, system, squeezed(contact))
                if ti.static(options.coupled):
                    if any_island(system.stats, NEXT, MEASURE) == 1:
                        look_at_pairs(body, lists, boundary, contact, rows, True)

    @ti.func
    def device_pass(
        body: ti.template(), lists: ti.template(), boundary: ti.template(), obstacles: ti.template(),
        rows: ti.template(), contact: ti.template(), pairs: ti.template(), system: ti.template(),
        launch: ti.template(),
    ):  # fmt: skip
        for n in ti.static(range(len(measured))):
            surface_loop(n, body, lists, launch)
        if ti.static(blocks > 1):
            solve_launches(body, lists, boundary, obstacles, rows, contact, pairs, system, launch.viscous_cells)
        else:
            solve_block(body, lists, boundary, obstacles, rows, contact, pairs, system, launch)

    return compiled_with(kernel_of(device_pass, signature, options=options), **LEAVE_TO_LLVM)
