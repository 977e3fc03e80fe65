"""The static solve by projections on ranks that all have every contact node, in phases between which they add up.

The ranks share the contact cells. Each of them has all constraint rows, the whole right side and the whole K_KK, and
does the whole solve, so that products and projections need no message; the host launches the phases and adds what
the cells give (tcontact/contact/copied_solve.py):

    measure      rows; force of the contact cells of this rank at every node, |f_cell|   -> summed over the ranks
    assemble     right sides and constraints, residual; what is left to do
    linearise    parts of K_KK of the cells of this rank                                 -> summed over the ranks
    invert       diagonal blocks
    solve        MPRGP (mprgp.py), pairs with friction pair_sliding.py; x_K += B d; whether another measure is needed
    renew        whether rows of pairs must be built anew where the nodes are now

All ranks add in one order and so have equal bits, and decide alike.
"""

import functools

from ..contact.friction import STEP
from ..contact.friction_laws import set_coefficients
from ..contact.islands import first_node
from ..contact.obstacle_rows import fill_rows
from ..contact.pair_rows import collect as collect_forces
from ..contact.pair_rows import fill_pair_rows, is_stale
from ..engine import ti
from ..language.bundles import ContactOptions
from ..language.compile_options import KEEP_VECTORS, LEAVE_TO_LLVM, compiled_with
from ..language.signatures import Signature, kernel_of
from ..static.chosen_rows import choose_rows
from ..static.control import MINIMUM_FORCE, PIVOT, REACH, SETTINGS, STALE, STATS, STIFFEST
from ..static.residual import assemble_node, note_measure, rounding_of_node, set_right
from ..static.solve import judge_island, make_linearise, solve_island
from .rank_phases import ASSEMBLE, FIRST, INVERT, ISLAND_AT, LINEARISE, MEASURE, MEASURED, PHASE, RENEW, RESULT, SOLVE
from .rank_solve import assemble_copies, assemble_parts, invert_diagonals, measure_nodes


@ti.func
def assemble_pairs(
    body: ti.template(), boundary: ti.template(), contact: ti.template(), rows: ti.template(),
    coupling: ti.template(), system: ti.template(), measured: ti.template(), island,
):  # fmt: skip
    """Set the right sides and constraints of the linear problem of an island, and note its static residual."""
    scale, residual, rounding = system.settings[island * SETTINGS + MINIMUM_FORCE], 0.0, 0.0
    begin, end = first_node(contact, island), first_node(contact, island + 1)
    for k in range(begin, end):
        rounding = ti.max(rounding, rounding_of_node(body, contact, system, island, k))
        scale = ti.max(scale, measured[MEASURED * k + 3])
        force = ti.Vector([measured[MEASURED * k + j] for j in ti.static(range(3))])
        set_right(boundary, contact, system, k, force)
    if ti.static(rows.at.lift >= 0):
        for k in range(begin, end):
            choose_rows(contact, rows, system, k, system.settings[island * SETTINGS + REACH])
    collect_forces(coupling, contact, rows, system.right, 0, system.stiffness.shape[0], contact.options.block)
    for k in range(begin, end):
        residual = ti.max(residual, assemble_node(body, boundary, contact, rows, coupling, system, k))
    note_measure(system, island, scale, residual, rounding)


@functools.cache
def make_rank_copies(
    signature: Signature, cells: tuple[tuple[str, str], ...], options: ContactOptions, plain: bool
):  # fmt: skip
    """Return the kernel that does the phase in control[PHASE], memoised.

    signature: of its bundles; cells, plain: as in `make_linearise`; options: of the contact.
    """
    linearise = make_linearise(cells, options.block, plain)
    block, coupled = options.block, options.coupled

    @ti.func
    def rank_copies(
        body: ti.template(), boundary: ti.template(), obstacles: ti.template(), rows: ti.template(),
        contact: ti.template(), coupling: ti.template(), pairs: ti.template(), system: ti.template(),
        launch: ti.template(),
    ):  # fmt: skip
        control, measured, stats = ti.static(launch.control, launch.measured, system.stats)
        viscous = ti.static(launch.viscous_cells)
        ti.loop_config(serialize=True)
        for _ in range(1):
            phase, island = int(control[PHASE]), int(control[ISLAND_AT])
            at = island * STATS
            if phase == MEASURE:
                fill_rows(obstacles, rows, contact, body.u)
                if ti.static(coupled):
                    fill_pair_rows(coupling, contact, boundary, rows, body)
                if ti.static(options.varied and options.static_friction):
                    step = contact.friction[STEP]
                    set_coefficients(body, boundary, obstacles, rows, coupling, contact, 0, 0, step)
                measure_nodes(body, contact, viscous, measured)
            elif phase == ASSEMBLE:
                if ti.static(coupled):
                    assemble_pairs(body, boundary, contact, rows, coupling, system, measured, island)
                else:
                    found = assemble_copies(body, boundary, contact, rows, system, measured, island)
                    note_measure(system, island, found[0], found[1], found[2])
                judge_island(body, contact, system, viscous, island, int(control[FIRST]))
            elif phase == LINEARISE:
                linearise(body, contact, pairs, system, viscous, island)
                assemble_parts(body, pairs, contact, system, island)
            elif phase == INVERT:
                weakest, stiffest = invert_diagonals(contact, system, island)
                stats[at + PIVOT], stats[at + STIFFEST], stats[at + STALE] = weakest, stiffest, 0.0
            elif phase == SOLVE:
                solve_island(body, contact, rows, coupling, system, island, block)
            if ti.static(coupled):
                if phase == RENEW:
                    fill_pair_rows(coupling, contact, boundary, rows, body)
                    control[RESULT] = float(is_stale(coupling, boundary, contact, rows, body))

    return compiled_with(kernel_of(rank_copies, signature, options=options), **KEEP_VECTORS, **LEAVE_TO_LLVM)
