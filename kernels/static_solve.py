"""Projected static solve of the massless contact nodes (METHOD 2, paper eqs 15-17).

    f_K(x_J, x_K) - f_ext,K = lambda nu,   g(x_K) >= 0,  lambda >= 0,  lambda g = 0

linearised at the predicted state, K_KK d = f_ext - f + lambda nu, and solved for the increment d by block Gauss-Seidel
over the nodes colour by colour, each node's own contact problem exactly. The surface is small: one thread, same bits.

stats [8]: 0 F_ref, 1 static residual (relative), 2 sweeps of this step, 3 smallest pivot of K_kk over its trace,
4 largest trace of K_kk, 5 the residual that the rounding of displacements and gaps alone can make.
"""

import functools

import taichi as ti

from .arguments import ARRAY, INDEX
from .boundary_nodes import row
from .local_contact import multipliers
from .massless_node import basis_of, block_of, constraints, largest, segment, unbalanced
from .planes import position

STALLED = 0.7  # sweeps that leave more than this share of a residual that may be rounding have met it
EPSILON = 32 * 2.220446049250313e-16  # rounding of what many displacements or a gap sum up to, over their size


@functools.cache
def make_assemble(block: int, slots: int):
    """Out-of-balance force of every contact node at the present state, and the static residual of the last solve."""

    @ti.kernel
    def assemble(
        nodes: INDEX,
        basis: ARRAY,
        planes: ARRAY,
        near: INDEX,
        reference: ARRAY,
        u: ARRAY,
        load: ARRAY,
        compliance: ARRAY,
        active: INDEX,
        corner_start: INDEX,
        corners: INDEX,
        minus_cell_force: ARRAY,
        least_force: ti.f64,
        right_out: ARRAY,
        stats_out: ARRAY,
    ):
        """right_out [k * block] = B^t (f_ext - f)."""
        ti.loop_config(serialize=True)
        for _ in range(1):
            scale = least_force
            residual = 0.0
            rounding = 0.0
            for k in range(nodes.shape[0]):
                moved = row(u, nodes[k]).norm() * stats_out[4]
                if compliance[k] > 0.0:
                    moved += position(reference, k, u, nodes[k]).norm() / compliance[k]
                rounding = ti.max(rounding, EPSILON * moved)
                force = ti.Vector.zero(ti.f64, 3)
                magnitude = 0.0
                for i in range(corner_start[k], corner_start[k + 1]):
                    part = -row(minus_cell_force, corners[i])
                    force += part
                    magnitude += part.norm()
                scale = ti.max(scale, magnitude)
                b = basis_of(basis, k, block)
                right = b.transpose() @ (row(load, k) - force)
                normals, gaps = constraints(planes, near, k, b, position(reference, k, u, nodes[k]), block, slots)
                rest = unbalanced(-right, normals, gaps, active[k], compliance[k], block, slots)
                residual = ti.max(residual, largest(rest))
                for j in ti.static(range(block)):
                    right_out[k * block + j] = right[j]
            stats_out[0] = scale
            stats_out[1] = residual / scale
            stats_out[5] = rounding / scale

    return assemble


@functools.cache
def make_blocks(block: int):
    """K_KK from the pair stiffnesses of the cells, and the inverse of its diagonal blocks."""

    @ti.kernel
    def blocks(
        row_start: INDEX,
        entry_start: INDEX,
        entry_pairs: INDEX,
        pair_values: ARRAY,
        values_out: ARRAY,
        inverse_out: ARRAY,
        stats_out: ARRAY,
    ):
        """values_out [e, block, block], inverse_out [k, block, block]; an unused component has stiffness 1."""
        for e in range(entry_start.shape[0] - 1):
            total = ti.Matrix.zero(ti.f64, block, block)
            for i in range(entry_start[e], entry_start[e + 1]):
                total += block_of(pair_values, entry_pairs[i], block)
            for i, j in ti.static(ti.ndrange(block, block)):
                values_out[(e * block + i) * block + j] = total[i, j]
        ti.loop_config(serialize=True)
        for _ in range(1):
            weakest = 1.0
            stiffest = 0.0
            for k in range(row_start.shape[0] - 1):
                diagonal = block_of(values_out, row_start[k], block)
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
            stats_out[3] = weakest
            stats_out[4] = stiffest

    return blocks


@functools.cache
def make_solve(block: int, slots: int):
    """Gauss-Seidel sweeps until the residual of the linearised problem is small, then x_K += B d.

    Down to `tolerance` it may take most_sweeps, on to the smaller `aim` only polishing_sweeps: where compression makes
    K_KK lose definiteness, endless sweeps would follow the unstable mode. No node moves further than `reach` [m]; from
    gaps >= 0 a part of a feasible increment is feasible.
    """

    @ti.kernel
    def solve(
        nodes: INDEX,
        basis: ARRAY,
        planes: ARRAY,
        near: INDEX,
        reference: ARRAY,
        compliance: ARRAY,
        row_start: INDEX,
        column: INDEX,
        values: ARRAY,
        inverse: ARRAY,
        right: ARRAY,
        sweeps: ti.i32,
        polishing_sweeps: ti.i32,
        most_sweeps: ti.i32,
        aim: ti.f64,
        tolerance: ti.f64,
        reach: ti.f64,
        u: ARRAY,
        increment: ARRAY,
        active_out: INDEX,
        stats: ARRAY,
    ):
        """Adds the sweeps it took to stats[2]; stats[1] becomes the residual of the linearised problem."""
        ti.loop_config(serialize=True)
        for _ in range(1):
            count = nodes.shape[0]
            for i in range(count * block):
                increment[i] = 0.0
            done, wanted = 0, sweeps
            residual, stalled = 1e300, 0
            while (done < polishing_sweeps and residual > aim and stalled == 0) or (
                done < most_sweeps and residual > ti.max(tolerance, stats[5])
            ):
                before = residual
                for _sweep in range(wanted):
                    for k in range(count):
                        rest = segment(right, k, block)
                        for e in range(row_start[k] + 1, row_start[k + 1]):
                            rest -= block_of(values, e, block) @ segment(increment, column[e], block)
                        b = basis_of(basis, k, block)
                        x = position(reference, k, u, nodes[k])
                        normals, gaps = constraints(planes, near, k, b, x, block, slots)
                        flexible = block_of(inverse, k, block)
                        free = flexible @ rest
                        pressing = multipliers(free, normals, gaps, flexible, compliance[k], slots)
                        d = free + flexible @ (normals.transpose() @ pressing)
                        mask = 0
                        for p in ti.static(range(slots)):
                            if pressing[p] > 0.0:
                                mask += 1 << p
                        active_out[k] = mask
                        for j in ti.static(range(block)):
                            increment[k * block + j] = d[j]
                done += wanted
                wanted = 10
                residual = 0.0
                for k in range(count):
                    rest = -segment(right, k, block)
                    for e in range(row_start[k], row_start[k + 1]):
                        rest += block_of(values, e, block) @ segment(increment, column[e], block)
                    b = basis_of(basis, k, block)
                    x = position(reference, k, u, nodes[k]) + b @ segment(increment, k, block)
                    normals, gaps = constraints(planes, near, k, b, x, block, slots)
                    left = unbalanced(rest, normals, gaps, active_out[k], compliance[k], block, slots)
                    residual = ti.max(residual, largest(left))
                residual /= stats[0]
                if residual > STALLED * before and residual <= stats[5]:
                    stalled = 1
            longest = 0.0
            for k in range(count):
                longest = ti.max(longest, segment(increment, k, block).norm())
            part = ti.min(1.0, reach / ti.max(longest, 1e-300))
            for k in range(count):
                move = part * (basis_of(basis, k, block) @ segment(increment, k, block))
                for j in ti.static(range(3)):
                    u[3 * nodes[k] + j] = u[3 * nodes[k] + j] + move[j]
            stats[1] = residual
            stats[2] = stats[2] + done

    return solve
