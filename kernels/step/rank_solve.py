"""The static solve of contact nodes that several ranks share, in phases between which the ranks exchange numbers.

The phases are those of `resolve` (static/solve.py) and `sweep` (static/sweeps.py), from the same functions; the host
launches them (tcontact/contact/shared_solve.py):

    measure      force of the contact cells at every node, |f_cell| summed          -> summed over the ranks
    assemble     right sides and constraints; force scale, residual, rounding       -> largest of the ranks
    judge        what is left to do
    linearise    parts of K_KK of the cells of this rank                            -> summed at the owner of a row
    invert       diagonal blocks; smallest pivot and largest trace                  -> extremes of the ranks
    begin        d = 0, and what the sweeps need
    colour       one colour of a sweep                                              -> d goes to the copies and ghosts
    end          friction back to the rows                                          -> friction goes to the copies
    length, move x_K += B d
    conclude     whether another measure is needed

A contact node has copies on all ranks with a cell at it. All of them have its rows, right side and diagonal block; its
owner alone updates it. Behind the contact nodes of a rank stand its ghosts: nodes of other ranks to which the rows of
its own nodes refer.
"""

import functools

from ..contact.cell_viscosity import viscous_force
from ..contact.friction import STEP
from ..contact.friction_laws import set_coefficients
from ..contact.islands import first_node, node_count
from ..contact.obstacle_rows import fill_rows
from ..engine import ti
from ..language.bundles import ContactOptions
from ..language.compile_options import KEEP_VECTORS, LEAVE_TO_LLVM, compiled_with
from ..language.signatures import Signature, kernel_of
from ..static.control import MINIMUM_FORCE, SETTINGS, goals
from ..static.friction_lanes import end_friction
from ..static.massless_node import square
from ..static.residual import assemble_node, collect, note_measure, rounding_of_node, set_right
from ..static.solve import conclude, couplings_of_node, invert_diagonal, judge_island, make_linearise, summed
from ..static.sweeps import advance_of_pair, begin_sweeps, extrapolate, longest_increment, move_by, sweep_range
from .rank_phases import (
    ADVANCE,
    ASSEMBLE,
    BACKWARD,
    BEGIN,
    BEGIN_AT,
    CONCLUDE,
    END,
    END_AT,
    EXTRAPOLATE,
    FACTOR,
    FIRST,
    INVERT,
    ISLAND_AT,
    JUDGE,
    LENGTH,
    LINEARISE,
    MEASURE,
    MEASURED,
    MOVE,
    PHASE,
    RESULT,
)


@ti.func
def measure_nodes(
    body: ti.template(), contact: ti.template(), viscous_cells: ti.template(), measured: ti.template()
):  # fmt: skip
    """Sum up forces of the contact cells of this rank at all contact nodes, and the magnitudes of the elastic ones."""
    for k in range(node_count(contact)):
        force, magnitude = collect(body, contact, k)
        if ti.static(contact.options.viscous):
            force += viscous_force(body, contact, viscous_cells, k)
        for j in ti.static(range(3)):
            measured[MEASURED * k + j] = force[j]
        measured[MEASURED * k + 3] = magnitude


@ti.func
def assemble_copies(
    body: ti.template(), boundary: ti.template(), contact: ti.template(), rows: ti.template(), system: ti.template(),
    measured: ti.template(), island,
):  # fmt: skip
    """Set right sides and constraints of an island; return force scale, residual and rounding error of it [N]."""
    scale, residual, rounding = system.settings[island * SETTINGS + MINIMUM_FORCE], 0.0, 0.0
    for k in range(first_node(contact, island), first_node(contact, island + 1)):
        rounding = ti.max(rounding, rounding_of_node(body, contact, system, island, k))
        scale = ti.max(scale, measured[MEASURED * k + 3])
        force = ti.Vector([measured[MEASURED * k + j] for j in ti.static(range(3))])
        set_right(boundary, contact, system, k, force)
        residual = ti.max(residual, assemble_node(body, boundary, contact, rows, None, system, k))
    return scale, residual, rounding


@ti.func
def assemble_parts(
    body: ti.template(), pairs: ti.template(), contact: ti.template(), system: ti.template(), island,
):  # fmt: skip
    """Assemble the parts of K_KK of the cells of this rank; diagonal blocks stand in `inverse` until all are summed."""
    block = ti.static(contact.options.block)
    stride = system.stiffness.shape[0]
    for k in range(first_node(contact, island), first_node(contact, island + 1)):
        couplings_of_node(body, pairs, system, k, block)
        diagonal = summed(body, pairs, pairs.row_start[k], block)
        for i, j in ti.static(ti.ndrange(block, block)):
            system.inverse[(i * block + j) * stride + k] = diagonal[i, j]


@ti.func
def invert_diagonals(contact: ti.template(), system: ti.template(), island):
    """Invert the diagonal blocks of an island; return the smallest pivot over its trace, and the largest trace."""
    block = ti.static(contact.options.block)
    stride = system.stiffness.shape[0]
    weakest, stiffest = 1.0, 0.0
    for k in range(first_node(contact, island), first_node(contact, island + 1)):
        trace, pivot = invert_diagonal(contact, system, k, square(system.inverse, k, stride, block), block)
        stiffest = ti.max(stiffest, trace)
        weakest = ti.min(weakest, pivot / trace)
    return weakest, stiffest


@functools.cache
def make_rank_solve(
    signature: Signature, cells: tuple[tuple[str, str], ...], options: ContactOptions, plain: bool
):  # fmt: skip
    """Return the kernel that does the phase in control[PHASE], memoised.

    signature: of its bundles; cells, plain: as in `make_linearise`; options: of the contact.
    """
    linearise = make_linearise(cells, options.block, plain)

    @ti.func
    def rank_solve(
        body: ti.template(), boundary: ti.template(), obstacles: ti.template(), rows: ti.template(),
        contact: ti.template(), pairs: ti.template(), system: ti.template(), launch: ti.template(),
    ):  # fmt: skip
        control, measured, stats = ti.static(launch.control, launch.measured, system.stats)
        viscous = ti.static(launch.viscous_cells)
        ti.loop_config(serialize=True)
        for _ in range(1):
            phase, island = int(control[PHASE]), int(control[ISLAND_AT])
            begin, end, factor = int(control[BEGIN_AT]), int(control[END_AT]), control[FACTOR]
            if phase == MEASURE:
                fill_rows(obstacles, rows, contact, body.u)
                if ti.static(options.varied and options.static_friction):
                    step = contact.friction[STEP]
                    set_coefficients(body, boundary, obstacles, rows, None, contact, 0, 0, step)
                measure_nodes(body, contact, viscous, measured)
            elif phase == ASSEMBLE:
                scale, residual, rounding = assemble_copies(body, boundary, contact, rows, system, measured, island)
                control[RESULT], control[RESULT + 1], control[RESULT + 2] = scale, residual, rounding
            elif phase == JUDGE:
                note_measure(system, island, control[RESULT], control[RESULT + 1], control[RESULT + 2])
                judge_island(body, contact, system, viscous, island, int(control[FIRST]))
            elif phase == LINEARISE:
                linearise(body, contact, pairs, system, viscous, island)
                assemble_parts(body, pairs, contact, system, island)
            elif phase == INVERT:
                weakest, stiffest = invert_diagonals(contact, system, island)
                control[RESULT], control[RESULT + 1] = weakest, stiffest
            elif phase == BEGIN:
                begin_sweeps(contact, rows, system, island)
                minimum, aim, accepted = goals(stats, system.settings, island)
                control[RESULT], control[RESULT + 1], control[RESULT + 2] = 1.0 * minimum, 1.0 * aim, 1.0 * accepted
            elif phase == EXTRAPOLATE:
                extrapolate(contact, system, island, factor)
            elif phase == ADVANCE:
                control[RESULT] = advance_of_pair(contact, system, begin, end)
            elif phase == END:
                if ti.static(options.friction_in_lanes):
                    end_friction(contact, rows, system, island)
            elif phase == LENGTH:
                control[RESULT] = longest_increment(contact, system, island)
            elif phase == MOVE:
                move_by(body.u, contact, system, island, factor)
            elif phase == CONCLUDE:
                conclude(contact, system, island)

    return compiled_with(kernel_of(rank_solve, signature, options=options), **KEEP_VECTORS, **LEAVE_TO_LLVM)


@functools.cache
def make_rank_sweep(signature: Signature, options: ContactOptions):
    """Return the kernel that does one colour of a sweep, memoised: packs BEGIN_AT .. END_AT of `control`.

    It is launched most often, and so has no other arrays than the sweeps need.
    """

    @ti.func
    def rank_sweep(rows: ti.template(), contact: ti.template(), system: ti.template(), launch: ti.template()):
        control = ti.static(launch.control)
        ti.loop_config(serialize=True)
        for _ in range(1):
            begin, end = int(control[BEGIN_AT]), int(control[END_AT])
            backward = int(control[BACKWARD])
            control[RESULT] = sweep_range(contact, rows, system, begin, end, control[FACTOR], backward)

    return compiled_with(kernel_of(rank_sweep, signature, options=options), **KEEP_VECTORS, **LEAVE_TO_LLVM)
