"""Friction on the components of contact nodes that have mass, as an impulse of the kick (METHOD 3).

    v = v* + M^-1 p,   p = -M v*_T if that is at most mu lambda span, else scaled back to it

v*: velocity relative to the obstacle that the kick over `span` would give without friction. Exact stick, no creep.
The work up to row n takes the part of the kick before it:  -t.(v^{n-1/2} + v^n)/2 k0,  the rest comes after.
"""

import taichi as ti

from .boundary_nodes import row, symmetric
from .constraint_rows import normal_of, number_of, set_vector, vector_of, velocity_of
from .friction import (
    FORCE,
    LIMIT,
    MEAN_SPEED,
    RUBBED,
    SLIP_SPEED,
    SOFTNESS,
    SPEED,
    node_place,
    resist,
    tangents,
)
from .islands import first_node, island_count, node_count, sums_of
from .lanes import DAMPING_RATE, FRICTION_AT

SEVERAL = 300  # rounds over the obstacles of a node that touches more than one, until their forces agree to
AGREED = 1e-13  # of what presses; sticking to two at a small angle takes a hundred


@ti.func
def trial(body: ti.template(), listed: ti.template(), k, damped: ti.template()):
    """Velocity before the kick, acceleration by all forces but friction, and what a force adds to it [3, 3]."""
    node = listed.nodes[k]
    velocity = row(body.v, node)
    flexible = symmetric(listed.inverse_mass, k)
    net = row(listed.load, k) - row(body.special_force, k)
    if ti.static(damped):
        rate = body.params[DAMPING_RATE]
        net = net - rate * (symmetric(listed.mass, k) @ velocity)
        flexible = flexible / (1.0 + rate * body.params[0])
    return velocity, flexible @ net, flexible


@ti.func
def with_mass(touching: ti.template(), k, relative):
    """What a velocity [3] is without the massless components of node k: their friction is in the static solve."""
    for j in ti.static(range(touching.kinds.block)):
        column = ti.Vector([touching.basis[(3 * k + i) * touching.kinds.block + j] for i in ti.static(range(3))])
        relative = relative - column.dot(relative) * column
    return relative


@ti.func
def kick_friction(
    body: ti.template(), listed: ti.template(), touching: ti.template(), rows: ti.template(), damped: ti.template()
):
    """Friction of all rows, and its work."""
    for island in range(island_count(touching)):
        early, late = 0.0, 0.0
        for k in range(first_node(touching, island), first_node(touching, island + 1)):
            before, after = kick_friction_node(body, listed, touching, rows, damped, k)
            early += before
            late += after
        at = sums_of(touching, island) + FRICTION_AT
        touching.sums[at] = touching.sums[at] + early
        touching.sums[at + 1] = late


@ti.func
def kick_friction_node(
    body: ti.template(), listed: ti.template(), touching: ti.template(), rows: ti.template(), damped: ti.template(), k
):
    """Friction of the rows of node k; returns its work before and after the level of the kick [J]."""
    slots = ti.static(touching.kinds.slots)
    before, after = body.params[0], body.params[1]
    span = before + after
    work_before, work_after = 0.0, 0.0
    pressed = 0.0
    for p in ti.static(range(slots)):
        pressed += number_of(rows, k * slots + p, rows.at.pressing)
    if ti.static(touching.kinds.layered and not touching.kinds.static_friction):
        touching.friction[node_place(k, RUBBED)] = 0.0
        touching.friction[node_place(k, FORCE)] = 0.0
    forces = ti.Matrix.zero(ti.f64, slots, 3)
    if pressed > 0.0 and span > 0.0:
        velocity, acceleration, flexible = trial(body, listed, k, damped)
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
                    if ti.static(touching.kinds.static_friction):
                        relative = with_mass(touching, k, relative)
                    slip = across @ relative
                    most = number_of(rows, r, rows.at.coefficient) * pressing
                    if ti.static(touching.kinds.static_friction):
                        there = vector_of(rows, k * slots + p, rows.at.traction)
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
            first = velocity - velocity_of(rows, k * slots + p, rows.at.velocity)
            middle = first + before * acceleration
            last = first + span * acceleration
            early = 0.0 - 0.5 * before * force.dot(first + middle)
            late = 0.0 - 0.5 * after * force.dot(middle + last)
            work_before += early
            work_after += late
            if ti.static(touching.kinds.layered and not touching.kinds.static_friction):
                rubbed, strongest = node_place(k, RUBBED), node_place(k, FORCE)
                touching.friction[rubbed] = touching.friction[rubbed] + early + late
                touching.friction[strongest] = ti.max(touching.friction[strongest], force.norm())
    for p in ti.static(range(slots)):
        set_vector(rows, k * slots + p, rows.at.kick_friction, ti.Vector([forces[p, j] for j in ti.static(range(3))]))
    return work_before, work_after


@ti.func
def slide(
    body: ti.template(), listed: ti.template(), touching: ti.template(), rows: ti.template(), damped: ti.template()
):
    """sliding: slip speed of every node without friction, and what a force takes away from it, for its layer."""
    for k in range(node_count(touching)):
        slide_node(body, listed, touching, rows, damped, k)


@ti.func
def slide_node(
    body: ti.template(), listed: ti.template(), touching: ti.template(), rows: ti.template(), damped: ti.template(), k
):
    """Slip of node k at the row that presses it most."""
    slots = ti.static(touching.kinds.slots)
    span = body.params[0] + body.params[1]
    most, speed, mobility, mean = 0.0, 0.0, 0.0, 0.0
    for p in ti.static(range(slots)):
        r = k * slots + p
        pressing = number_of(rows, k * slots + p, rows.at.pressing)
        if pressing > most:
            most = pressing
            across = tangents(normal_of(rows, r))
            velocity, acceleration, flexible = trial(body, listed, k, damped)
            wall = velocity_of(rows, r, rows.at.velocity)
            slip = across @ (velocity + span * acceleration - wall)
            speed = slip.norm()
            if speed > 0.0:
                mean = 0.5 * slip.dot(slip + across @ (velocity - wall)) / speed
                mobility = slip.dot(span * (across @ flexible @ across.transpose()) @ slip) / (speed * speed)
    touching.friction[node_place(k, SPEED)] = speed
    touching.friction[node_place(k, SOFTNESS)] = mobility
    touching.friction[node_place(k, MEAN_SPEED)] = mean
