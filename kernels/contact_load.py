"""Contact forces on nodes that keep their mass: the baselines (METHOD 2, end).

    penalty   lambda_p = kappa A_k max(0, -g_p(x^n)),  energy 1/2 kappa A_k max(0, -g_p)^2
    impulse   if g_p(x^n) <= 0: the least change of the kicked velocity v* with nu_p . v >= 0; lambda = impulse / dt

The contact nodes come first in the list of boundary nodes; their contact force leaves `force` (internal less contact).
"""

import functools

import taichi as ti

from .arguments import ARRAY, INDEX
from .boundary_nodes import hand_over, row, symmetric
from .local_contact import multipliers
from .planes import gap, normal, position


@ti.kernel
def penalty_load(
    nodes: INDEX,
    planes: ARRAY,
    plane_count: ti.i32,
    stiffness: ARRAY,
    reference: ARRAY,
    u: ARRAY,
    force: ARRAY,
    contact_force_out: ARRAY,
    sums_out: ARRAY,
):
    """stiffness [k] = kappa A_k [N/m]; sums_out [6]: total force, energy, nodes that press, 0."""
    ti.loop_config(serialize=True)
    for _ in range(1):
        sums = ti.Vector.zero(ti.f64, 6)
        for k in range(nodes.shape[0]):
            x = position(reference, k, u, nodes[k])
            total = ti.Vector.zero(ti.f64, 3)
            for p in range(plane_count):
                overlap = ti.max(0.0, -gap(planes, p, x))
                total += stiffness[k] * overlap * normal(planes, p)
                sums[3] += 0.5 * stiffness[k] * overlap * overlap
            hand_over(k, total, force, contact_force_out)
            for j in ti.static(range(3)):
                sums[j] += total[j]
            if total.norm() > 0.0:
                sums[4] += 1.0
        for j in ti.static(range(6)):
            sums_out[j] = sums[j]


@functools.cache
def make_impulse_load(slots: int):
    @ti.kernel
    def impulse_load(
        nodes: INDEX,
        planes: ARRAY,
        near: INDEX,
        inverse_mass: ARRAY,
        load: ARRAY,
        reference: ARRAY,
        u: ARRAY,
        v: ARRAY,
        span: ti.f64,
        force: ARRAY,
        contact_force_out: ARRAY,
        sums_out: ARRAY,
    ):
        """span: time the impulse is spread over [s]; sums_out as for the penalty, without energy."""
        ti.loop_config(serialize=True)
        for _ in range(1):
            sums = ti.Vector.zero(ti.f64, 6)
            for k in range(nodes.shape[0]):
                x = position(reference, k, u, nodes[k])
                flexible = symmetric(inverse_mass, k)
                free = row(v, nodes[k]) + span * (flexible @ (row(load, k) - row(force, k)))
                normals = ti.Matrix.zero(ti.f64, slots, 3)
                speeds = ti.Vector.one(ti.f64, slots)
                for p in ti.static(range(slots)):
                    plane = near[k * slots + p]
                    direction = normal(planes, plane)
                    if gap(planes, plane, x) <= 0.0:
                        speeds[p] = 0.0
                        for j in ti.static(range(3)):
                            normals[p, j] = direction[j]
                impulses = multipliers(free, normals, speeds, flexible, 0.0, slots)
                total = normals.transpose() @ impulses / span
                hand_over(k, total, force, contact_force_out)
                for j in ti.static(range(3)):
                    sums[j] += total[j]
                if total.norm() > 0.0:
                    sums[4] += 1.0
            for j in ti.static(range(6)):
                sums_out[j] = sums[j]

    return impulse_load
