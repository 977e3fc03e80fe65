"""Friction in the massless components of contact nodes: part of the static solve (METHOD 3).

    slip s = T (x^{n+1} - x^n - step of the obstacle),   t = -c s/|s| where s is not 0,  |t| <= c = mu lambda

The friction of a row works on the slip of the step that led to it: -(t^n + t^{n+1}).s/2, as the ledger sums forces.
"""

import taichi as ti

from .boundary_nodes import row
from .friction import held, resist, tangents
from .lanes import CONTACT_SUMS
from .massless_node import basis_of, block_of, largest, segment
from .obstacles import MEAN_VELOCITY, velocity_at

SEVERAL = 10  # rounds over the obstacles of a node that touches more than one
ROUNDS = 30  # between normal and tangential force of one contact, until they agree to
AGREED = 1e-13
STEP = 2  # place of the time step [s] in `touching.friction`


@ti.func
def moved(body: ti.template(), touching: ti.template(), k, obstacle, x):
    """Of node k against an obstacle since the last row [3] [m]; x: where it is."""
    step = row(body.u, touching.nodes[k]) - row(touching.origin, k)
    return step - touching.friction[STEP] * velocity_at(touching, obstacle, x, MEAN_VELOCITY)


@ti.func
def remember(body: ti.template(), touching: ti.template()):
    """Slip counts from here."""
    for k in range(touching.nodes.shape[0]):
        for j in ti.static(range(3)):
            touching.origin[3 * k + j] = body.u[3 * touching.nodes[k] + j]


@ti.func
def sliding_work(body: ti.template(), touching: ti.template()):
    """Adds the work of the step that led to this row; then slip counts from here."""
    slots = ti.static(touching.kinds.slots)
    work = 0.0
    for k in range(touching.nodes.shape[0]):
        x = row(touching.reference, k) + row(body.u, touching.nodes[k])
        own, strongest = 0.0, 0.0
        for p in ti.static(range(slots)):
            place = k * slots + p
            now, then = row(touching.traction, place), row(touching.before, place)
            if now.dot(now) + then.dot(then) > 0.0:
                own -= 0.5 * (now + then).dot(moved(body, touching, k, touching.near[place], x))
                strongest = ti.max(strongest, now.norm())
            for j in ti.static(range(3)):
                touching.before[3 * place + j] = now[j]
        if ti.static(touching.kinds.layered):
            touching.rubbed[2 * k], touching.rubbed[2 * k + 1] = own, strongest
        work += own
    touching.sums[CONTACT_SUMS] = touching.sums[CONTACT_SUMS] + work
    remember(body, touching)


@ti.func
def most_friction(touching: ti.template(), k, pressing):
    """The largest friction force [N] that a contact transmits."""
    most = touching.friction[0] * pressing
    if ti.static(touching.kinds.layered):
        most = ti.min(most, touching.limit[k])
    return most


@ti.func
def note_slip(body: ti.template(), touching: ti.template(), k, x, pressing, directions):
    """Slip and normals [slots, 3] for the sweeps; returns by how much friction exceeds its law [N]."""
    slots = ti.static(touching.kinds.slots)
    excess = 0.0
    for p in ti.static(range(slots)):
        place = k * slots + p
        slip = moved(body, touching, k, touching.near[place], x)
        friction = row(touching.traction, place)
        excess = ti.max(excess, friction.norm() - most_friction(touching, k, pressing[p]))
        for j in ti.static(range(3)):
            touching.slip[3 * place + j] = slip[j]
            touching.directions[3 * place + j] = directions[p, j]
    return excess


@ti.func
def update_sliding(touching: ti.template(), system: ti.template(), k, rest, block: ti.template(), slots: ti.template()):
    """The node's contact problem with friction for the given rest = r_k - sum_j K_kj d_j; returns the defect."""
    law = ti.static(touching.kinds.friction)
    old = segment(system.increment, k, block)
    flexible = block_of(system.inverse, k, block)
    b = basis_of(touching.basis, k, block)
    scale = ti.max(touching.friction[1] * touching.friction[STEP], 1e-300)
    d = flexible @ (rest + b.transpose() @ held(touching, k, slots))
    for p in ti.static(range(slots)):
        d += touching.pressing[k * slots + p] * (flexible @ segment(system.normals, k * slots + p, block))
    for _ in range(ti.static(1 if slots == 1 else SEVERAL)):
        for p in ti.static(range(slots)):
            place = k * slots + p
            normal = segment(system.normals, place, block)
            across = tangents(row(touching.directions, place))
            there = across @ b
            push = flexible @ normal
            give = normal.dot(push) + touching.give[k]
            friction = across @ row(touching.traction, place)
            pressing = touching.pressing[place]
            d -= pressing * push + flexible @ (there.transpose() @ friction)
            if give > 0.0:
                mobility = there @ flexible @ there.transpose()
                coupling = there @ push
                gap = system.gaps[place] + normal.dot(d)
                slip = across @ row(touching.slip, place) + there @ d
                for _round in range(ROUNDS):
                    before = pressing
                    pressing = ti.max(0.0, (0.0 - gap - coupling.dot(friction)) / give)
                    most = most_friction(touching, k, pressing)
                    last = friction
                    friction = resist(law, mobility, slip + pressing * coupling, most, scale)
                    if ti.abs(pressing - before) + (friction - last).norm() <= AGREED * (pressing + friction.norm()):
                        break
            else:
                pressing = 0.0
                friction = ti.Vector([0.0, 0.0])
            d += pressing * push + flexible @ (there.transpose() @ friction)
            force = across.transpose() @ friction
            touching.pressing[place] = pressing
            for j in ti.static(range(3)):
                touching.traction[3 * place + j] = force[j]
    mask = 0
    for p in ti.static(range(slots)):
        if touching.pressing[k * slots + p] > 0.0:
            mask += 1 << p
    touching.active[k] = mask
    change = d - old
    defect = system.stiffness[k] * largest(change)
    if touching.give[k] > 0.0 and mask > 0:
        defect += change.norm() / touching.give[k]
    for j in ti.static(range(block)):
        system.increment[k * block + j] = d[j]
    return defect
