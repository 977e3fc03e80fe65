"""Motion of rigid bodies with the leapfrog of the nodes (METHOD 2).

    v^{n+1/2} = v^{n-1/2} + dt F^n/M,   o^{n+1} = o^n + dt v^{n+1/2}
    L^{n+1/2} = L^{n-1/2} + dt T^n,     R^{n+1} = exp(dt w) R^n,   w = I^-1 L at the pose R^{n+1/2} = exp(dt w/2) R^n

o: centre of mass; L, T: angular momentum and moment about it, in axes of the world; R: rotation since the start, a unit
quaternion. Angular momentum is exact in free flight, and the midpoint makes the rotation reversible in time and second
order (Simo and Wong, Int. J. Numer. Meth. Eng. 31, 19, 1991, with the force of the leapfrog). Places: rigid_places.py.
"""

from ..columns import FIRST, RIGID, RIGID_SUMS, ROW_POSE, ROW_POSE_SIZE, SUPPORT, SUPPORT_SUMS
from ..engine import ti
from ..lanes import DRIFT, GRAVITY, KICK_AFTER, KICK_BEFORE
from ..language.entries import put_three, three
from ..rigid_places import (
    FORCE,
    FREE,
    INVERSE_MASS,
    MASS,
    MEAN_SPIN,
    MOMENT,
    MOVED,
    PRESCRIBED,
    SPIN,
    SUMS_AT,
    TURN,
    VELOCITY,
)
from .damping import damped_acceleration
from .rigid_parts import drive_body, pose_of
from .rigid_record import body_count, inverse_inertia, kind_of, position_of, record_of, turn_of
from .rotations import rotation_vector, turned

ITERATIONS = 30  # of the midpoint, at most
SAME = 1e-16  # change of the angular velocity at which they end


@ti.func
def free_rates(rigid: ti.template(), body: ti.template(), at, force, moment, damped: ti.template()):
    """Return the rates of velocity and angular momentum of a free body in the kick by force and moment on it."""
    velocity, spin = three(rigid.values, at + VELOCITY), three(rigid.values, at + SPIN)
    rate, torque = ti.Vector.zero(ti.f64, 3), ti.Vector.zero(ti.f64, 3)
    for j in ti.static(range(3)):
        undamped = rigid.values[at + INVERSE_MASS] * force[j] + body.params[GRAVITY + j]
        rate[j] = damped_acceleration(damped, body, undamped, velocity[j])
        torque[j] = damped_acceleration(damped, body, moment[j], spin[j])
    return rate, torque


@ti.func
def kick_body(rigid: ti.template(), body: ti.template(), at, damped: ti.template()):
    """Kick velocity and angular momentum of a free body; return both at the time level."""
    before, after = body.params[KICK_BEFORE], body.params[KICK_AFTER]
    velocity, spin = three(rigid.values, at + VELOCITY), three(rigid.values, at + SPIN)
    force, moment = three(rigid.values, at + FORCE), three(rigid.values, at + MOMENT)
    rate, torque = free_rates(rigid, body, at, force, moment, damped)
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
def move_bodies(rigid: ti.template(), body: ti.template(), level, damped: ti.template(), has_supports: ti.template()):
    """Advance all rigid bodies by a step; sum up energy and momenta at time level n, and store their poses there.

    level: number of the next time level among the poses of driven bodies, whose reactions join those of the supports.
    """
    first = int(rigid.values[SUMS_AT])
    gravity = ti.Vector([body.params[GRAVITY + j] for j in ti.static(range(3))])
    sums = ti.Vector.zero(ti.f64, RIGID_SUMS)
    support = ti.Vector.zero(ti.f64, SUPPORT_SUMS)
    if ti.static(has_supports):
        support = ti.Vector([rigid.sums[FIRST.support + j] for j in ti.static(range(SUPPORT_SUMS))])
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
                velocity, spin, force, moment = drive_body(rigid, body, at, pose_of(rigid, p, level), damped)
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
            rigid.sums[FIRST.support + j] = support[j]
