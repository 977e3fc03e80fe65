"""Contact forces on nodes that keep their mass: the baselines (METHOD 2, end).

    penalty   lambda_p = kappa A_k max(0, -g_p(x^n)),  energy 1/2 kappa A_k max(0, -g_p)^2
    impulse   if g_p(x^n) <= 0: the least change of the kicked velocity v* with nu_p . v >= 0; lambda = impulse / dt

The contact nodes come first in the list of boundary nodes; their contact force leaves special_force (internal less
contact).
"""

import taichi as ti

from .boundary_nodes import hand_over, row, symmetric
from .local_contact import multipliers
from .planes import gap, normal, position


@ti.func
def penalty_load(body: ti.template(), touching: ti.template(), plane_count):
    """give [k] = kappa A_k [N/m]."""
    sums = ti.Vector.zero(ti.f64, 6)
    for k in range(touching.nodes.shape[0]):
        x = position(touching.reference, k, body.u, touching.nodes[k])
        total = ti.Vector.zero(ti.f64, 3)
        for p in range(plane_count):
            overlap = ti.max(0.0, 0.0 - gap(touching.planes, p, x))
            total += touching.give[k] * overlap * normal(touching.planes, p)
            sums[3] += 0.5 * touching.give[k] * overlap * overlap
        hand_over(body, touching, k, total)
        for j in ti.static(range(3)):
            sums[j] += total[j]
        if total.norm() > 0.0:
            sums[4] += 1.0
    for j in ti.static(range(6)):
        touching.sums[j] = sums[j]


@ti.func
def impulse_load(body: ti.template(), listed: ti.template(), touching: ti.template(), span, slots: ti.template()):
    """span: time the impulse is spread over [s]."""
    sums = ti.Vector.zero(ti.f64, 6)
    for k in range(touching.nodes.shape[0]):
        x = position(touching.reference, k, body.u, touching.nodes[k])
        flexible = symmetric(listed.inverse_mass, k)
        net = row(listed.load, k) - row(body.special_force, k)
        free = row(body.v, touching.nodes[k]) + span * (flexible @ net)
        normals = ti.Matrix.zero(ti.f64, slots, 3)
        speeds = ti.Vector.one(ti.f64, slots)
        for p in ti.static(range(slots)):
            plane = touching.near[k * slots + p]
            direction = normal(touching.planes, plane)
            if gap(touching.planes, plane, x) <= 0.0:
                speeds[p] = 0.0
                for j in ti.static(range(3)):
                    normals[p, j] = direction[j]
        impulses = multipliers(free, normals, speeds, flexible, 0.0, slots)
        total = normals.transpose() @ impulses / span
        hand_over(body, touching, k, total)
        for j in ti.static(range(3)):
            sums[j] += total[j]
        if total.norm() > 0.0:
            sums[4] += 1.0
    for j in ti.static(range(6)):
        touching.sums[j] = sums[j]
