"""Friction on the components of contact nodes that have mass, as an impulse of the kick (METHOD 3).

    v = v* + M^-1 p,   p = -M v*_T if that is at most mu lambda span, else scaled back to it

v*: velocity relative to the obstacle that the kick over `span` would give without friction. Exact stick, no creep.
The work up to row n takes the part of the kick before it:  -t.(v^{n-1/2} + v^n)/2 k0,  the rest comes after.
"""

import taichi as ti

from .boundary_nodes import row, symmetric
from .columns import SUMS
from .damping import damped_response
from .friction import (
    COEFFICIENT,
    FORCE,
    LIMIT,
    MEAN_SPEED,
    PRESSING,
    RUBBED,
    SLIP_SPEED,
    SOFTNESS,
    SPEED,
    TRACTION,
    node_place,
    resist,
    tangents,
    three,
    trace_place,
)
from .obstacles import VELOCITY, add_load, gap_and_normal, position, velocity_at

SEVERAL = 300  # rounds over the obstacles of a node that touches more than one, until their forces agree to
AGREED = 1e-13  # of what presses; sticking to two at a small angle takes a hundred


@ti.func
def trial(body: ti.template(), listed: ti.template(), k, damped: ti.template()):
    """Velocity before the kick, acceleration by all forces but friction, and what a force adds to it [3, 3]."""
    node = listed.nodes[k]
    velocity = row(body.v, node)
    flexible = symmetric(listed.inverse_mass, k)
    net = row(listed.load, k) - row(body.special_force, k)
    net, flexible = damped_response(damped, body, symmetric(listed.mass, k), velocity, net, flexible)
    return velocity, flexible @ net, flexible


@ti.func
def with_mass(touching: ti.template(), k, relative):
    """What a velocity [3] is without the massless components of node k: their friction is in the static solve."""
    for j in ti.static(range(touching.kinds.block)):
        column = ti.Vector([touching.basis[(3 * k + i) * touching.kinds.block + j] for i in ti.static(range(3))])
        relative = relative - column.dot(relative) * column
    return relative


@ti.func
def kick_friction(body: ti.template(), listed: ti.template(), touching: ti.template(), damped: ti.template()):
    """Friction of all contact nodes leaves special_force and joins the contact force; its work joins the sums."""
    slots = ti.static(touching.kinds.slots)
    before, after = body.params[0], body.params[1]
    span = before + after
    work_before, work_after = 0.0, 0.0
    for k in range(touching.nodes.shape[0]):
        pressed = 0.0
        for p in ti.static(range(slots)):
            pressed += touching.traces[trace_place(touching, k, p, PRESSING)]
        if ti.static(touching.kinds.layered):
            if ti.static(not touching.kinds.static_friction):
                touching.friction[node_place(k, RUBBED)] = 0.0
                touching.friction[node_place(k, FORCE)] = 0.0
        if pressed > 0.0 and span > 0.0:
            x = position(touching.reference, k, body.u, touching.nodes[k])
            velocity, acceleration, flexible = trial(body, listed, k, damped)
            forces = ti.Matrix.zero(ti.f64, slots, 3)
            for _ in range(ti.static(1 if slots == 1 else SEVERAL)):
                change = 0.0
                for p in ti.static(range(slots)):
                    place = k * slots + p
                    pressing = touching.traces[trace_place(touching, k, p, PRESSING)]
                    if pressing > 0.0:
                        others = ti.Vector.zero(ti.f64, 3)
                        for q in ti.static(range(slots)):
                            if q != p:
                                others += ti.Vector([forces[q, j] for j in ti.static(range(3))])
                        _gap, normal = gap_and_normal(touching, touching.near[place], x)
                        across = tangents(normal)
                        wall = velocity_at(touching, touching.near[place], x, VELOCITY)
                        relative = velocity + span * (acceleration + flexible @ others) - wall
                        if ti.static(touching.kinds.static_friction):
                            relative = with_mass(touching, k, relative)
                        slip = across @ relative
                        most = touching.friction[COEFFICIENT] * pressing
                        if ti.static(touching.kinds.static_friction):
                            there = three(touching.traces, trace_place(touching, k, p, TRACTION))
                            most = ti.sqrt(ti.max(0.0, most * most - there.dot(there)))
                        if ti.static(touching.kinds.layered):
                            most = ti.min(most, touching.friction[node_place(k, LIMIT)])
                        mobility = span * (across @ flexible @ across.transpose())
                        if mobility[0, 0] + mobility[1, 1] <= 0.0:
                            most = 0.0  # no mass: its friction is that of the static solve
                        force = across.transpose() @ resist(
                            touching.kinds.friction, mobility, slip, most, touching.friction[SLIP_SPEED]
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
                obstacle = touching.near[k * slots + p]
                first = velocity - velocity_at(touching, obstacle, x, VELOCITY)
                middle = first + before * acceleration
                last = first + span * acceleration
                early = 0.0 - 0.5 * before * force.dot(first + middle)
                late = 0.0 - 0.5 * after * force.dot(middle + last)
                work_before += early
                work_after += late
                if ti.static(touching.kinds.layered):
                    if ti.static(not touching.kinds.static_friction):
                        rubbed, strongest = node_place(k, RUBBED), node_place(k, FORCE)
                        touching.friction[rubbed] = touching.friction[rubbed] + early + late
                        touching.friction[strongest] = ti.max(touching.friction[strongest], force.norm())
                if ti.static(touching.kinds.tracked):
                    if touching.traces[trace_place(touching, k, p, PRESSING)] > 0.0:
                        add_load(touching, obstacle, x, force)
            for j in ti.static(range(3)):
                place = 3 * k + j
                touching.force[place] = touching.force[place] + total[j]
                body.special_force[place] = body.special_force[place] - total[j]
                joined = SUMS.contact_force + j
                touching.sums[joined] = touching.sums[joined] + total[j]
    touching.sums[SUMS.friction_before] = touching.sums[SUMS.friction_before] + work_before
    touching.sums[SUMS.friction_after] = work_after


@ti.func
def slide(body: ti.template(), listed: ti.template(), touching: ti.template(), damped: ti.template()):
    """sliding: slip speed of every node without friction, and what a force takes away from it, for its layer."""
    slots = ti.static(touching.kinds.slots)
    span = body.params[0] + body.params[1]
    for k in range(touching.nodes.shape[0]):
        most, speed, mobility, mean = 0.0, 0.0, 0.0, 0.0
        x = position(touching.reference, k, body.u, touching.nodes[k])
        for p in ti.static(range(slots)):
            place = k * slots + p
            pressing = touching.traces[trace_place(touching, k, p, PRESSING)]
            if pressing > most:
                most = pressing
                _gap, normal = gap_and_normal(touching, touching.near[place], x)
                across = tangents(normal)
                velocity, acceleration, flexible = trial(body, listed, k, damped)
                wall = velocity_at(touching, touching.near[place], x, VELOCITY)
                slip = across @ (velocity + span * acceleration - wall)
                speed = slip.norm()
                if speed > 0.0:
                    mean = 0.5 * slip.dot(slip + across @ (velocity - wall)) / speed
                    mobility = slip.dot(span * (across @ flexible @ across.transpose()) @ slip) / (speed * speed)
        touching.friction[node_place(k, SPEED)] = speed
        touching.friction[node_place(k, SOFTNESS)] = mobility
        touching.friction[node_place(k, MEAN_SPEED)] = mean
