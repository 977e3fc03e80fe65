"""Friction on the components of contact nodes that have mass, as an impulse of the kick (METHOD 3).

    v = v* + M^-1 p,   p = -M v*_T if that is at most mu lambda span, else scaled back to it

v*: velocity relative to the partner that the kick over `span` would give without friction. Exact stick, no creep.
The work up to row n takes the part of the kick before it:  -t.(v^{n-1/2} + v^n)/2 k0,  the rest comes after.
"""

import taichi as ti

from ..columns import SUMS
from ..lanes import KICK_AFTER, KICK_BEFORE
from ..nodes.boundary_nodes import row, symmetric
from ..nodes.damping import damped_response
from .constraint_rows import normal_of, number_of, set_vector, vector_of, velocity_of
from .friction import (
    FORCE,
    LIMIT,
    MEAN_SPEED,
    SLIP_SPEED,
    SOFTNESS,
    SPEED,
    WORK,
    friction_force,
    node_place,
    tangents,
)
from .islands import node_count

SEVERAL = 300  # rounds over the rows of a node that has more than one, until their forces agree to
AGREED = 1e-13  # of what presses; sticking to two at a small angle takes a hundred


@ti.func
def velocity_without_friction(body: ti.template(), boundary: ti.template(), k, damped: ti.template()):
    """Return velocity before the kick, acceleration without friction, and the inverse mass [3, 3] for a force."""
    node = boundary.nodes[k]
    velocity = row(body.v, node)
    flexible = symmetric(boundary.inverse_mass, k)
    net = row(boundary.load, k) - row(body.special_force, k)
    net, flexible = damped_response(damped, body, symmetric(boundary.mass, k), velocity, net, flexible)
    return velocity, flexible @ net, flexible


@ti.func
def without_massless_components(contact: ti.template(), k, relative):
    """Take the massless components of node k out of a velocity [3]: their friction is in the static solve."""
    for j in ti.static(range(contact.options.block)):
        column = ti.Vector([contact.basis[(3 * k + i) * contact.options.block + j] for i in ti.static(range(3))])
        relative = relative - column.dot(relative) * column
    return relative


@ti.func
def kick_friction(
    body: ti.template(), boundary: ti.template(), contact: ti.template(), rows: ti.template(), damped: ti.template()
):
    """Set the friction of all rows, and sum up its work."""
    early, late = 0.0, 0.0
    for k in range(node_count(contact)):
        before, after = kick_friction_node(body, boundary, contact, rows, damped, k)
        early += before
        late += after
    contact.sums[SUMS.friction_before] = contact.sums[SUMS.friction_before] + early
    contact.sums[SUMS.friction_after] = late


@ti.func
def kick_friction_node(
    body: ti.template(), boundary: ti.template(), contact: ti.template(), rows: ti.template(), damped: ti.template(), k
):
    """Set the friction of the rows of node k; returns its work [J] before and after the time level of the kick."""
    slots = ti.static(contact.options.slots)
    before, after = body.params[KICK_BEFORE], body.params[KICK_AFTER]
    span = before + after
    work_before, work_after = 0.0, 0.0
    pressed = 0.0
    for p in ti.static(range(slots)):
        pressed += number_of(rows, k * slots + p, rows.at.pressing)
    if ti.static(contact.options.layered and not contact.options.static_friction):
        contact.friction[node_place(k, WORK)] = 0.0
        contact.friction[node_place(k, FORCE)] = 0.0
    forces = ti.Matrix.zero(ti.f64, slots, 3)
    if pressed > 0.0 and span > 0.0:
        velocity, acceleration, flexible = velocity_without_friction(body, boundary, k, damped)
        for _ in range(ti.static(1 if slots == 1 else SEVERAL)):
            change = 0.0
            for p in ti.static(range(slots)):
                r = k * slots + p
                pressing = number_of(rows, k * slots + p, rows.at.pressing)
                if pressing > 0.0:
                    others = ti.Vector.zero(ti.f64, 3)
                    for q in ti.static(range(slots)):
                        if q != p:
                            others += ti.Vector([forces[q, j] for j in ti.static(range(3))])
                    across = tangents(normal_of(rows, r))
                    wall = velocity_of(rows, r, rows.at.velocity)
                    relative = velocity + span * (acceleration + flexible @ others) - wall
                    if ti.static(contact.options.static_friction):
                        relative = without_massless_components(contact, k, relative)
                    slip = across @ relative
                    most = number_of(rows, r, rows.at.coefficient) * pressing
                    if ti.static(contact.options.static_friction):
                        there = vector_of(rows, k * slots + p, rows.at.traction)
                        most = ti.sqrt(ti.max(0.0, most * most - there.dot(there)))
                    if ti.static(contact.options.layered):
                        most = ti.min(most, contact.friction[node_place(k, LIMIT)])
                    mobility = span * (across @ flexible @ across.transpose())
                    if mobility[0, 0] + mobility[1, 1] <= 0.0:
                        most = 0.0  # no mass: its friction is that of the static solve
                    force = across.transpose() @ friction_force(
                        contact.options.friction, mobility, slip, most, contact.friction[SLIP_SPEED]
                    )
                    for j in ti.static(range(3)):
                        change += ti.abs(force[j] - forces[p, j])
                        forces[p, j] = force[j]
            if change <= AGREED * pressed:
                break
        total = ti.Vector.zero(ti.f64, 3)
        for p in ti.static(range(slots)):
            total += ti.Vector([forces[p, j] for j in ti.static(range(3))])
        acceleration += flexible @ total
        for p in ti.static(range(slots)):
            force = ti.Vector([forces[p, j] for j in ti.static(range(3))])
            first = velocity - velocity_of(rows, k * slots + p, rows.at.velocity)
            middle = first + before * acceleration
            last = first + span * acceleration
            early = 0.0 - 0.5 * before * force.dot(first + middle)
            late = 0.0 - 0.5 * after * force.dot(middle + last)
            work_before += early
            work_after += late
            if ti.static(contact.options.layered and not contact.options.static_friction):
                rubbed, strongest = node_place(k, WORK), node_place(k, FORCE)
                contact.friction[rubbed] = contact.friction[rubbed] + early + late
                contact.friction[strongest] = ti.max(contact.friction[strongest], force.norm())
    for p in ti.static(range(slots)):
        set_vector(rows, k * slots + p, rows.at.kick_friction, ti.Vector([forces[p, j] for j in ti.static(range(3))]))
    return work_before, work_after


@ti.func
def layer_slip(
    body: ti.template(), boundary: ti.template(), contact: ti.template(), rows: ti.template(), damped: ti.template()
):
    """Tell the layer of every node its slip speed without friction, and what a force takes away from it."""
    for k in range(node_count(contact)):
        layer_slip_node(body, boundary, contact, rows, damped, k)


@ti.func
def layer_slip_node(
    body: ti.template(), boundary: ti.template(), contact: ti.template(), rows: ti.template(), damped: ti.template(), k
):
    """Set slip speed and mobility of node k at the row that presses it most."""
    slots = ti.static(contact.options.slots)
    span = body.params[KICK_BEFORE] + body.params[KICK_AFTER]
    most, speed, mobility, mean = 0.0, 0.0, 0.0, 0.0
    for p in ti.static(range(slots)):
        r = k * slots + p
        pressing = number_of(rows, k * slots + p, rows.at.pressing)
        if pressing > most:
            most = pressing
            across = tangents(normal_of(rows, r))
            velocity, acceleration, flexible = velocity_without_friction(body, boundary, k, damped)
            wall = velocity_of(rows, r, rows.at.velocity)
            slip = across @ (velocity + span * acceleration - wall)
            speed = slip.norm()
            if speed > 0.0:
                mean = 0.5 * slip.dot(slip + across @ (velocity - wall)) / speed
                mobility = slip.dot(span * (across @ flexible @ across.transpose()) @ slip) / (speed * speed)
    contact.friction[node_place(k, SPEED)] = speed
    contact.friction[node_place(k, SOFTNESS)] = mobility
    contact.friction[node_place(k, MEAN_SPEED)] = mean
