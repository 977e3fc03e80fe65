"""The rate of `rigid_rate.measure_rigid_rate` where the threads of a block share the contact nodes.

For every obstacle that moves freely the threads add up one row of its matrix after the other over their nodes, and
combine it; the first thread keeps the largest row sum.
"""

from ..columns import RIGID
from ..contact.islands import node_count
from ..engine import ti
from ..language.threads import item, leader, meet, over_threads, turns
from ..nodes.rigid_record import kind_of
from ..rigid_places import FREE, SUMS_AT
from .rigid_rate import arm_of, may_press, mobility_of, normal_stiffness, stiffness_of_all


@ti.func
def measure_shared_rigid_rate(
    rigid: ti.template(), obstacles: ti.template(), rows: ti.template(), contact: ti.template(), pairs: ti.template(),
    body: ti.template(), before, count,
):  # fmt: skip
    """Set the rate of the row as `measure_rigid_rate`; count: of the obstacles."""
    largest = 0.0
    for p in range(count):
        if kind_of(rigid, p) == FREE:
            for i in range(6):
                own = ti.Vector.zero(ti.f64, 6)
                for turn in range(turns(contact, node_count(contact))):
                    k = item(contact, turn)
                    for slot in range(ti.static(rows.options.obstacle_slots)):
                        r = k * ti.static(rows.options.slots) + slot
                        if obstacles.candidates[r] == p:
                            if may_press(rigid, obstacles, rows, contact, body, before, k, r, p):
                                own += row_of_node(rigid, obstacles, rows, contact, pairs, body, k, r, p, i)
                sums = over_threads(contact, [own[j] for j in range(6)], ("sum",) * 6)
                total = 0.0
                for j in ti.static(range(6)):
                    total += ti.abs(sums[j])
                largest = ti.max(largest, total)
    if leader(contact) == 1:
        rigid.sums[int(rigid.values[SUMS_AT]) + RIGID.rigid_rate] = largest
    meet(contact)


@ti.func
def row_of_node(
    rigid: ti.template(), obstacles: ti.template(), rows: ti.template(), contact: ti.template(), pairs: ti.template(),
    body: ti.template(), k, r, p, i,
):  # fmt: skip
    """Return what row r of node k adds to row i [6] of the matrix of free obstacle p."""
    arm = arm_of(obstacles, contact, body, k, p)
    result = ti.Vector.zero(ti.f64, 6)
    if ti.static(contact.options.static_friction):
        stiffness = stiffness_of_all(contact, pairs, body, k)
        for axis in range(3):
            direction = ti.Vector([ti.select(axis == j, 1.0, 0.0) for j in range(3)])
            result += product_row(rigid, p, arm, direction, stiffness, i)
    else:
        normal, stiffness = normal_stiffness(rows, contact, pairs, body, k, r)
        result += product_row(rigid, p, arm, normal, stiffness, i)
    return result


@ti.func
def product_row(rigid: ti.template(), p, arm, direction, stiffness, i):
    """Return row i [6] of k g g^t."""
    moving, turning = mobility_of(rigid, p, arm, direction)
    g = [moving[0], moving[1], moving[2], turning[0], turning[1], turning[2]]
    own = 0.0
    for j in ti.static(range(6)):
        own = ti.select(i == j, g[j], own)
    return ti.Vector([stiffness * own * g[j] for j in range(6)])
