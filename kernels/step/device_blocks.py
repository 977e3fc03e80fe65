"""The boundary nodes of a step on a GPU, and the passes of its static solve, by several blocks of threads.

Where contact nodes are many, one block (device_contact.py) is one processor of many. Its work is split here where one
thread needs what others have found, into launches in which every node or cell has a thread of its own:

    load        viscous force; rows; contact load and what it leaves for other nodes
    move        left forces received; friction of the kick; kick and drift; x_K predicted
    reactions   with supports
    close       one block: sums of the row, tangents that are due, the next pass
    measure     rows and residual at x_K, after the force of the contact cells
    judge       one block: what is left to do
    linearise   stiffness of the contact cells, where it is due
    assemble    rows of K_KK, where they are due
    solve       one block: sweeps or products; x_K += B d; or sweeps begin (device_sweeps.py)

Sums are taken by blocks, and of these by the next launch of one block (language/threads.py).
"""

from ..columns import SUMS
from ..contact.cell_viscosity import POWER, RATE, viscous_load
from ..contact.constraint_rows import apply_kick_friction, apply_rows
from ..contact.islands import island_count
from ..contact.kick_friction import kick_friction
from ..contact.obstacle_rows import fill_rows, obstacle_loads, smallest_gap
from ..engine import ti
from ..lanes import BLOCK_THREADS, DEVICE_BLOCK, GRAVITY
from ..language.bundles import ContactOptions
from ..language.threads import folded, item, leader, meet, over_blocks, put_sums, turns
from ..nodes.boundary_nodes import damp, kick_and_drift, support_reactions
from ..nodes.device_nodes import step_numbers
from ..static.control import DONE, MEASURE, NEXT, STALE, STATS, SWEEPS, TODO
from ..static.massless_contact import note_remaining, receive_shares, share_load
from ..static.residual import measure_nodes, note_measure
from ..static.solve import blocks_of_nodes, decide, make_linearise, note_extremes, solve_island
from .device_control import (
    DEVICE_CONTROL,
    FIRST,
    TAKEN,
    begin_counts,
    end_pass,
    row_of,
    takes_pass,
    takes_step,
    want_pass,
)
from .device_placing import placed, rate_of
from .device_sweeps import begin_island, solve_place

MEASURES, EXTREMES = ("max",) * 3, ("min", "max")  # of an island: scale, residual, rounding; pivot, trace


def make_boundary_launches(options: ContactOptions, blocks: int, exact: bool, has_supports: bool, damped: str):
    """Return boundary_launches(offer, before, after, steps, *bundles): it steps the boundary nodes.

    The arguments are those of `make_device_contact_step`.
    """
    extra = int(options.viscous)  # number of a row behind the sums: the power of viscous cells

    @ti.func
    def load(
        body: ti.template(), lists: ti.template(), boundary: ti.template(), obstacles: ti.template(),
        rows: ti.template(), contact: ti.template(), system: ti.template(), launch: ti.template(),
    ):  # fmt: skip
        ti.loop_config(block_dim=DEVICE_BLOCK)
        for t in range(blocks * DEVICE_BLOCK):
            if takes_step(lists) == 1:
                team = ti.static(contact.at_place(blocks, t))
                if ti.static(options.viscous):
                    viscous_load(body, boundary, team, launch.viscous_cells)
                fill_rows(obstacles, rows, team, body.u)
                share_load(body, boundary, team, rows, system)

    @ti.func
    def move(
        before: ti.template(), after: ti.template(), steps: ti.template(), body: ti.template(), lists: ti.template(),
        boundary: ti.template(), obstacles: ti.template(), rows: ti.template(), contact: ti.template(),
        launch: ti.template(),
    ):  # fmt: skip
        ti.loop_config(block_dim=DEVICE_BLOCK)
        for t in range(blocks * DEVICE_BLOCK):
            if takes_step(lists) == 1:
                team = ti.static(contact.at_place(blocks, t))
                numbers = step_numbers(body, steps, False)
                own = ti.static(body._replace(params=numbers))
                receive_shares(own, boundary, team)
                smallest_gap(obstacles, rows, team, own.u)
                apply_rows(own, team, rows)
                if ti.static(options.friction != ""):
                    kick_friction(own, boundary, team, rows, obstacles, None, damped)
                    apply_kick_friction(own, team, rows)
                if ti.static(options.tracked):
                    obstacle_loads(obstacles, rows, team, None, own.u)
                if ti.static(damped != ""):
                    damp(own, boundary, team, damped)
                kick_and_drift(own, boundary, team, "")
                if after > 0.0:
                    ratio = ti.select(before > 0.0, after / ti.max(before, 1e-300), 1.0)
                    fall = 0.5 * after * (before + after) * ti.Vector([numbers[GRAVITY + j] for j in range(3)])
                    placed(own, obstacles, rows, team, launch, ratio, fall, after, exact)

    @ti.func
    def reactions(
        body: ti.template(), lists: ti.template(), boundary: ti.template(), supports: ti.template(),
        contact: ti.template(),
    ):  # fmt: skip
        ti.loop_config(block_dim=DEVICE_BLOCK)
        for t in range(blocks * DEVICE_BLOCK):
            if takes_step(lists) == 1:
                support_reactions(body, boundary, supports, ti.static(contact.at_place(blocks, t)))

    @ti.func
    def close(
        offer: ti.template(), before: ti.template(), after: ti.template(), lists: ti.template(),
        contact: ti.template(), system: ti.template(), launch: ti.template(),
    ):  # fmt: skip
        ti.loop_config(block_dim=BLOCK_THREADS)
        for _ in range(BLOCK_THREADS):
            if takes_step(lists) == 1:
                number, width = row_of(lists, offer), contact.sums.shape[0]
                place = DEVICE_CONTROL + number * (width + extra)
                for turn in range(turns(contact, width)):
                    j = item(contact, turn)
                    if j == SUMS.gap_min:
                        lists.control[place + j] = folded(contact, j, blocks, "min")
                    else:
                        lists.control[place + j] = folded(contact, j, blocks, "sum")
                worst, sweeps = 0.0, 0.0
                for island in range(island_count(contact)):
                    residual = over_blocks(contact, width + island, blocks, ("max",))[0]
                    worst = ti.max(worst, note_remaining(contact, system, island, residual))
                    sweeps = ti.max(sweeps, system.stats[island * STATS + SWEEPS])
                power = 0.0
                if ti.static(options.viscous):
                    power = over_blocks(contact, width + island_count(contact), blocks, ("sum",))[0]
                meet(contact)
                if leader(contact) == 1:
                    lists.control[place + SUMS.static_residual] = worst
                    lists.control[place + SUMS.sweeps] = sweeps
                    if ti.static(options.viscous):
                        launch.viscous_cells[POWER] = power * rate_of(before)
                        lists.control[place + width] = power * rate_of(before)
                        if after == 0.0:
                            launch.viscous_cells[RATE] = rate_of(before)
                    lists.control[TAKEN] = number + 1.0
                    if offer == 0:
                        begin_counts(lists)
                    if after > 0.0:
                        want_pass(lists)

    @ti.func
    def boundary_launches(
        offer: ti.template(), before: ti.template(), after: ti.template(), steps: ti.template(), body: ti.template(),
        lists: ti.template(), boundary: ti.template(), supports: ti.template(), obstacles: ti.template(),
        rows: ti.template(), contact: ti.template(), system: ti.template(), launch: ti.template(),
    ):  # fmt: skip
        load(body, lists, boundary, obstacles, rows, contact, system, launch)
        move(before, after, steps, body, lists, boundary, obstacles, rows, contact, launch)
        if ti.static(has_supports):
            reactions(body, lists, boundary, supports, contact)
        close(offer, before, after, lists, contact, system, launch)

    return boundary_launches


def make_solve_launches(
    kinds: tuple[tuple[str, str], ...], options: ContactOptions, blocks: int, plain: bool, colours: int
):  # fmt: skip
    """Return solve_launches(*bundles): one iteration of the static solve after the force of the contact cells.

    The arguments are those of `make_device_pass`; with colours the sweeps follow in launches of their own.
    """
    linearise_cells = make_linearise(kinds, options.block, plain, options.threads)
    block = options.block

    @ti.func
    def measure(
        body: ti.template(), lists: ti.template(), boundary: ti.template(), obstacles: ti.template(),
        rows: ti.template(), contact: ti.template(), system: ti.template(), viscous: ti.template(),
    ):  # fmt: skip
        ti.loop_config(block_dim=DEVICE_BLOCK)
        for t in range(blocks * DEVICE_BLOCK):
            if takes_pass(lists) == 1:
                team = ti.static(contact.at_place(blocks, t))
                fill_rows(obstacles, rows, team, body.u)
                for island in range(island_count(contact)):
                    if lists.control[FIRST] == 1.0 or system.stats[island * STATS + NEXT] == MEASURE:
                        found = measure_nodes(body, boundary, team, rows, None, system, viscous, island)
                        places = [solve_place(contact, 3 * island + i) for i in range(3)]
                        put_sums(team, None, places, [found[0], found[1], found[2]], MEASURES)

    @ti.func
    def judge(
        body: ti.template(), lists: ti.template(), contact: ti.template(), system: ti.template(),
        viscous: ti.template(),
    ):  # fmt: skip
        ti.loop_config(block_dim=BLOCK_THREADS)
        for _ in range(BLOCK_THREADS):
            if takes_pass(lists) == 1:
                first = ti.cast(lists.control[FIRST], ti.i32)
                for island in range(island_count(contact)):
                    if first == 1 or system.stats[island * STATS + NEXT] == MEASURE:
                        found = over_blocks(contact, solve_place(contact, 3 * island), blocks, MEASURES)
                        if leader(contact) == 1:
                            note_measure(system, island, found[0], found[1], found[2])
                        decide(body, contact, system, viscous, island, first)
                    elif leader(contact) == 1:
                        system.stats[island * STATS + TODO] = DONE

    @ti.func
    def linearise(
        body: ti.template(), lists: ti.template(), contact: ti.template(), pairs: ti.template(),
        system: ti.template(), viscous: ti.template(),
    ):  # fmt: skip
        ti.loop_config(block_dim=DEVICE_BLOCK)
        for t in range(blocks * DEVICE_BLOCK):
            if takes_pass(lists) == 1:
                for island in range(island_count(contact)):
                    if is_due(system, island) == 1:
                        team = ti.static(contact.at_place(blocks, t))
                        linearise_cells(body, team, pairs, system, viscous, island)

    @ti.func
    def assemble(
        body: ti.template(), lists: ti.template(), contact: ti.template(), pairs: ti.template(), system: ti.template()
    ):
        ti.loop_config(block_dim=DEVICE_BLOCK)
        for t in range(blocks * DEVICE_BLOCK):
            if takes_pass(lists) == 1:
                for island in range(island_count(contact)):
                    if is_due(system, island) == 1:
                        team = ti.static(contact.at_place(blocks, t))
                        weakest, stiffest = blocks_of_nodes(body, pairs, team, system, island, block)
                        places = [extremes_place(contact, island) + i for i in range(2)]
                        put_sums(team, None, places, [weakest, stiffest], EXTREMES)

    @ti.func
    def solve(
        body: ti.template(), lists: ti.template(), rows: ti.template(), contact: ti.template(), system: ti.template()
    ):
        ti.loop_config(block_dim=BLOCK_THREADS)
        for _ in range(BLOCK_THREADS):
            if takes_pass(lists) == 1:
                for island in range(island_count(contact)):
                    renew_tangent(contact, system, island, blocks)
                    meet(contact)
                    solve_island(body, contact, rows, None, system, island, block)
                if leader(contact) == 1:
                    end_pass(lists, system, 0)

    @ti.func
    def begin(lists: ti.template(), contact: ti.template(), system: ti.template()):
        ti.loop_config(block_dim=DEVICE_BLOCK)
        for t in range(blocks * DEVICE_BLOCK):
            if takes_pass(lists) == 1:
                team = ti.static(contact.at_place(blocks, t))
                for island in range(island_count(contact)):
                    if t < DEVICE_BLOCK:
                        renew_tangent(team, system, island, blocks)
                    begin_island(team, system, island)

    @ti.func
    def solve_launches(
        body: ti.template(), lists: ti.template(), boundary: ti.template(), obstacles: ti.template(),
        rows: ti.template(), contact: ti.template(), pairs: ti.template(), system: ti.template(),
        viscous: ti.template(),
    ):  # fmt: skip
        measure(body, lists, boundary, obstacles, rows, contact, system, viscous)
        judge(body, lists, contact, system, viscous)
        linearise(body, lists, contact, pairs, system, viscous)
        assemble(body, lists, contact, pairs, system)
        if ti.static(colours > 0):
            begin(lists, contact, system)
        else:
            solve(body, lists, rows, contact, system)

    return solve_launches


@ti.func
def is_due(system: ti.template(), island):
    """Return 1 if an island is to be solved with a new tangent, else 0."""
    due = system.stats[island * STATS + TODO] != DONE and system.stats[island * STATS + STALE] == 1.0
    return ti.select(due, 1, 0)


@ti.func
def renew_tangent(contact: ti.template(), system: ti.template(), island, blocks: ti.template()):
    """Note the extremes of a new tangent of an island, by the threads of one block."""
    if is_due(system, island) == 1:
        note_extremes(contact, system, island, over_blocks(contact, extremes_place(contact, island), blocks, EXTREMES))
        if leader(contact) == 1:
            system.stats[island * STATS + STALE] = 0.0


@ti.func
def extremes_place(contact: ti.template(), island):
    """Return the number in `partial` of the smallest pivot of an island, behind the measures of all."""
    return solve_place(contact, 3 * island_count(contact) + 2 * island)
