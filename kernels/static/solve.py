"""Projected static solve of the massless contact nodes (METHOD 2, paper eqs 15-17).

    f_K(x_J, x_K) - f_ext,K = lambda nu,   g(x_K) >= 0,  lambda >= 0,  lambda g = 0

The force pass over the contact cells gives f_K at the present state. `assemble` (residual.py) measures it, `judge`
(control.py) decides what is left to do, and the linearised problem K_KK d = f_ext - f + lambda nu is solved for the
increment d by `sweep` (sweeps.py) or `mprgp` (mprgp.py); then x_K += B d, with B the massless directions of a node.
Constraint rows hold g and nu at the present state; the solve does not know what the gap is measured to. Islands
(islands.py) are solved one after another, each as often as it needs. Residuals are relative to F_ref, the largest over
the nodes of the sum of |f_cell,k| over the cells of node k.
"""

import functools

from .. import elements
from ..contact.cell_viscosity import RATE, stiffen
from ..contact.islands import first_block, first_node, island_count
from ..engine import ti
from ..lanes import CONTACT_BLOCK, KIND, STEP
from ..lanes import SWEEP_LANES as LANES
from ..language.threads import item_between, leader, meet, over_threads, turns_between
from ..materials import LAWS
from ..node_places import PLACES
from .averaged_tangent import averaged_entry, sum_members
from .control import (
    CONVERGED,
    DONE,
    MAXIMUM_SOLVES,
    MEASURE,
    NEXT,
    PIVOT,
    REFUSES,
    RESIDUAL,
    ROUNDING,
    SETTINGS,
    SOLVES,
    STALE,
    STATS,
    STIFFEST,
    SWEEP,
    TODO,
    TOLERANCE,
    VISCOUS_RATE,
    judge,
)
from .damping_tangent import make_damping_tangent
from .massless_node import (
    block_of,
)
from .mprgp import mprgp
from .pair_sliding import accelerated
from .reduced_tangent import make_reduced_tangent
from .residual import assemble
from .surface_tangent import make_surface_tangent
from .sweeps import move, sweep
from .viscous_tangent import make_viscous_tangent


@ti.func
def summed(body: ti.template(), pairs: ti.template(), e, block: ti.template()):
    """Return entry e of K_KK [block, block], summed over the cells that contribute to it."""
    total = ti.Matrix.zero(ti.f64, block, block)
    if ti.static(body.averaged):
        total += averaged_entry(body, e, block)
    for i in range(pairs.entries[2 * e], pairs.entries[2 * e + 2]):
        pair = pairs.entry_pairs[i]
        if pair >= 0:
            total += block_of(pairs.values, pair, block)
        else:
            total += block_of(pairs.values, -1 - pair, block).transpose()
    return total


@ti.func
def blocks(
    body: ti.template(),
    pairs: ti.template(),
    contact: ti.template(),
    system: ti.template(),
    island,
    block: ti.template(),
):
    """Assemble K_KK of an island from the stiffness of its contact cells, in the order of the sweeps."""
    if ti.static(body.averaged):
        sum_members(body, contact, island)
    weakest, stiffest = blocks_of_nodes(body, pairs, contact, system, island, block)
    note_extremes(contact, system, island, over_threads(contact, [weakest, stiffest], ("min", "max")))


@ti.func
def blocks_of_nodes(
    body: ti.template(), pairs: ti.template(), contact: ti.template(), system: ti.template(), island,
    block: ti.template(),
):  # fmt: skip
    """Assemble the rows of an island in K_KK; return smallest pivot over its trace and largest trace of this thread."""
    weakest = 1.0
    stiffest = 0.0
    begin = first_node(contact, island)
    for turn in range(turns_between(contact, begin, first_node(contact, island + 1))):
        k = item_between(contact, begin, turn)
        trace, pivot = blocks_of_node(body, pairs, contact, system, k, block)
        stiffest = ti.max(stiffest, trace)
        weakest = ti.min(weakest, pivot / trace)
    return weakest, stiffest


@ti.func
def note_extremes(contact: ti.template(), system: ti.template(), island, extremes: ti.template()):
    """Note the smallest pivot of an island over its trace, and its largest trace [N/m]."""
    if leader(contact) == 1:
        system.stats[island * STATS + PIVOT] = extremes[0]
        system.stats[island * STATS + STIFFEST] = extremes[1]


@ti.func
def blocks_of_node(
    body: ti.template(), pairs: ti.template(), contact: ti.template(), system: ti.template(), k, block: ti.template()
):
    """Assemble the row of node k in K_KK and invert its diagonal block; return trace and smallest pivot of the block.

    The first entry of a row is the diagonal block.
    """
    couplings_of_node(body, pairs, system, k, block)
    return invert_diagonal(contact, system, k, summed(body, pairs, pairs.row_start[k], block), block)


@ti.func
def couplings_of_node(body: ti.template(), pairs: ti.template(), system: ti.template(), k, block: ti.template()):
    """Assemble the blocks off the diagonal of the row of node k in K_KK."""
    for e in range(pairs.row_start[k] + 1, pairs.row_start[k + 1]):
        total = summed(body, pairs, e, block)
        for i, j in ti.static(ti.ndrange(block, block)):
            system.values[pairs.entries[2 * e + 1] + (i * block + j) * LANES] = total[i, j]


@ti.func
def invert_diagonal(contact: ti.template(), system: ti.template(), k, diagonal, block: ti.template()):
    """Invert the diagonal block of node k in K_KK; return its trace and its smallest pivot.

    A component that B does not use gets the trace as its stiffness.
    """
    stride = system.stiffness.shape[0]
    trace = diagonal.trace()
    filled = diagonal
    for j in ti.static(range(block)):
        if diagonal[j, j] == 0.0:
            filled[j, j] = trace
    pivot = filled[0, 0]
    for j in ti.static(range(1, block)):
        pivot = ti.min(pivot, filled[j, j])
    if ti.static(block == 3):
        minor = filled[0, 0] * filled[1, 1] - filled[0, 1] * filled[1, 0]
        pivot = ti.min(pivot, minor / trace, filled.determinant() / (trace * trace))
    if ti.static(contact.options.coupled):
        for i, j in ti.static(ti.ndrange(block, block)):
            system.response[(PLACES[block].diagonal + i * block + j) * stride + k] = filled[i, j]
    else:
        inverse = filled.inverse()
        for i, j in ti.static(ti.ndrange(block, block)):
            system.inverse[(i * block + j) * stride + k] = inverse[i, j]
    system.stiffness[k] = trace
    return trace, pivot


@ti.func
def conclude(contact: ti.template(), system: ti.template(), island):
    """Decide whether an island needs another measure, and whether its solve has converged."""
    stats = ti.static(system.stats)
    at = island * STATS
    if stats[at + TODO] == SWEEP:
        stats[at + NEXT] = MEASURE
    stats[at + CONVERGED] = 0.0
    if ti.static(contact.options.coupled):
        # normals and weights of pairs change with the motion: a few solves a step, the rest is in the residual
        if stats[at + SOLVES] >= system.settings[island * SETTINGS + MAXIMUM_SOLVES]:
            stats[at + CONVERGED] = 1.0
    if stats[at + RESIDUAL] <= ti.max(system.settings[island * SETTINGS + TOLERANCE], stats[at + ROUNDING]):
        # beyond the limit of a law the diagonal block of some node is not positive definite
        if system.settings[island * SETTINGS + REFUSES] == 0.0 or stats[at + PIVOT] > 0.0:
            stats[at + CONVERGED] = 1.0


@ti.func
def decide(
    body: ti.template(), contact: ti.template(), system: ti.template(), viscous: ti.template(), island, first
):  # fmt: skip
    """Decide what is left to do for an island whose residual has been measured."""
    if leader(contact) == 1:
        judge_island(body, contact, system, viscous, island, first)
    meet(contact)


@ti.func
def judge_island(
    body: ti.template(), contact: ti.template(), system: ti.template(), viscous: ti.template(), island, first
):  # fmt: skip
    """Judge the residual of an island; a tangent that holds the viscosity of another step is renewed."""
    stats = ti.static(system.stats)
    at = island * STATS
    if ti.static(contact.options.viscous):
        if viscous[RATE] != stats[at + VISCOUS_RATE]:
            stats[at + STALE] = 1.0
    elif ti.static(body.viscous_metal):
        if body.params[STEP] != stats[at + VISCOUS_RATE]:
            stats[at + STALE] = 1.0
    judge(stats, system.settings, island, first)
    stats[at + NEXT] = DONE


@ti.func
def solve_island(
    body: ti.template(), contact: ti.template(), rows: ti.template(), coupling: ti.template(), system: ti.template(),
    island, block: ti.template(),
):  # fmt: skip
    """Solve the linear problem of an island and move its nodes, if that is to do, and conclude the iteration."""
    stats = ti.static(system.stats)
    at = island * STATS
    if stats[at + TODO] != DONE:
        solved = 0
        if ti.static(contact.options.coupled and contact.options.static_friction):
            solved = accelerated(contact, rows, coupling, system, island, block)
        elif ti.static(contact.options.projected):
            solved = mprgp(contact, rows, coupling, system, island, block)
        if ti.static(contact.options.coupled):  # pairs of bodies have no second solver
            if solved == 0:
                stats[at + TODO] = DONE
                stats[at + SOLVES] = 0.0
        elif solved == 0:
            sweep(contact, rows, system, island)
        if stats[at + TODO] != DONE:
            move(body.u, contact, system, island)
    if leader(contact) == 1:
        conclude(contact, system, island)
    meet(contact)


@functools.cache
def make_linearise(cells: tuple[tuple[str, str], ...], block: int, plain: bool, threads: int = 1):
    """Return linearise(body, contact, pairs, system, viscous, island), memoised; see `make_resolve`.

    It computes the stiffness between the contact nodes of every contact cell of an island at the present state.
    """
    tangents = [
        make_reduced_tangent(kind, law, block)
        if elements.FUNCTIONS[kind].tangent == "reduced"
        else make_surface_tangent(kind, law, block, plain, threads)
        for kind, law in cells
    ]
    viscous_tangents = [make_viscous_tangent(kind, block, plain) for kind, _law in cells]
    dampings = [make_damping_tangent(kind, block, plain) for kind, _law in cells]
    metals = [LAWS[law].plastic is not None for _kind, law in cells]

    @ti.func
    def linearise(
        body: ti.template(), contact: ti.template(), pairs: ti.template(), system: ti.template(),
        viscous: ti.template(), island,
    ):  # fmt: skip
        stats = ti.static(system.stats)
        at = island * STATS
        for number in range(first_block(contact, island), first_block(contact, island + 1)):
            for i in ti.static(range(len(tangents))):
                if pairs.blocks[number * CONTACT_BLOCK + KIND] == i:
                    tangents[i](body, contact, pairs, number)
                    if ti.static(body.viscous_metal and metals[i]):
                        viscous_tangents[i](body, contact.basis, pairs, number)
                    if ti.static(contact.options.viscous and metals[i]):
                        dampings[i](body, contact, pairs, viscous, number)
                    elif ti.static(contact.options.viscous):
                        stiffen(pairs, contact, viscous, block, number)
        if ti.static(contact.options.viscous):
            if leader(contact) == 1:
                stats[at + VISCOUS_RATE] = viscous[RATE]
        elif ti.static(body.viscous_metal):
            stats[at + VISCOUS_RATE] = body.params[STEP]
        meet(contact)

    return linearise


@functools.cache
def make_resolve(cells: tuple[tuple[str, str], ...], block: int, plain: bool, threads: int = 1):
    """Return resolve(body, boundary, contact, rows, coupling, pairs, system, viscous, first), memoised.

    It does one iteration of the static solve of every island. It is called after each force pass over the contact
    cells, with the rows filled at the present state; stats[NEXT] says which islands need another pass. It returns 1 if
    no node has moved since that pass, else 0. first: 1 at the first call of a time step; viscous: data of viscous
    contact cells (cell_viscosity.py); plain: every basis is the identity; threads: `ContactOptions.threads`.
    """
    linearise = make_linearise(cells, block, plain, threads)

    @ti.func
    def resolve_island(
        body: ti.template(),
        boundary: ti.template(),
        contact: ti.template(),
        rows: ti.template(),
        coupling: ti.template(),
        pairs: ti.template(),
        system: ti.template(),
        viscous: ti.template(),
        island,
        first,
    ):
        stats = ti.static(system.stats)
        at = island * STATS
        assemble(body, boundary, contact, rows, coupling, system, viscous, island)
        decide(body, contact, system, viscous, island, first)
        needed = stats[at + TODO] != DONE
        if ti.static(contact.options.free):
            needed = True  # the stable step of an obstacle that moves freely depends on it
        if needed and stats[at + STALE] == 1.0:
            linearise(body, contact, pairs, system, viscous, island)
            blocks(body, pairs, contact, system, island, block)
            if leader(contact) == 1:
                stats[at + STALE] = 0.0
            meet(contact)
        solve_island(body, contact, rows, coupling, system, island, block)

    @ti.func
    def resolve(
        body: ti.template(),
        boundary: ti.template(),
        contact: ti.template(),
        rows: ti.template(),
        coupling: ti.template(),
        pairs: ti.template(),
        system: ti.template(),
        viscous: ti.template(),
        first,
    ):
        still = 1
        for island in range(island_count(contact)):
            if first == 1 or system.stats[island * STATS + NEXT] == MEASURE:
                resolve_island(body, boundary, contact, rows, coupling, pairs, system, viscous, island, first)
                if system.stats[island * STATS + TODO] != DONE:
                    still = 0
        return still

    return resolve
