"""Friction in the massless components of contact nodes: part of the static solve (METHOD 3).

    slip s = T (x^{n+1} - x^n - step of the obstacle),   t = -c s/|s| where s is not 0,  |t| <= c = mu lambda

The friction of a row works on the slip of the step that led to it: -(t^n + t^{n+1}).s/2, as the ledger sums forces.
"""

import taichi as ti

from .boundary_nodes import row
from .friction import (
    BEFORE,
    COEFFICIENT,
    DIRECTION,
    FORCE,
    LIMIT,
    ORIGIN,
    PRESSING,
    RUBBED,
    SLIP,
    SLIP_SPEED,
    STEP,
    TRACTION,
    held,
    node_place,
    put_three,
    resist,
    tangents,
    three,
    trace_place,
)
from .lanes import FRICTION_AT
from .massless_node import basis_of, entries, settle, square
from .obstacles import MEAN_VELOCITY, velocity_at

SEVERAL = 10  # rounds over the obstacles of a node that touches more than one
ROUNDS = 2  # between normal and tangential force of one contact in a sweep; the sweeps go on until nothing changes


@ti.func
def moved(body: ti.template(), touching: ti.template(), k, obstacle, x):
    """Of node k against an obstacle since the last row [3] [m]; x: where it is."""
    step = row(body.u, touching.nodes[k]) - three(touching.friction, node_place(k, ORIGIN))
    return step - touching.friction[STEP] * velocity_at(touching, obstacle, x, MEAN_VELOCITY)


@ti.func
def remember(body: ti.template(), touching: ti.template()):
    """Slip counts from here."""
    for k in range(touching.nodes.shape[0]):
        put_three(touching.friction, node_place(k, ORIGIN), row(body.u, touching.nodes[k]))


@ti.func
def sliding_work(body: ti.template(), touching: ti.template()):
    """Adds the work of the step that led to this row; then slip counts from here."""
    slots = ti.static(touching.kinds.slots)
    work = 0.0
    for k in range(touching.nodes.shape[0]):
        x = row(touching.reference, k) + row(body.u, touching.nodes[k])
        own, strongest = 0.0, 0.0
        for p in ti.static(range(slots)):
            now = three(touching.traces, trace_place(touching, k, p, TRACTION))
            then = three(touching.traces, trace_place(touching, k, p, BEFORE))
            if now.dot(now) + then.dot(then) > 0.0:
                own -= 0.5 * (now + then).dot(moved(body, touching, k, touching.near[k * slots + p], x))
                strongest = ti.max(strongest, now.norm())
            put_three(touching.traces, trace_place(touching, k, p, BEFORE), now)
        touching.friction[node_place(k, RUBBED)] = own
        touching.friction[node_place(k, FORCE)] = strongest
        work += own
    touching.sums[FRICTION_AT] = touching.sums[FRICTION_AT] + work
    remember(body, touching)


@ti.func
def most_friction(touching: ti.template(), k, pressing):
    """The largest friction force [N] that a contact transmits."""
    most = touching.friction[COEFFICIENT] * pressing
    if ti.static(touching.kinds.layered):
        most = ti.min(most, touching.friction[node_place(k, LIMIT)])
    return most


@ti.func
def note_slip(body: ti.template(), touching: ti.template(), k, x, pressing, directions):
    """Slip and normals [slots, 3] for the sweeps; returns by how much friction exceeds its law [N]."""
    excess = 0.0
    for p in ti.static(range(touching.kinds.slots)):
        slip = moved(body, touching, k, touching.near[k * touching.kinds.slots + p], x)
        friction = three(touching.traces, trace_place(touching, k, p, TRACTION))
        excess = ti.max(excess, friction.norm() - most_friction(touching, k, pressing[p]))
        put_three(touching.traces, trace_place(touching, k, p, SLIP), slip)
        for j in ti.static(range(3)):
            touching.traces[trace_place(touching, k, p, DIRECTION + j)] = directions[p, j]
    return excess


@ti.func
def update_sliding(touching: ti.template(), system: ti.template(), k, rest, block: ti.template(), slots: ti.template()):
    """The node's contact problem with friction for the given rest = r_k - sum_j K_kj d_j; returns the defect."""
    traces = ti.static(touching.traces)
    stride = system.stiffness.shape[0]
    flexible = square(system.inverse, k, stride, block)
    b = basis_of(touching.basis, k, block)
    scale = ti.max(touching.friction[SLIP_SPEED] * touching.friction[STEP], 1e-300)
    d = flexible @ (rest + b.transpose() @ held(touching, k))
    for p in ti.static(range(slots)):
        pressing = traces[trace_place(touching, k, p, PRESSING)]
        d += pressing * (flexible @ entries(system.normals, k, stride, p * block, block))
    mask = 0
    for turn in range(ti.static(1 if slots == 1 else SEVERAL)):
        mask = 0
        for p in ti.static(range(slots)):
            normal = entries(system.normals, k, stride, p * block, block)
            across = tangents(three(traces, trace_place(touching, k, p, DIRECTION)))
            there = across @ b
            push = flexible @ normal
            give = normal.dot(push) + touching.give[k]
            friction = across @ three(traces, trace_place(touching, k, p, TRACTION))
            pressing = traces[trace_place(touching, k, p, PRESSING)]
            d = d - (pressing * push + flexible @ (there.transpose() @ friction))
            if give > 0.0:
                mobility = there @ flexible @ there.transpose()
                coupling = there @ push
                gap = system.gaps[p * stride + k] + normal.dot(d)
                slip = across @ three(traces, trace_place(touching, k, p, SLIP)) + there @ d
                for _round in range(ROUNDS):
                    pressing = ti.max(0.0, (0.0 - gap - coupling.dot(friction)) / give)
                    most = most_friction(touching, k, pressing)
                    friction = resist(touching.kinds.friction, mobility, slip + pressing * coupling, most, scale)
            else:
                pressing = 0.0
                friction = ti.Vector([0.0, 0.0])
            d += pressing * push + flexible @ (there.transpose() @ friction)
            traces[trace_place(touching, k, p, PRESSING)] = pressing
            put_three(traces, trace_place(touching, k, p, TRACTION), across.transpose() @ friction)
            if pressing > 0.0:
                mask += 1 << p
    return settle(touching, system, k, d, mask, block)
