"""Contact forces on nodes that keep their mass: the baselines (METHOD 2, end).

    penalty   lambda_p = kappa A_k max(0, -g_p(x^n)),  energy 1/2 kappa A_k max(0, -g_p)^2
    impulse   if g_p(x^n) <= 0: the least change of the kicked velocity v* with nu_p . v >= 0; lambda = impulse / dt

The contact nodes come first in the list of boundary nodes; their contact force leaves special_force (internal less
contact).
"""

import taichi as ti

from .boundary_nodes import hand_over, row, symmetric
from .columns import CONTACT, CONTACT_SUMS, FIRST
from .friction import PRESSING, trace_place
from .local_contact import multipliers
from .obstacles import VELOCITY, add_load, gap_and_normal, position, velocity_at


@ti.func
def penalty_load(body: ti.template(), touching: ti.template(), slots: ti.template()):
    """give [k] = kappa A_k [N/m]."""
    sums = ti.Vector.zero(ti.f64, CONTACT_SUMS)
    for k in range(touching.nodes.shape[0]):
        x = position(touching.reference, k, body.u, touching.nodes[k])
        total = ti.Vector.zero(ti.f64, 3)
        for p in ti.static(range(slots)):
            place = k * slots + p
            gap, normal = gap_and_normal(touching, touching.near[place], x)
            overlap = ti.max(0.0, 0.0 - gap)
            force = touching.give[k] * overlap * normal
            total += force
            sums[CONTACT.contact] += 0.5 * touching.give[k] * overlap * overlap
            press(touching, k, p, x, touching.give[k] * overlap, force)
        hand_over(body, touching, k, total, sums)
    for j in ti.static(range(CONTACT_SUMS)):
        touching.sums[FIRST.contact + j] = sums[j]


@ti.func
def impulse_load(body: ti.template(), listed: ti.template(), touching: ti.template(), span, slots: ti.template()):
    """span: time the impulse is spread over [s]; 0 where no step was or will be done."""
    sums = ti.Vector.zero(ti.f64, CONTACT_SUMS)
    time = ti.max(span, 1e-300)
    for k in range(touching.nodes.shape[0]):
        x = position(touching.reference, k, body.u, touching.nodes[k])
        flexible = symmetric(listed.inverse_mass, k)
        net = row(listed.load, k) - row(body.special_force, k)
        free = row(body.v, touching.nodes[k]) + span * (flexible @ net)
        normals = ti.Matrix.zero(ti.f64, slots, 3)
        speeds = ti.Vector.one(ti.f64, slots)
        for p in ti.static(range(slots)):
            obstacle = touching.near[k * slots + p]
            gap, direction = gap_and_normal(touching, obstacle, x)
            if gap <= 0.0 and span > 0.0:
                speeds[p] = 0.0 - direction.dot(velocity_at(touching, obstacle, x, VELOCITY))
                for j in ti.static(range(3)):
                    normals[p, j] = direction[j]
        impulses = multipliers(free, normals, speeds, flexible, 0.0, slots)
        for p in ti.static(range(slots)):
            direction = ti.Vector([normals[p, j] for j in ti.static(range(3))])
            press(touching, k, p, x, impulses[p] / time, impulses[p] / time * direction)
        hand_over(body, touching, k, normals.transpose() @ impulses / time, sums)
    for j in ti.static(range(CONTACT_SUMS)):
        touching.sums[FIRST.contact + j] = sums[j]


@ti.func
def press(touching: ti.template(), k, p: ti.template(), x, pressing, force):
    """One obstacle at one node, for whoever asks for it."""
    if ti.static(touching.kinds.friction != ""):
        touching.traces[trace_place(touching, k, p, PRESSING)] = pressing
    if ti.static(touching.kinds.tracked):
        if pressing > 0.0:
            add_load(touching, touching.near[k * touching.kinds.slots + p], x, force)
