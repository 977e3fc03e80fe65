"""Nodes that move with rigid bodies, and bodies whose motion is prescribed.

    F = -sum f_i,   T = -sum R r_i x f_i,   x_i = o + R r_i

f_i: internal force of tied node i less its load, r_i: its arm from the centre of mass at the start. The force that
drives a body is what its leapfrog (rigid_body.py) would need to reach the prescribed poses, so that momentum and energy
hold as for supports.
"""

from ..engine import ti
from ..lanes import DAMPING, DRIFT, GRAVITY, KICK_AFTER, KICK_BEFORE
from ..language.entries import put_three, row, three
from ..rigid_places import (
    ARMS_AT,
    FORCE,
    MASS,
    MEAN_SPIN,
    MOMENT,
    MOVED,
    POSE,
    POSES_AT,
    SPIN,
    START,
    TURN,
    VELOCITY,
)
from .rigid_record import angular_velocity, body_count, inertia, record_of, turn_of
from .rotations import joined, matrix_of, rotation_vector, turned


@ti.func
def pose_of(rigid: ti.template(), p, level):
    """Return where the pose of body p at a time level of the launch begins."""
    return int(rigid.values[POSES_AT]) + POSE * (body_count(rigid) * level + p)


@ti.func
def driven_rates(rigid: ti.template(), body: ti.template(), at, pose):
    """Return velocity, angular momentum and mean spin [3] after the kick of a driven body, and their rates in it.

    They lead to the pose, which stands at the place `pose`: that of the next time level; where no step follows, that to
    which one more step of the same length would lead, with four zeros as rotation if it is not known.
    """
    before, after, drift = body.params[KICK_BEFORE], body.params[KICK_AFTER], body.params[DRIFT]
    velocity, spin = three(rigid.values, at + VELOCITY), three(rigid.values, at + SPIN)
    rate, torque = ti.Vector.zero(ti.f64, 3), ti.Vector.zero(ti.f64, 3)
    after_turn = ti.Vector([rigid.values[pose + 3 + j] for j in ti.static(range(4))])
    step = ti.select(drift > 0.0, drift, 2.0 * before)
    span = before + ti.select(drift > 0.0, after, before)
    moved, mean = three(rigid.values, pose), ti.Vector.zero(ti.f64, 3)
    new, new_spin = velocity, spin
    if step > 0.0 and after_turn.dot(after_turn) > 0.0:
        turn = turn_of(rigid, at)
        back = ti.Vector([turn[0], 0.0 - turn[1], 0.0 - turn[2], 0.0 - turn[3]])
        mean = rotation_vector(joined(after_turn, back)) / step
        new = (moved - three(rigid.values, at + MOVED)) / step
        new_spin = inertia(rigid, at, turned(turn, 0.5 * step * mean), mean)
        rate, torque = (new - velocity) / span, (new_spin - spin) / span
    return new, new_spin, mean, rate, torque


@ti.func
def drive_body(rigid: ti.template(), body: ti.template(), at, pose, damped: ti.template()):
    """Move a driven body to a pose; return velocity and angular momentum at the time level, and what drives it.

    That is the force [3] and moment [3] with which the leapfrog of a free body leads there; pose: see `driven_rates`.
    """
    before, drift = body.params[KICK_BEFORE], body.params[DRIFT]
    velocity, spin = three(rigid.values, at + VELOCITY), three(rigid.values, at + SPIN)
    new, new_spin, mean, rate, torque = driven_rates(rigid, body, at, pose)
    if drift > 0.0:
        put_three(rigid.values, at + MOVED, three(rigid.values, pose))
        put_three(rigid.values, at + VELOCITY, new)
        put_three(rigid.values, at + SPIN, new_spin)
        put_three(rigid.values, at + MEAN_SPIN, mean)
        for j in ti.static(range(4)):
            rigid.values[at + TURN + j] = rigid.values[pose + 3 + j]
    mass, gravity = rigid.values[at + MASS], ti.Vector([body.params[GRAVITY + j] for j in ti.static(range(3))])
    now, now_spin = velocity + before * rate, spin + before * torque
    if drift == 0.0:
        put_three(rigid.values, at + VELOCITY, now)
        put_three(rigid.values, at + SPIN, now_spin)
    force = mass * (rate - gravity) - three(rigid.values, at + FORCE)
    moment = torque - three(rigid.values, at + MOMENT)
    if ti.static(damped == "mass-damping"):
        force += body.params[DAMPING] * mass * now
        moment += body.params[DAMPING] * now_spin
    return now, now_spin, force, moment


@ti.func
def gathered_forces(rigid: ti.template(), body: ti.template(), boundary: ti.template(), p):
    """Return force and moment on body p of its tied nodes."""
    turn = matrix_of(turn_of(rigid, record_of(p)))
    force, moment = ti.Vector.zero(ti.f64, 3), ti.Vector.zero(ti.f64, 3)
    for t in range(rigid.ties[p], rigid.ties[p + 1]):
        s = tied_node(rigid, t)
        part = row(body.special_force, s) - row(boundary.load, s)
        force = force - part
        moment = moment - (turn @ arm_of(rigid, t)).cross(part)
    return force, moment


@ti.func
def gather_forces(rigid: ti.template(), body: ti.template(), boundary: ti.template()):
    """Set force and moment on every body with tied nodes to those of its nodes.

    special_force of the boundary nodes is the internal force with that of springs, load that of applied loads.
    """
    for p in range(body_count(rigid)):
        at = record_of(p)
        force, moment = gathered_forces(rigid, body, boundary, p)
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
