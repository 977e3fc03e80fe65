"""Frequency of free obstacles on the contact cells that they press, for the stable step (METHOD 2).

    w^2 <= largest row sum of M^-1/2 (sum_i k_i G_i^t G_i) M^-1/2,   k_i = sum_j |K_ij n_i|

M: mass and inertia of the obstacle, G_i: motion of its point at contact node i along the normal n_i (with friction in
the static solve along all axes, and k_i = sum_j |K_ij|). K: assembled stiffness of the static solve, in which
2 |d_i.K_ij d_j| <= |K_ij| (|d_i|^2 + |d_j|^2); the other nodes are held, as the estimate of the free body has their
share. With a penalty on nodes with mass k_i is its stiffness. A node counts before it touches, once it could touch
within `reach` seconds: the step must be short before the first kick.
"""

from ..columns import RIGID
from ..contact.constraint_rows import normal_of, number_of, vector_of
from ..contact.islands import node_count
from ..contact.obstacle_rows import position
from ..contact.obstacles import MEAN_VELOCITY, POINT, RECORD, velocity_at
from ..engine import ti
from ..language.entries import row, three
from ..nodes.rigid_record import kind_of, record_of, turn_of
from ..nodes.rotations import matrix_of
from ..rigid_places import (
    AXES,
    BOUND,
    DIRECTION,
    FIRST_STEP,
    FREE,
    INVERSE_MASS,
    INVERSE_MOMENTS,
    REACH,
    SUMS_AT,
)
from ..static.massless_node import basis_of, segment
from ..static.solve import summed


@ti.func
def measure_rigid_rate(
    rigid: ti.template(), obstacles: ti.template(), rows: ti.template(), contact: ti.template(), pairs: ti.template(),
    body: ti.template(), before,
):  # fmt: skip
    """Set the rate of the row: the bound of w^2 [1/s^2], the largest of all free obstacles.

    before [s]: the step that ended here, 0 at the start.
    """
    slots, own = ti.static(rows.options.slots, rows.options.obstacle_slots)
    count = obstacles.records.shape[0] // RECORD
    for p in range(count):
        for j in range(36):
            rigid.values[record_of(p) + BOUND + j] = 0.0
    for k in range(node_count(contact)):
        for r in range(k * slots, k * slots + own):
            p = obstacles.candidates[r]
            if kind_of(rigid, p) == FREE:
                if may_press(rigid, obstacles, rows, contact, body, before, k, r, p):
                    add_node(rigid, obstacles, rows, contact, pairs, body, k, r, p)
    largest = 0.0
    for p in range(count):
        for i in range(6):
            total = 0.0
            for j in range(6):
                total += ti.abs(rigid.values[record_of(p) + BOUND + 6 * i + j])
            largest = ti.max(largest, total)
    rigid.sums[int(rigid.values[SUMS_AT]) + RIGID.rigid_rate] = largest


@ti.func
def may_press(
    rigid: ti.template(), obstacles: ti.template(), rows: ti.template(), contact: ti.template(), body: ti.template(),
    before, k, r, p,
):  # fmt: skip
    """Return whether row r of node k is pressed, or may be within `reach` seconds at its present speed."""
    node = contact.nodes[k]
    velocity = row(body.v, node)
    if ti.static(contact.options.model == "massless"):
        block = ti.static(contact.options.block)
        basis = basis_of(contact.basis, k, block)
        moved = basis.transpose() @ row(body.u, node) - segment(contact.displacement_before, k, block)
        step = ti.select(before > 0.0, before, rigid.values[FIRST_STEP])
        velocity += basis @ moved / step
    x = position(contact.reference, k, body.u, node)
    normal = normal_of(rows, r)
    closing = normal.dot(velocity_at(obstacles, p, x, MEAN_VELOCITY) - velocity)
    pressed = vector_of(rows, r, rows.at.force).norm() > 0.0
    return pressed or number_of(rows, r, rows.at.gap) <= rigid.values[REACH] * ti.max(0.0, closing)


@ti.func
def add_node(
    rigid: ti.template(), obstacles: ti.template(), rows: ti.template(), contact: ti.template(), pairs: ti.template(),
    body: ti.template(), k, r, p,
):  # fmt: skip
    """Add row r of node k to the bound of free obstacle p."""
    arm = arm_of(obstacles, contact, body, k, p)
    if ti.static(contact.options.static_friction):
        stiffness = stiffness_of_all(contact, pairs, body, k)
        for j in ti.static(range(3)):
            axis = ti.Vector([1.0 if i == j else 0.0 for i in ti.static(range(3))])
            add_direction(rigid, p, arm, axis, stiffness)
    else:
        normal, stiffness = normal_stiffness(rows, contact, pairs, body, k, r)
        add_direction(rigid, p, arm, normal, stiffness)


@ti.func
def arm_of(obstacles: ti.template(), contact: ti.template(), body: ti.template(), k, p):
    """Return the arm [3] from the point of obstacle p to contact node k."""
    x = position(contact.reference, k, body.u, contact.nodes[k])
    return x - three(obstacles.records, RECORD * p + POINT)


@ti.func
def stiffness_of_all(contact: ti.template(), pairs: ti.template(), body: ti.template(), k):
    """Return sum_j |K_kj| of node k."""
    stiffness = 0.0
    for e in range(pairs.row_start[k], pairs.row_start[k + 1]):
        stiffness += summed(body, pairs, e, contact.options.block).norm()
    return stiffness


@ti.func
def normal_stiffness(rows: ti.template(), contact: ti.template(), pairs: ti.template(), body: ti.template(), k, r):
    """Return the normal [3] of row r of node k and sum_j |K_kj n|, or the stiffness of its penalty."""
    normal = normal_of(rows, r)
    stiffness = 0.0
    if ti.static(contact.options.model == "massless"):
        own = basis_of(contact.basis, k, contact.options.block).transpose() @ normal
        for e in range(pairs.row_start[k], pairs.row_start[k + 1]):
            stiffness += (summed(body, pairs, e, contact.options.block).transpose() @ own).norm()
        if ti.static(contact.options.viscous):
            stiffness = 2.0 * stiffness  # dt^2 K + 2 dt C instead of dt^2 K + dt C, which K holds
    else:
        stiffness = contact.penalty_stiffness[k]
    return normal, stiffness


@ti.func
def mobility_of(rigid: ti.template(), p, arm, direction):
    """Return g = M^-1/2 (n, r x n) of obstacle p, in its principal axes, as two vectors [3]."""
    at = record_of(p)
    axes = ti.Matrix([[rigid.values[at + AXES + 3 * i + j] for j in range(3)] for i in range(3)])
    now = axes @ matrix_of(turn_of(rigid, at)).transpose()
    moving, turning = now @ direction, now @ arm.cross(direction)
    for j in ti.static(range(3)):
        moving[j] = ti.sqrt(rigid.values[at + INVERSE_MASS]) * moving[j]
        turning[j] = ti.sqrt(rigid.values[at + INVERSE_MOMENTS + j]) * turning[j]
    return moving, turning


@ti.func
def add_direction(rigid: ti.template(), p, arm, direction, stiffness):
    """Add k g g^t with g = M^-1/2 (n, r x n), in the principal axes of the body."""
    at = record_of(p)
    moving, turning = mobility_of(rigid, p, arm, direction)
    for j in ti.static(range(3)):
        rigid.values[at + DIRECTION + j], rigid.values[at + DIRECTION + 3 + j] = moving[j], turning[j]
    for i in range(6):
        for j in range(6):
            product = stiffness * rigid.values[at + DIRECTION + i] * rigid.values[at + DIRECTION + j]
            rigid.values[at + BOUND + 6 * i + j] = rigid.values[at + BOUND + 6 * i + j] + product
