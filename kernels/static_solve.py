"""Projected static solve of the massless contact nodes (METHOD 2, paper eqs 15-17).

    f_K(x_J, x_K) - f_ext,K = lambda nu,   g(x_K) >= 0,  lambda >= 0,  lambda g = 0

A measure of the contact cells gives f_K at the present state (`assemble`); `judge` (static_control.py) says what is
left to do; a linearisation K_KK d = f_ext - f + lambda nu is solved for the increment d by `sweep` (sweeps.py), and
x_K += B d. Residuals are relative to F_ref, the largest sum over the cells of a node of |f_cell,k|.
"""

import functools

import taichi as ti

from . import elements
from .boundary_nodes import row
from .cell_viscosity import RATE, TANGENT_RATE, stiffen, viscous_force
from .friction import held
from .lanes import SWEEP_LANES as LANES
from .lanes import WIDTH
from .massless_node import (
    EPSILON,
    balance,
    basis_of,
    block_of,
    constraints,
    largest,
    off_the_obstacles,
    unbalanced,
)
from .materials import LAWS
from .obstacles import gap_and_normal, position
from .reduced_tangent import make_reduced_tangent
from .static_control import (
    BEFORE,
    CONVERGED,
    DONE,
    F_REF,
    LEAST_FORCE,
    MEASURE,
    NEXT,
    PIVOT,
    RESIDUAL,
    ROUNDING,
    STALE,
    STIFFEST,
    SWEEP,
    TODO,
    TOLERANCE,
    judge,
)
from .static_friction import note_slip
from .surface_tangent import make_surface_tangent
from .sweeps import move, sweep


@ti.func
def assemble(
    body: ti.template(),
    listed: ti.template(),
    touching: ti.template(),
    system: ti.template(),
    viscous: ti.template(),
    block: ti.template(),
    slots: ti.template(),
):
    """Right sides B^t (f_ext - f), constraints and static residual of the contact nodes; clears the rows it reads."""
    stats = ti.static(system.stats)
    scale = system.settings[LEAST_FORCE]
    stride = system.stiffness.shape[0]
    residual = 0.0
    rounding = 0.0
    for k in range(touching.nodes.shape[0]):
        node = touching.nodes[k]
        x = position(touching.reference, k, body.u, node)
        moved = row(body.u, node).norm() * stats[STIFFEST]
        if touching.give[k] > 0.0:
            moved += x.norm() / touching.give[k]
        rounding = ti.max(rounding, EPSILON * moved)
        force = ti.Vector.zero(ti.f64, 3)
        magnitude = 0.0
        for i in range(system.corner_rows[k], system.corner_rows[k + 1]):
            part = row(body.rows, system.corner_rows[i])
            for j in ti.static(range(3)):
                body.rows[3 * system.corner_rows[i] + j] = 0.0
            force += part
            magnitude += part.norm()
        scale = ti.max(scale, magnitude)
        if ti.static(touching.kinds.viscous):
            force += viscous_force(system, viscous, k)
        b = basis_of(touching.basis, k, block)
        right = b.transpose() @ (row(listed.load, k) - force)
        normals, gaps = constraints(touching, k, b, x, block, slots)
        out_of_balance = 0.0 - right
        if ti.static(touching.kinds.static_friction):
            out_of_balance = out_of_balance - b.transpose() @ held(touching, k)
            pressing, _rest = balance(out_of_balance, normals, touching.active[k], block, slots)
            directions = ti.Matrix.zero(ti.f64, slots, 3)
            for p in ti.static(range(slots)):
                _gap, direction = gap_and_normal(touching, touching.near[k * slots + p], x)
                for j in ti.static(range(3)):
                    directions[p, j] = direction[j]
            residual = ti.max(residual, note_slip(body, touching, k, x, pressing, directions))
        rest = unbalanced(out_of_balance, normals, gaps, touching.active[k], touching.give[k], block, slots)
        residual = ti.max(residual, largest(rest))
        # a linearised gap is not yet the gap, and a wall may have left the node it was predicted to take along
        closed = ti.Vector([(touching.active[k] >> p) & 1 for p in ti.static(range(slots))])
        residual = ti.max(residual, system.stiffness[k] * off_the_obstacles(touching, k, x, gaps, closed, slots))
        for j in ti.static(range(block)):
            system.right[j * stride + k] = right[j]
        for p in ti.static(range(slots)):
            system.gaps[p * stride + k] = gaps[p]
            for j in ti.static(range(block)):
                system.normals[(p * block + j) * stride + k] = normals[p, j]
    stats[F_REF] = scale
    stats[BEFORE] = stats[RESIDUAL]
    stats[RESIDUAL] = residual / scale
    stats[ROUNDING] = rounding / scale


@ti.func
def summed(pairs: ti.template(), e, block: ti.template()):
    """Entry e of K_KK."""
    total = ti.Matrix.zero(ti.f64, block, block)
    for i in range(pairs.entry_start[e], pairs.entry_start[e + 1]):
        pair = pairs.entry_pairs[i]
        if pair >= 0:
            total += block_of(pairs.values, pair, block)
        else:
            total += block_of(pairs.values, -1 - pair, block).transpose()
    return total


@ti.func
def blocks(pairs: ti.template(), system: ti.template(), block: ti.template()):
    """K_KK from the pair stiffnesses of the cells, in the order of the sweeps, and its inverted diagonal blocks.

    The first entry of a row is the diagonal; an unused component gets the trace as its stiffness.
    """
    stride = system.stiffness.shape[0]
    weakest = 1.0
    stiffest = 0.0
    for k in range(pairs.row_start.shape[0] - 1):
        for e in range(pairs.row_start[k] + 1, pairs.row_start[k + 1]):
            total = summed(pairs, e, block)
            for i, j in ti.static(ti.ndrange(block, block)):
                system.values[pairs.entry_place[e] + (i * block + j) * LANES] = total[i, j]
        diagonal = summed(pairs, pairs.row_start[k], block)
        trace = diagonal.trace()
        stiffest = ti.max(stiffest, trace)
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
        weakest = ti.min(weakest, pivot / trace)
        inverse = filled.inverse()
        for i, j in ti.static(ti.ndrange(block, block)):
            system.inverse[(i * block + j) * stride + k] = inverse[i, j]
        system.stiffness[k] = trace
    system.stats[PIVOT] = weakest
    system.stats[STIFFEST] = stiffest


@functools.cache
def make_resolve(kind: str, law: str, block: int, slots: int, plain: bool):
    """resolve(body, listed, touching, pairs, system, viscous, first): what follows a measure.

    stats[NEXT] asks for more; viscous: data of viscous contact cells (cell_viscosity.py).
    """
    integration = elements.FUNCTIONS[kind].tangent
    if integration == "reduced":
        tangent = make_reduced_tangent(law, block, WIDTH)
    else:
        tangent = make_surface_tangent(law, block, plain, integration == "mean-dilatation", WIDTH)
    refuses = LAWS[law].refusal != ""

    @ti.func
    def resolve(
        body: ti.template(),
        listed: ti.template(),
        touching: ti.template(),
        pairs: ti.template(),
        system: ti.template(),
        viscous: ti.template(),
        first,
    ):
        stats = ti.static(system.stats)
        assemble(body, listed, touching, system, viscous, block, slots)
        if ti.static(touching.kinds.viscous):
            if viscous[RATE] != viscous[TANGENT_RATE]:
                stats[STALE] = 1.0
        judge(stats, system.settings, first)
        stats[NEXT] = DONE
        if stats[TODO] != DONE:
            if stats[STALE] == 1.0:
                tangent(body, touching.basis, pairs)
                if ti.static(touching.kinds.viscous):
                    stiffen(pairs, viscous, block)
                blocks(pairs, system, block)
                stats[STALE] = 0.0
            sweep(touching, system, block, slots)
            move(body.u, touching, system, block)
            if stats[TODO] == SWEEP:
                stats[NEXT] = MEASURE
        stats[CONVERGED] = 0.0
        if stats[RESIDUAL] <= ti.max(system.settings[TOLERANCE], stats[ROUNDING]):
            # beyond the limit of a law a node's own tangent is not positive definite
            if not refuses or stats[PIVOT] > 0.0:
                stats[CONVERGED] = 1.0

    return resolve
