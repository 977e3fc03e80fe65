"""Projected static solve of the massless contact nodes (METHOD 2, paper eqs 15-17).

    f_K(x_J, x_K) - f_ext,K = lambda nu,   g(x_K) >= 0,  lambda >= 0,  lambda g = 0

A measure of the contact cells gives f_K at the present state (`assemble`); `judge` says what is left to do; a
linearisation K_KK d = f_ext - f + lambda nu is solved for the increment d by `sweep` (sweeps.py), then x_K += B d.

`stats` and `settings` are numbered by the names below; a residual is relative to F_ref, the largest sum over the cells
of a node of |f_cell,k|. One thread: the surface is small, and the bits are the same on any number of threads.
"""

import functools

import taichi as ti

from .arguments import ARRAY, INDEX
from .boundary_nodes import row
from .internal_force import keep_vectors
from .lanes import SWEEP_LANES as LANES
from .massless_node import basis_of, block_of, constraints, largest, unbalanced
from .planes import position
from .static_bundles import Nodes, System
from .static_control import (
    BEFORE,
    DONE,
    F_REF,
    LEAST_FORCE,
    LINEARISE,
    MEASURE,
    NEXT,
    PIVOT,
    RESIDUAL,
    ROUNDING,
    STALE,
    STIFFEST,
    SWEEP,
    TODO,
    judge,
)
from .sweeps import move, sweep

EPSILON = 32 * 2.220446049250313e-16  # rounding of what many displacements or a gap sum up to, over their size


@ti.func
def assemble(nodes: ti.template(), system: ti.template(), block: ti.template(), slots: ti.template()):
    """Right sides B^t (f_ext - f), constraints and static residual of the contact nodes; clears the rows it reads."""
    stats = ti.static(system.stats)
    scale = system.settings[LEAST_FORCE]
    residual = 0.0
    rounding = 0.0
    for k in range(nodes.nodes.shape[0]):
        node = nodes.nodes[k]
        x = position(nodes.reference, k, nodes.u, node)
        moved = row(nodes.u, node).norm() * stats[STIFFEST]
        if nodes.compliance[k] > 0.0:
            moved += x.norm() / nodes.compliance[k]
        rounding = ti.max(rounding, EPSILON * moved)
        force = ti.Vector.zero(ti.f64, 3)
        magnitude = 0.0
        for i in range(system.corner_start[k], system.corner_start[k + 1]):
            part = row(system.rows, system.corner_rows[i])
            for j in ti.static(range(3)):
                system.rows[3 * system.corner_rows[i] + j] = 0.0
            force += part
            magnitude += part.norm()
        scale = ti.max(scale, magnitude)
        b = basis_of(nodes.basis, k, block)
        right = b.transpose() @ (row(nodes.load, k) - force)
        normals, gaps = constraints(nodes.planes, nodes.near, k, b, x, block, slots)
        rest = unbalanced(0.0 - right, normals, gaps, nodes.active[k], nodes.compliance[k], block, slots)
        residual = ti.max(residual, largest(rest))
        for j in ti.static(range(block)):
            system.right[k * block + j] = right[j]
        for p in ti.static(range(slots)):
            system.gaps[k * slots + p] = gaps[p]
            for j in ti.static(range(block)):
                system.normals[(k * slots + p) * block + j] = normals[p, j]
    stats[F_REF] = scale
    stats[BEFORE] = stats[RESIDUAL]
    stats[RESIDUAL] = residual / scale
    stats[ROUNDING] = rounding / scale


@functools.cache
def make_equilibrium(block: int, slots: int):
    """After a measure or a fresh tangent: what there is to do until the next of either; stats[NEXT] says which."""

    @ti.kernel
    def equilibrium(
        node_list: INDEX,
        basis: ARRAY,
        planes: ARRAY,
        near: INDEX,
        reference: ARRAY,
        u: ARRAY,
        load: ARRAY,
        compliance: ARRAY,
        active: INDEX,
        corner_start: INDEX,
        corner_rows: INDEX,
        rows: ARRAY,
        lane_start: INDEX,
        lane_node: INDEX,
        column: INDEX,
        values: ARRAY,
        inverse: ARRAY,
        stiffness: ARRAY,
        settings: ARRAY,
        right: ARRAY,
        gaps: ARRAY,
        normals: ARRAY,
        push: ARRAY,
        increment: ARRAY,
        stats: ARRAY,
        first: ti.i32,
        tangent_is_fresh: ti.i32,
    ):
        nodes = ti.static(Nodes(node_list, basis, planes, near, reference, u, load, compliance, active))
        system = ti.static(
            System(
                corner_start,
                corner_rows,
                rows,
                lane_start,
                lane_node,
                column,
                values,
                inverse,
                stiffness,
                settings,
                right,
                gaps,
                normals,
                push,
                increment,
                stats,
            )
        )
        ti.loop_config(serialize=True)
        for _ in range(1):
            if tangent_is_fresh == 0:
                assemble(nodes, system, block, slots)
                judge(stats, settings, first)
            else:
                stats[STALE] = 0.0
            stats[NEXT] = DONE
            if stats[TODO] != DONE:
                if stats[STALE] == 1.0:
                    stats[NEXT] = LINEARISE
                else:
                    sweep(nodes, system, block, slots)
                    move(nodes, system, block)
                    if stats[TODO] == SWEEP:
                        stats[NEXT] = MEASURE

    return keep_vectors(equilibrium)


@functools.cache
def make_blocks(block: int):
    """K_KK from the pair stiffnesses of the cells, in the order of the sweeps, and its inverted diagonal blocks."""

    @ti.kernel
    def blocks(
        row_start: INDEX,
        entry_start: INDEX,
        entry_pairs: INDEX,
        entry_place: INDEX,
        pair_values: ARRAY,
        values_out: ARRAY,
        inverse_out: ARRAY,
        stiffness_out: ARRAY,
        stats_out: ARRAY,
    ):
        """The first entry of a row is the diagonal; an unused component has stiffness 1 (in units of the trace)."""
        ti.loop_config(serialize=True)
        for _ in range(1):
            weakest = 1.0
            stiffest = 0.0
            for k in range(row_start.shape[0] - 1):
                for e in range(row_start[k] + 1, row_start[k + 1]):
                    total = summed(entry_start, entry_pairs, pair_values, e, block)
                    for i, j in ti.static(ti.ndrange(block, block)):
                        values_out[entry_place[e] + (i * block + j) * LANES] = total[i, j]
                diagonal = summed(entry_start, entry_pairs, pair_values, row_start[k], block)
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
                    inverse_out[(k * block + i) * block + j] = inverse[i, j]
                stiffness_out[k] = trace
            stats_out[PIVOT] = weakest
            stats_out[STIFFEST] = stiffest

    return blocks


@ti.func
def summed(entry_start: ti.template(), entry_pairs: ti.template(), pair_values: ti.template(), e, block: ti.template()):
    total = ti.Matrix.zero(ti.f64, block, block)
    for i in range(entry_start[e], entry_start[e + 1]):
        total += block_of(pair_values, entry_pairs[i], block)
    return total
