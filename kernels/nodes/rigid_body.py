"""Motion of rigid bodies with the leapfrog of the nodes (METHOD 2).

    v^{n+1/2} = v^{n-1/2} + dt F^n/M,   o^{n+1} = o^n + dt v^{n+1/2}
    L^{n+1/2} = L^{n-1/2} + dt T^n,     R^{n+1} = exp(dt w) R^n,   w = I^-1 L at the pose R^{n+1/2} = exp(dt w/2) R^n

o: centre of mass; L, T: angular momentum and moment about it, in axes of the world; R: rotation since the start, a unit
quaternion. Angular momentum is exact in free flight, and the midpoint makes the rotation reversible in time and second
order (Simo and Wong, Int. J. Numer. Meth. Eng. 31, 19, 1991, with the force of the leapfrog). Places: rigid_places.py.
"""

import taichi as ti

from ..columns import FIRST as PLACE
from ..columns import RIGID, RIGID_SUMS, ROW_POSE, ROW_POSE_SIZE, SUPPORT, SUPPORT_SUMS
from ..lanes import DAMPING, DRIFT, GRAVITY, KICK_AFTER, KICK_BEFORE
from ..language.entries import put_three, row, three
from ..rigid_places import (
    ARMS_AT,
    AXES,
    COUNT,
    FORCE,
    FREE,
    HEAD,
    INVERSE_MASS,
    INVERSE_MOMENTS,
    KIND,
    MASS,
    MEAN_SPIN,
    MOMENT,
    MOMENTS,
    MOVED,
    POSE,
    POSES_AT,
    PRESCRIBED,
    RECORD,
    SPIN,
    START,
    SUMS_AT,
    TURN,
    VELOCITY,
)
from .damping import damped_acceleration

ITERATIONS = 30  # of the midpoint, at most
SAME = 1e-16  # change of the angular velocity at which they end


@ti.func
def body_count(rigid: ti.template()):
    """Return the number of records."""
    return int(rigid.values[COUNT])


@ti.func
def record_of(p):
    """Return the first place of record p."""
    return HEAD + RECORD * p


@ti.func
def kind_of(rigid: ti.template(), p):
    """Return PRESCRIBED, FREE or DRIVEN."""
    return int(rigid.values[record_of(p) + KIND])


@ti.func
def turn_of(rigid: ti.template(), at):
    """Return the rotation since the start as a quaternion [4]."""
    return ti.Vector([rigid.values[at + TURN + j] for j in ti.static(range(4))])


@ti.func
def matrix_of(turn):
    """Return the rotation matrix [3, 3] of a unit quaternion."""
    w, x, y, z = turn[0], turn[1], turn[2], turn[3]
    return ti.Matrix(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )


@ti.func
def joined(last, first):
    """Return the quaternion of the rotation `last` after `first`."""
    w, own = first[0], ti.Vector([first[1], first[2], first[3]])
    c, axis = last[0], ti.Vector([last[1], last[2], last[3]])
    rest = c * own + w * axis + axis.cross(own)
    return ti.Vector([c * w - axis.dot(own), rest[0], rest[1], rest[2]])


@ti.func
def turned(turn, vector):
    """Return the quaternion of a rotation by a rotation vector [rad] after `turn`, of length 1."""
    angle = vector.norm()
    share = 0.5  # sin(angle/2)/angle
    if angle > 1e-8:
        share = ti.sin(0.5 * angle) / angle
    axis = share * vector
    result = joined(ti.Vector([ti.cos(0.5 * angle), axis[0], axis[1], axis[2]]), turn)
    return result / result.norm()


@ti.func
def rotation_vector(turn):
    """Return the rotation vector [3] [rad] of a unit quaternion, at most pi long."""
    side = ti.select(turn[0] < 0.0, -1.0, 1.0)
    part = side * ti.Vector([turn[1], turn[2], turn[3]])
    size = part.norm()
    share = 2.0
    if size > 1e-12:
        share = 2.0 * ti.atan2(size, side * turn[0]) / size
    return share * part


@ti.func
def inverse_inertia(rigid: ti.template(), at, turn, vector):
    """Return I^-1 of the body, turned, times a vector [3]."""
    axes = ti.Matrix([[rigid.values[at + AXES + 3 * i + j] for j in range(3)] for i in range(3)])
    now = axes @ matrix_of(turn).transpose()
    own = now @ vector
    scaled = ti.Vector([rigid.values[at + INVERSE_MOMENTS + j] * own[j] for j in ti.static(range(3))])
    return now.transpose() @ scaled


@ti.func
def inertia(rigid: ti.template(), at, turn, vector):
    """Return I of the body, turned, times a vector [3]."""
    axes = ti.Matrix([[rigid.values[at + AXES + 3 * i + j] for j in range(3)] for i in range(3)])
    now = axes @ matrix_of(turn).transpose()
    own = now @ vector
    scaled = ti.Vector([rigid.values[at + MOMENTS + j] * own[j] for j in ti.static(range(3))])
    return now.transpose() @ scaled


@ti.func
def angular_velocity(rigid: ti.template(), at):
    """Return the angular velocity [3] of the present angular momentum at the present pose."""
    return inverse_inertia(rigid, at, turn_of(rigid, at), three(rigid.values, at + SPIN))


@ti.func
def position_of(rigid: ti.template(), at):
    """Return the present centre of mass [3] [m]."""
    return three(rigid.values, at + START) + three(rigid.values, at + MOVED)


@ti.func
def rigid_rate(rigid: ti.template()):
    """Return the square of the largest frequency [1/s^2] of a rigid body on its contact cells, of this row."""
    return rigid.sums[int(rigid.values[SUMS_AT]) + RIGID.rigid_rate]


@ti.func
def kick_body(rigid: ti.template(), body: ti.template(), at, damped: ti.template()):
    """Kick velocity and angular momentum of a free body; return both at the time level."""
    before, after = body.params[KICK_BEFORE], body.params[KICK_AFTER]
    velocity, spin = three(rigid.values, at + VELOCITY), three(rigid.values, at + SPIN)
    force, moment = three(rigid.values, at + FORCE), three(rigid.values, at + MOMENT)
    rate, torque = ti.Vector.zero(ti.f64, 3), ti.Vector.zero(ti.f64, 3)
    for j in ti.static(range(3)):
        undamped = rigid.values[at + INVERSE_MASS] * force[j] + body.params[GRAVITY + j]
        rate[j] = damped_acceleration(damped, body, undamped, velocity[j])
        torque[j] = damped_acceleration(damped, body, moment[j], spin[j])
    put_three(rigid.values, at + VELOCITY, velocity + (before + after) * rate)
    put_three(rigid.values, at + SPIN, spin + (before + after) * torque)
    return velocity + before * rate, spin + before * torque


@ti.func
def drift_body(rigid: ti.template(), at, step):
    """Move and turn a free body over a step [s]."""
    velocity, spin, turn = three(rigid.values, at + VELOCITY), three(rigid.values, at + SPIN), turn_of(rigid, at)
    put_three(rigid.values, at + MOVED, three(rigid.values, at + MOVED) + step * velocity)
    rate = inverse_inertia(rigid, at, turn, spin)
    for _ in range(ITERATIONS):
        following = inverse_inertia(rigid, at, turned(turn, 0.5 * step * rate), spin)
        change = (following - rate).norm()
        rate = following
        if change <= SAME * rate.norm():
            break
    after = turned(turn, step * rate)
    for j in ti.static(range(4)):
        rigid.values[at + TURN + j] = after[j]
    put_three(rigid.values, at + MEAN_SPIN, rate)


@ti.func
def drive_body(rigid: ti.template(), body: ti.template(), at, pose, damped: ti.template()):
    """Move a driven body to a pose; return velocity and angular momentum at the time level, and what drives it.

    That is the force [3] and moment [3] with which the leapfrog of a free body leads there. pose: place of the pose of
    the next time level, which is not read where no step follows.
    """
    before, after, drift = body.params[KICK_BEFORE], body.params[KICK_AFTER], body.params[DRIFT]
    velocity, spin = three(rigid.values, at + VELOCITY), three(rigid.values, at + SPIN)
    rate, torque = ti.Vector.zero(ti.f64, 3), ti.Vector.zero(ti.f64, 3)
    if drift > 0.0:
        moved, turn = three(rigid.values, pose), turn_of(rigid, at)
        after_turn = ti.Vector([rigid.values[pose + 3 + j] for j in ti.static(range(4))])
        back = ti.Vector([turn[0], 0.0 - turn[1], 0.0 - turn[2], 0.0 - turn[3]])
        mean = rotation_vector(joined(after_turn, back)) / drift
        new = (moved - three(rigid.values, at + MOVED)) / drift
        new_spin = inertia(rigid, at, turned(turn, 0.5 * drift * mean), mean)
        rate, torque = (new - velocity) / (before + after), (new_spin - spin) / (before + after)
        put_three(rigid.values, at + MOVED, moved)
        put_three(rigid.values, at + VELOCITY, new)
        put_three(rigid.values, at + SPIN, new_spin)
        put_three(rigid.values, at + MEAN_SPIN, mean)
        for j in ti.static(range(4)):
            rigid.values[at + TURN + j] = after_turn[j]
    mass, gravity = rigid.values[at + MASS], ti.Vector([body.params[GRAVITY + j] for j in ti.static(range(3))])
    now, now_spin = velocity + before * rate, spin + before * torque
    force = mass * (rate - gravity) - three(rigid.values, at + FORCE)
    moment = torque - three(rigid.values, at + MOMENT)
    if ti.static(damped == "mass-damping"):
        force += body.params[DAMPING] * mass * now
        moment += body.params[DAMPING] * now_spin
    return now, now_spin, force, moment


@ti.func
def move_bodies(rigid: ti.template(), body: ti.template(), level, damped: ti.template(), has_supports: ti.template()):
    """Advance all rigid bodies by a step; sum up energy and momenta at time level n, and store their poses there.

    level: number of the next time level among the poses of driven bodies, whose reactions join those of the supports.
    """
    first = int(rigid.values[SUMS_AT])
    gravity = ti.Vector([body.params[GRAVITY + j] for j in ti.static(range(3))])
    sums = ti.Vector.zero(ti.f64, RIGID_SUMS)
    support = ti.Vector.zero(ti.f64, SUPPORT_SUMS)
    if ti.static(has_supports):
        support = ti.Vector([rigid.sums[PLACE.support + j] for j in ti.static(range(SUPPORT_SUMS))])
    number = 0
    for p in range(body_count(rigid)):
        at, kind = record_of(p), kind_of(rigid, p)
        if kind != PRESCRIBED:
            centre, mass, turn = position_of(rigid, at), rigid.values[at + MASS], turn_of(rigid, at)
            moved = three(rigid.values, at + MOVED)
            velocity, spin = three(rigid.values, at + VELOCITY), three(rigid.values, at + SPIN)
            if kind == FREE:
                velocity, spin = kick_body(rigid, body, at, damped)
                if body.params[DRIFT] != 0.0:
                    drift_body(rigid, at, body.params[DRIFT])
            elif ti.static(rigid.tied):
                pose = int(rigid.values[POSES_AT]) + POSE * (body_count(rigid) * level + p)
                velocity, spin, force, moment = drive_body(rigid, body, at, pose, damped)
                support[SUPPORT.support_power] += moment.dot(inverse_inertia(rigid, at, turn, spin))
                for j in ti.static(range(3)):
                    support[SUPPORT.support_force + j] += force[j]
                    support[SUPPORT.support_power] += force[j] * velocity[j]
            rate = inverse_inertia(rigid, at, turn, spin)
            momentum = mass * velocity
            whole = centre.cross(momentum) + spin
            sums[RIGID.kinetic] += 0.5 * (velocity.dot(momentum) + spin.dot(rate))
            sums[RIGID.load_work] += mass * gravity.dot(moved)
            for j in ti.static(range(3)):
                sums[RIGID.momentum + j] += momentum[j]
                sums[RIGID.angular_momentum + j] += whole[j]
            place = first + RIGID_SUMS + ROW_POSE_SIZE * number
            put_three(rigid.sums, place + ROW_POSE.obstacle_position, centre)
            put_three(rigid.sums, place + ROW_POSE.obstacle_rotation, rotation_vector(turn))
            put_three(rigid.sums, place + ROW_POSE.obstacle_velocity, velocity)
            put_three(rigid.sums, place + ROW_POSE.obstacle_angular_velocity, rate)
            number += 1
    rigid.sums[first + RIGID.kinetic], rigid.sums[first + RIGID.load_work] = sums[RIGID.kinetic], sums[RIGID.load_work]
    for j in ti.static(range(3)):
        rigid.sums[first + RIGID.momentum + j] = sums[RIGID.momentum + j]
        rigid.sums[first + RIGID.angular_momentum + j] = sums[RIGID.angular_momentum + j]
    if ti.static(rigid.tied):
        for j in ti.static(range(SUPPORT_SUMS)):
            rigid.sums[PLACE.support + j] = support[j]


@ti.func
def gather_forces(rigid: ti.template(), body: ti.template()):
    """Set force and moment on every body with tied nodes to those of its nodes.

    special_force of the boundary nodes is the internal force.
    """
    for p in range(body_count(rigid)):
        at = record_of(p)
        turn = matrix_of(turn_of(rigid, at))
        force, moment = ti.Vector.zero(ti.f64, 3), ti.Vector.zero(ti.f64, 3)
        for t in range(rigid.ties[p], rigid.ties[p + 1]):
            part = row(body.special_force, tied_node(rigid, t))
            force = force - part
            moment = moment - (turn @ arm_of(rigid, t)).cross(part)
        if rigid.ties[p + 1] > rigid.ties[p]:
            put_three(rigid.values, at + FORCE, force)
            put_three(rigid.values, at + MOMENT, moment)


@ti.func
def carry_nodes(rigid: ti.template(), body: ti.template(), boundary: ti.template()):
    """Place the tied nodes at the pose of their body, with the velocity that led there.

    R^{n+1} r - R^n r = dt sin(a)/a w x R^{n+1/2} r with a = |dt w|/2; without a step it is w x R r.
    """
    drift = body.params[DRIFT]
    for p in range(body_count(rigid)):
        at = record_of(p)
        turn, rate = turn_of(rigid, at), angular_velocity(rigid, at)
        if drift != 0.0:
            rate = three(rigid.values, at + MEAN_SPIN)
        half = 0.5 * drift * rate
        angle = half.norm()
        if angle > 1e-8:
            rate = ti.sin(angle) / angle * rate
        now, middle = matrix_of(turn), matrix_of(turned(turn, 0.0 - half))
        for t in range(rigid.ties[p], rigid.ties[p + 1]):
            node, arm = boundary.nodes[tied_node(rigid, t)], arm_of(rigid, t)
            start = three(rigid.values, at + START) - row(body.position, node)
            velocity = three(rigid.values, at + VELOCITY) + rate.cross(middle @ arm)
            put_three(body.u, 3 * node, three(rigid.values, at + MOVED) + (start + now @ arm))
            put_three(body.v, 3 * node, velocity)


@ti.func
def tied_node(rigid: ti.template(), t):
    """Return the boundary node of tie t."""
    return rigid.ties[body_count(rigid) + 1 + t]


@ti.func
def arm_of(rigid: ti.template(), t):
    """Return the arm [3] of tie t from the centre of its body at t = 0."""
    return three(rigid.values, int(rigid.values[ARMS_AT]) + 3 * t)
