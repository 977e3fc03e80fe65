"""Friction in the massless components of contact nodes: part of the static solve (METHOD 3).

    slip s = T (x^{n+1} - x^n - step of the obstacle),   t = -c s/|s| where s is not 0,  |t| <= c = mu lambda

The friction of a row works on the slip of the step that led to it: -(t^n + t^{n+1}).s/2, as the ledger sums forces.
"""

import taichi as ti

from .boundary_nodes import row
from .constraint_rows import normal_of, number_of, set_number, set_vector, sum_of_rows, vector_of, velocity_of
from .friction import (
    FORCE,
    LIMIT,
    ORIGIN,
    RUBBED,
    SLIP_SPEED,
    STEP,
    node_place,
    put_three,
    resist,
    tangents,
    three,
)
from .islands import first_node, island_count, node_count, sums_of
from .lanes import FRICTION_AT
from .local_contact import multipliers
from .massless_node import basis_of, entries, largest, settle, square, violated

SEVERAL = 10  # rounds over the obstacles of a node that may touch more than one, until its move agrees to
AGREED = 1e-14  # of itself
ROUNDS = 2  # between normal and tangential force of one contact in a sweep; the sweeps go on until nothing changes
SEARCH = 100  # most trials of a pressing force where these rounds would not converge, until the gap is closed to
CLOSED = 1e-12  # of what it would be without the contact


@ti.func
def moved(body: ti.template(), touching: ti.template(), rows: ti.template(), k, r):
    """Of node k against the partner of its row r since the last row [3] [m]."""
    step = row(body.u, touching.nodes[k]) - three(touching.friction, node_place(k, ORIGIN))
    return step - touching.friction[STEP] * velocity_of(rows, r, rows.at.mean_velocity)


@ti.func
def remember(body: ti.template(), touching: ti.template()):
    """Slip counts from here."""
    for k in range(node_count(touching)):
        put_three(touching.friction, node_place(k, ORIGIN), row(body.u, touching.nodes[k]))


@ti.func
def sliding_work(body: ti.template(), touching: ti.template(), rows: ti.template()):
    """Adds the work of the step that led to this row; then slip counts from here."""
    for island in range(island_count(touching)):
        work = 0.0
        for k in range(first_node(touching, island), first_node(touching, island + 1)):
            work += sliding_work_node(body, touching, rows, k)
        at = sums_of(touching, island) + FRICTION_AT
        touching.sums[at] = touching.sums[at] + work
    remember(body, touching)


@ti.func
def sliding_work_node(body: ti.template(), touching: ti.template(), rows: ti.template(), k):
    """Work of the friction of node k."""
    slots = ti.static(touching.kinds.slots)
    own, strongest = 0.0, 0.0
    for p in ti.static(range(slots)):
        now = vector_of(rows, k * slots + p, rows.at.traction)
        then = vector_of(rows, k * slots + p, rows.at.traction_before)
        if now.dot(now) + then.dot(then) > 0.0:
            own -= 0.5 * (now + then).dot(moved(body, touching, rows, k, k * slots + p))
            strongest = ti.max(strongest, now.norm())
        set_vector(rows, k * slots + p, rows.at.traction_before, now)
    touching.friction[node_place(k, RUBBED)] = own
    touching.friction[node_place(k, FORCE)] = strongest
    return own


@ti.func
def most_friction(touching: ti.template(), rows: ti.template(), k, r, pressing):
    """The largest friction force [N] that row r of node k transmits."""
    most = number_of(rows, r, rows.at.coefficient) * pressing
    if ti.static(touching.kinds.layered):
        most = ti.min(most, touching.friction[node_place(k, LIMIT)])
    return most


@ti.func
def note_slip(body: ti.template(), touching: ti.template(), rows: ti.template(), k, pressing):
    """Slip of the rows of node k for the sweeps; returns by how much friction exceeds its law [N]."""
    slots = ti.static(touching.kinds.slots)
    excess = 0.0
    for p in ti.static(range(slots)):
        r = k * slots + p
        friction = vector_of(rows, k * slots + p, rows.at.traction)
        excess = ti.max(excess, friction.norm() - most_friction(touching, rows, k, r, pressing[p]))
        set_vector(rows, k * slots + p, rows.at.slip, moved(body, touching, rows, k, r))
    return excess


@ti.func
def hold_one(
    touching: ti.template(), rows: ti.template(), system: ti.template(), k, d, flexible, b, scale, block: ti.template()
):
    """Increment, mask of what presses and violated gap [m] of a node at a single obstacle; d: under its old forces.

    Normal and tangential force answer each other, which converges where mu |coupling| < give. Beyond that the pressing
    force is searched for between one that leaves an overlap and one that opens the contact.
    """
    normal = entries(system.normals, k, system.stiffness.shape[0], 0, block)
    across = tangents(normal_of(rows, k))
    there = across @ b
    push = flexible @ normal
    give = normal.dot(push) + touching.give[k]
    friction = across @ vector_of(rows, k, rows.at.traction)
    pressing = number_of(rows, k, rows.at.pressing)
    d = d - (pressing * push + flexible @ (there.transpose() @ friction))
    off = 0.0
    if give > 0.0:
        mobility = there @ flexible @ there.transpose()
        coupling = there @ push
        gap = system.gaps[k] + normal.dot(d)
        slip = across @ vector_of(rows, k, rows.at.slip) + there @ d
        steep = gap < 0.0 and number_of(rows, k, rows.at.coefficient) * coupling.norm() >= give
        low, high = 0.0, 0.0
        for turn in range(ti.select(steep, SEARCH, ROUNDS)):
            if turn < ROUNDS:
                pressing = ti.max(0.0, (0.0 - gap - coupling.dot(friction)) / give)
            elif high > 0.0:
                pressing = 0.5 * (low + high)
            else:
                pressing = 2.0 * ti.max(pressing, (0.0 - gap) / give)
            most = most_friction(touching, rows, k, k, pressing)
            friction = resist(touching.kinds.friction, mobility, slip + pressing * coupling, most, scale)
            after = gap + coupling.dot(friction) + give * pressing
            off = violated(after, pressing)
            if turn >= ROUNDS - 1 and off <= CLOSED * ti.abs(gap):
                break
            if after < 0.0:
                low = pressing
            else:
                high = pressing
    else:
        pressing = 0.0
        friction = ti.Vector([0.0, 0.0])
    d += pressing * push + flexible @ (there.transpose() @ friction)
    set_number(rows, k, rows.at.pressing, pressing)
    set_vector(rows, k, rows.at.traction, across.transpose() @ friction)
    return d, ti.select(pressing > 0.0, 1, 0), off


@ti.func
def hold_several(
    touching: ti.template(),
    rows: ti.template(),
    system: ti.template(),
    k,
    d,
    flexible,
    b,
    scale,
    block: ti.template(),
    slots: ti.template(),
):
    """Increment, mask of what presses and violated gap [m] of a node among several obstacles; d: under its old forces.

    In turns: the pressing forces of all of them at once, so that dependent normals share them as they do in
    `balance`; then the friction of one after another.
    """
    stride = system.stiffness.shape[0]
    normals = ti.Matrix(
        [
            [system.normals[(p * block + j) * stride + k] for j in ti.static(range(block))]
            for p in ti.static(range(slots))
        ]
    )
    gaps = entries(system.gaps, k, stride, 0, slots)
    pressing = ti.Vector([number_of(rows, k * slots + p, rows.at.pressing) for p in ti.static(range(slots))])
    for _ in range(SEVERAL):
        before = d
        d = d - flexible @ (normals.transpose() @ pressing)
        pressing = multipliers(d, normals, gaps, flexible, touching.give[k], slots)
        d += flexible @ (normals.transpose() @ pressing)
        for p in ti.static(range(slots)):
            across = tangents(normal_of(rows, k * slots + p))
            there = across @ b
            friction = across @ vector_of(rows, k * slots + p, rows.at.traction)
            d = d - flexible @ (there.transpose() @ friction)
            slip = across @ vector_of(rows, k * slots + p, rows.at.slip) + there @ d
            mobility = there @ flexible @ there.transpose()
            most = most_friction(touching, rows, k, k * slots + p, pressing[p])
            friction = resist(touching.kinds.friction, mobility, slip, most, scale)
            d += flexible @ (there.transpose() @ friction)
            set_vector(rows, k * slots + p, rows.at.traction, across.transpose() @ friction)
        if largest(d - before) <= AGREED * largest(d):
            break
    mask, off = 0, 0.0
    after = gaps + normals @ d + touching.give[k] * pressing
    for p in ti.static(range(slots)):
        set_number(rows, k * slots + p, rows.at.pressing, pressing[p])
        off = ti.max(off, violated(after[p], pressing[p]))
        if pressing[p] > 0.0:
            mask += 1 << p
    return d, mask, off


@ti.func
def update_sliding(
    touching: ti.template(),
    rows: ti.template(),
    system: ti.template(),
    k,
    rest,
    block: ti.template(),
    slots: ti.template(),
):
    """The node's contact problem with friction for the given rest = r_k - sum_j K_kj d_j; returns the defect."""
    stride = system.stiffness.shape[0]
    flexible = square(system.inverse, k, stride, block)
    b = basis_of(touching.basis, k, block)
    scale = ti.max(touching.friction[SLIP_SPEED] * touching.friction[STEP], 1e-300)
    d = flexible @ (rest + b.transpose() @ sum_of_rows(rows, k, rows.at.traction))
    for p in ti.static(range(slots)):
        pressing = number_of(rows, k * slots + p, rows.at.pressing)
        d += pressing * (flexible @ entries(system.normals, k, stride, p * block, block))
    mask, off = 0, 0.0
    if ti.static(slots == 1):
        d, mask, off = hold_one(touching, rows, system, k, d, flexible, b, scale, block)
    else:
        d, mask, off = hold_several(touching, rows, system, k, d, flexible, b, scale, block, slots)
    stiffness = ti.select(touching.give[k] > 0.0, 1.0 / ti.max(touching.give[k], 1e-300), system.stiffness[k])
    return ti.max(settle(touching, system, k, d, mask, block), stiffness * off)
