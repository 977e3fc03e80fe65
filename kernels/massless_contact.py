"""Massless contact nodes around the static solve: their prediction, and lambda from the ordinary force pass (METHOD 2).

x_K^{n+1} ~ x_K^n + (x_K^n - x_K^{n-1}) + g dt^2,   moved out of the obstacle
lambda_k = max(0, nu . (f_k(x^n) - f_ext,k))   where the constraint is active
"""

import functools

import taichi as ti

from .arguments import ARRAY, INDEX
from .boundary_nodes import hand_over, row
from .local_contact import multipliers
from .massless_node import balance, basis_of, constraints, largest, segment
from .planes import normal, position


@functools.cache
def make_predict(block: int, slots: int):
    """x_K = x_K^n + (x_K^n - x_K^{n-1}) ratio + fall in the massless components; `outside`: moved out of the obstacle.

    fall = g dt^2 makes the prediction exact in free flight.
    """

    @ti.kernel
    def predict(
        nodes: INDEX,
        basis: ARRAY,
        planes: ARRAY,
        near: INDEX,
        reference: ARRAY,
        ratio: ti.f64,
        fall_x: ti.f64,
        fall_y: ti.f64,
        fall_z: ti.f64,
        outside: ti.i32,
        u: ARRAY,
        last: ARRAY,
    ):
        """u is advanced in place; last [k * block]: massless displacement one level back, before and after."""
        ti.loop_config(serialize=True)
        for k in range(nodes.shape[0]):
            node = nodes[k]
            b = basis_of(basis, k, block)
            now = b.transpose() @ row(u, node)
            step = ratio * (now - segment(last, k, block)) + b.transpose() @ ti.Vector([fall_x, fall_y, fall_z])
            if outside == 1:
                x = position(reference, k, u, node) + b @ step
                normals, gaps = constraints(planes, near, k, b, x, block, slots)
                free = ti.Vector.zero(ti.f64, block)
                identity = ti.Matrix.identity(ti.f64, block)
                step += normals.transpose() @ multipliers(free, normals, gaps, identity, 0.0, slots)
            move = b @ step
            for j in ti.static(range(block)):
                last[k * block + j] = now[j]
            for j in ti.static(range(3)):
                u[3 * node + j] = u[3 * node + j] + move[j]

    return predict


@functools.cache
def make_contact_load(block: int, slots: int):
    """lambda of every contact node from the force of the ordinary pass; the contact force leaves `force`."""

    @ti.kernel
    def contact_load(
        nodes: INDEX,
        basis: ARRAY,
        planes: ARRAY,
        near: INDEX,
        reference: ARRAY,
        u: ARRAY,
        load: ARRAY,
        compliance: ARRAY,
        active: INDEX,
        force: ARRAY,
        stats: ARRAY,
        contact_force_out: ARRAY,
        sums_out: ARRAY,
    ):
        """contact_force_out [k * 3] = sum lambda nu; sums_out [6]: total force, energy, nodes that press, residual."""
        ti.loop_config(serialize=True)
        for _ in range(1):
            sums = ti.Vector.zero(ti.f64, 6)
            for k in range(nodes.shape[0]):
                b = basis_of(basis, k, block)
                x = position(reference, k, u, nodes[k])
                normals, _gaps = constraints(planes, near, k, b, x, block, slots)
                out_of_balance = b.transpose() @ (row(force, k) - row(load, k))
                pressing, rest = balance(out_of_balance, normals, active[k], block, slots)
                total = ti.Vector.zero(ti.f64, 3)
                for p in ti.static(range(slots)):
                    total += pressing[p] * normal(planes, near[k * slots + p])
                    sums[3] += 0.5 * compliance[k] * pressing[p] * pressing[p]
                hand_over(k, total, force, contact_force_out)
                for j in ti.static(range(3)):
                    sums[j] += total[j]
                if total.norm() > 0.0:
                    sums[4] += 1.0
                sums[5] = ti.max(sums[5], largest(rest))
            sums[5] /= ti.max(stats[0], 1e-300)
            for j in ti.static(range(6)):
                sums_out[j] = sums[j]

    return contact_load
