"""Motion of rigid bodies with the leapfrog of the nodes (METHOD 2).

    v^{n+1/2} = v^{n-1/2} + dt F^n/M,   o^{n+1} = o^n + dt v^{n+1/2}
    L^{n+1/2} = L^{n-1/2} + dt T^n,     R^{n+1} = exp(dt w) R^n,   w = I^-1 L at the pose R^{n+1/2} = exp(dt w/2) R^n

o: centre of mass; L, T: angular momentum and moment about it, in axes of the world; R: rotation since the start, a unit
quaternion. Angular momentum is exact in free flight, and the midpoint makes the rotation reversible in time and second
order (Simo and Wong, Int. J. Numer. Meth. Eng. 31, 19, 1991, with the force of the leapfrog). Places: rigid_places.py.
"""

import taichi as ti

from ..columns import RIGID, RIGID_SUMS, ROW_POSE, ROW_POSE_SIZE
from ..lanes import DRIFT, GRAVITY, KICK_AFTER, KICK_BEFORE
from ..language.entries import put_three, three
from ..rigid_places import (
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
    MOVED,
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
def turned(turn, vector):
    """Return the quaternion of a rotation by a rotation vector [rad] after `turn`, of length 1."""
    angle = vector.norm()
    share = 0.5  # sin(angle/2)/angle
    if angle > 1e-8:
        share = ti.sin(0.5 * angle) / angle
    c = ti.cos(0.5 * angle)
    axis = share * vector
    w, own = turn[0], ti.Vector([turn[1], turn[2], turn[3]])
    rest = c * own + w * axis + axis.cross(own)
    result = ti.Vector([c * w - axis.dot(own), rest[0], rest[1], rest[2]])
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
def move_bodies(rigid: ti.template(), body: ti.template(), damped: ti.template()):
    """Advance all free bodies by a step; sum up energy and momenta at time level n, and store their poses there."""
    drift = body.params[DRIFT]
    first = int(rigid.values[SUMS_AT])
    gravity = ti.Vector([body.params[GRAVITY + j] for j in ti.static(range(3))])
    sums = ti.Vector.zero(ti.f64, RIGID_SUMS)
    row = 0
    for p in range(body_count(rigid)):
        at = record_of(p)
        if kind_of(rigid, p) == FREE:
            centre, mass = position_of(rigid, at), rigid.values[at + MASS]
            velocity, spin = kick_body(rigid, body, at, damped)
            turn = turn_of(rigid, at)
            rate = inverse_inertia(rigid, at, turn, spin)
            momentum = mass * velocity
            whole = centre.cross(momentum) + spin
            sums[RIGID.kinetic] += 0.5 * (velocity.dot(momentum) + spin.dot(rate))
            sums[RIGID.load_work] += mass * gravity.dot(three(rigid.values, at + MOVED))
            for j in ti.static(range(3)):
                sums[RIGID.momentum + j] += momentum[j]
                sums[RIGID.angular_momentum + j] += whole[j]
            place = first + RIGID_SUMS + ROW_POSE_SIZE * row
            put_three(rigid.sums, place + ROW_POSE.obstacle_position, centre)
            put_three(rigid.sums, place + ROW_POSE.obstacle_rotation, rotation_vector(turn))
            put_three(rigid.sums, place + ROW_POSE.obstacle_velocity, velocity)
            put_three(rigid.sums, place + ROW_POSE.obstacle_angular_velocity, rate)
            if drift != 0.0:
                drift_body(rigid, at, drift)
        if kind_of(rigid, p) != PRESCRIBED:
            row += 1
    rigid.sums[first + RIGID.kinetic], rigid.sums[first + RIGID.load_work] = sums[RIGID.kinetic], sums[RIGID.load_work]
    for j in ti.static(range(3)):
        rigid.sums[first + RIGID.momentum + j] = sums[RIGID.momentum + j]
        rigid.sums[first + RIGID.angular_momentum + j] = sums[RIGID.angular_momentum + j]
