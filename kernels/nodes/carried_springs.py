"""Ends of springs at nodes that rigid parts carry: how their mean position moves, and by a unit force.

    r += s V + w x a,   a = R a_0 = sum_i +- w_i R r_i,   s = sum_i +- w_i        over the carried nodes i of both ends
    W += (s^2/M) 1 + sum_j [I^-1 (a x e_j)] x a e_j^T                             of parts that move freely

V, w: velocity and angular velocity of the part, R r_i: arm of node i. s and a_0 stand behind the entries of the
springs, for each part at which a spring has nodes. The rates of V and of the angular momentum are those of the kick.
"""

from ..engine import ti
from ..lanes import DAMPING, KICK_BEFORE
from ..language.entries import three
from ..rigid_places import FREE, INVERSE_MASS, SPIN, VELOCITY
from .rigid_body import free_rates
from .rigid_parts import driven_rates, gathered_forces, pose_of
from .rigid_record import inverse_inertia, kind_of, record_of, turn_of
from .rotations import matrix_of


@ti.func
def carried_rate(
    body: ti.template(), boundary: ti.template(), rigid: ti.template(), place, level, damped: ti.template()
):
    """Return what a rigid part adds to r of a spring before the kick, to its change per second of kick, and to W.

    place: of the numbers of the carrier in `boundary.mass`; level: see `move_bodies`.
    """
    p, share = int(boundary.mass[place]), boundary.mass[place + 1]
    at = record_of(p)
    turn = turn_of(rigid, at)
    arm = matrix_of(turn) @ three(boundary.mass, place + 2)
    velocity, spin = three(rigid.values, at + VELOCITY), three(rigid.values, at + SPIN)
    rate, torque = ti.Vector.zero(ti.f64, 3), ti.Vector.zero(ti.f64, 3)
    flexible = ti.Matrix.zero(ti.f64, 3, 3)
    if kind_of(rigid, p) == FREE:
        force, moment = gathered_forces(rigid, body, boundary, p)
        rate, torque = free_rates(rigid, body, at, force, moment, damped)
        for j in ti.static(range(3)):
            unit = ti.Vector([1.0 if i == j else 0.0 for i in ti.static(range(3))])
            answer = inverse_inertia(rigid, at, turn, arm.cross(unit)).cross(arm)
            for i in ti.static(range(3)):
                flexible[i, j] = answer[i]
            flexible[j, j] += share * share * rigid.values[at + INVERSE_MASS]
        if ti.static(damped == "mass-damping"):
            flexible = flexible / (1.0 + body.params[DAMPING] * body.params[KICK_BEFORE])
    else:
        _new, _new_spin, _mean, rate, torque = driven_rates(rigid, body, at, pose_of(rigid, p, level))
    moving = share * velocity + inverse_inertia(rigid, at, turn, spin).cross(arm)
    change = share * rate + inverse_inertia(rigid, at, turn, torque).cross(arm)
    return moving, change, flexible
