"""Massless contact nodes around the static solve: their prediction, and lambda from the ordinary force pass (METHOD 2).

x_K^{n+1} ~ x_K^n + (x_K^n - x_K^{n-1}) + g dt^2,   moved out of the obstacle
lambda_k = max(0, nu . (f_k(x^n) - f_ext,k))   where the constraint is active

The residual of a row is the largest force that is unbalanced or outside its friction cone, or that would undo an
overlap, over F_ref. What the static solve left unbalanced acts, like their loads, on the nodes that carry the mass of
the contact nodes: momentum is exact at any residual.
"""

import taichi as ti

from .boundary_nodes import hand_over, row
from .columns import CONTACT, CONTACT_SUMS, FIRST
from .friction import PRESSING, TRACTION, held, three, trace_place
from .local_contact import multipliers
from .massless_node import balance, basis_of, constraints, largest, off_the_obstacles, segment
from .obstacles import add_load, gap_and_normal, position
from .static_control import F_REF
from .static_friction import most_friction


@ti.func
def predict(
    body: ti.template(), touching: ti.template(), ratio, fall, exact, block: ti.template(), slots: ti.template()
):
    """x_K = x_K^n + (x_K^n - x_K^{n-1}) ratio + fall in the massless components; `exact`: moved out of the obstacle.

    fall = g dt^2 makes the prediction exact in free flight; last becomes the displacement before the prediction.
    """
    for k in range(touching.nodes.shape[0]):
        node = touching.nodes[k]
        b = basis_of(touching.basis, k, block)
        now = b.transpose() @ row(body.u, node)
        step = ratio * (now - segment(touching.last, k, block)) + b.transpose() @ fall
        if exact == 1.0:
            x = position(touching.reference, k, body.u, node) + b @ step
            normals, gaps = constraints(touching, k, b, x, block, slots)
            if gaps.min() < 0.0:
                free = ti.Vector.zero(ti.f64, block)
                identity = ti.Matrix.identity(ti.f64, block)
                step += normals.transpose() @ multipliers(free, normals, gaps, identity, 0.0, slots)
        move = b @ step
        for j in ti.static(range(block)):
            touching.last[k * block + j] = now[j]
        for j in ti.static(range(3)):
            body.u[3 * node + j] = body.u[3 * node + j] + move[j]


@ti.func
def massless_load(
    body: ti.template(),
    listed: ti.template(),
    touching: ti.template(),
    system: ti.template(),
    block: ti.template(),
    slots: ti.template(),
):
    """lambda of every contact node from the force of the ordinary pass; the contact force leaves special_force."""
    sums = ti.Vector.zero(ti.f64, CONTACT_SUMS)
    for k in range(touching.nodes.shape[0]):
        b = basis_of(touching.basis, k, block)
        x = position(touching.reference, k, body.u, touching.nodes[k])
        normals, gaps = constraints(touching, k, b, x, block, slots)
        out_of_balance = b.transpose() @ (row(body.special_force, k) - row(listed.load, k))
        if ti.static(touching.kinds.static_friction):
            out_of_balance = out_of_balance - b.transpose() @ held(touching, k)
        pressing, rest = balance(out_of_balance, normals, touching.active[k], block, slots)
        off = system.stiffness[k] * off_the_obstacles(touching, k, x, gaps, pressing, slots)
        total = ti.Vector.zero(ti.f64, 3)
        for p in ti.static(range(slots)):
            place = k * slots + p
            if pressing[p] > 0.0:
                _gap, normal = gap_and_normal(touching, touching.near[place], x)
                force = pressing[p] * normal
                if ti.static(touching.kinds.static_friction):
                    friction = three(touching.traces, trace_place(touching, k, p, TRACTION))
                    off = ti.max(off, friction.norm() - most_friction(touching, k, pressing[p]))
                    force += friction
                if ti.static(touching.kinds.tracked):
                    add_load(touching, touching.near[place], x, force)
                total += force
                sums[CONTACT.contact] += 0.5 * touching.give[k] * pressing[p] * pressing[p]
            elif ti.static(touching.kinds.static_friction):
                rest += b.transpose() @ three(touching.traces, trace_place(touching, k, p, TRACTION))
            if ti.static(touching.kinds.friction != ""):
                touching.traces[trace_place(touching, k, p, PRESSING)] = pressing[p]
        hand_over(body, touching, k, total, sums)
        begin, end = touching.heirs[k], touching.heirs[k + 1]
        share = (b @ rest) / ti.max(1.0, float(end - begin))
        for i in range(begin, end):
            for j in ti.static(range(3)):
                place = 3 * touching.heirs[i] + j
                body.special_force[place] = body.special_force[place] + share[j]
        sums[CONTACT.static_residual] = ti.max(sums[CONTACT.static_residual], largest(rest), off)
    sums[CONTACT.static_residual] /= ti.max(system.stats[F_REF], 1e-300)
    for j in ti.static(range(CONTACT_SUMS)):
        touching.sums[FIRST.contact + j] = sums[j]
