"""Obstacles that move freely: their load, and their pose and velocity in the records of the obstacles.

Record p of the rigid bodies belongs to obstacle p (nodes/rigid_body.py). The pose of level n + 1 is known before the
static solve of that level, so that the massless nodes stand exactly at the obstacle; the force of the level then acts
on nodes and obstacle alike.
"""

from ..columns import OBSTACLE_LOAD, OBSTACLE_LOADS, RIGID, loads_place
from ..engine import ti
from ..lanes import GRAVITY
from ..language.entries import put_three, three
from ..nodes.rigid_record import angular_velocity, inverse_inertia, kind_of, record_of, turn_of
from ..nodes.rotations import matrix_of
from ..rigid_places import (
    CENTRE,
    FORCE,
    FRAME,
    FREE,
    INVERSE_MASS,
    MASS,
    MEAN_SPIN,
    MOMENT,
    MOVED,
    START,
    SUMS_AT,
    VELOCITY,
)
from . import obstacles as place_of
from .constraint_rows import vector_of
from .islands import node_count
from .obstacle_rows import position


@ti.func
def load_free_obstacles(rigid: ti.template(), obstacles: ti.template(), contact: ti.template()):
    """Set force and moment on every free obstacle to its load, and sum up the forces."""
    power = ti.static(loads_place(contact.options.friction != ""))
    total = ti.Vector.zero(ti.f64, 3)
    for p in range(obstacles.records.shape[0] // place_of.RECORD):
        if kind_of(rigid, p) == FREE:
            first = power + 1 + OBSTACLE_LOADS * p
            force = three(contact.sums, first + OBSTACLE_LOAD.obstacle_force)
            put_three(rigid.values, record_of(p) + FORCE, force)
            put_three(rigid.values, record_of(p) + MOMENT, three(contact.sums, first + OBSTACLE_LOAD.obstacle_moment))
            total += force
    put_three(rigid.sums, int(rigid.values[SUMS_AT]) + RIGID.rigid_force, total)


@ti.func
def place_free_obstacles(rigid: ti.template(), obstacles: ti.template()):
    """Write pose and velocities of the free obstacles into their records."""
    for p in range(obstacles.records.shape[0] // place_of.RECORD):
        if kind_of(rigid, p) == FREE:
            at, record = record_of(p), place_of.RECORD * p
            centre = three(rigid.values, at + START) - three(rigid.values, CENTRE)
            put_three(obstacles.records, record + place_of.POINT, centre + three(rigid.values, at + MOVED))
            frame = ti.Matrix([[rigid.values[at + FRAME + 3 * i + j] for j in range(3)] for i in range(3)])
            now = frame @ matrix_of(turn_of(rigid, at)).transpose()
            for i, j in ti.static(ti.ndrange(3, 3)):
                obstacles.records[record + place_of.FRAME + 3 * i + j] = now[i, j]
            velocity = three(rigid.values, at + VELOCITY)
            put_three(obstacles.records, record + place_of.VELOCITY, velocity)
            put_three(obstacles.records, record + place_of.SPIN, angular_velocity(rigid, at))
            put_three(obstacles.records, record + place_of.MEAN_VELOCITY, velocity)
            put_three(obstacles.records, record + place_of.MEAN_SPIN, three(rigid.values, at + MEAN_SPIN))


@ti.func
def arm_to(obstacles: ti.template(), contact: ti.template(), body: ti.template(), k, p):
    """Return the arm [3] from the centre of obstacle p to contact node k."""
    x = position(contact.reference, k, body.u, contact.nodes[k])
    return x - three(obstacles.records, place_of.RECORD * p + place_of.POINT)


@ti.func
def begin_free_friction(
    rigid: ti.template(), obstacles: ti.template(), rows: ti.template(), contact: ti.template(), body: ti.template()
):
    """Set force and moment on the free obstacles to those of gravity and of the rows without friction of the kick."""
    for p in range(obstacles.records.shape[0] // place_of.RECORD):
        at = record_of(p)
        for j in ti.static(range(3)):
            rigid.values[at + FORCE + j] = rigid.values[at + MASS] * body.params[GRAVITY + j]
            rigid.values[at + MOMENT + j] = 0.0
    for k in range(node_count(contact)):
        for r in range(k * rows.options.slots, k * rows.options.slots + rows.options.obstacle_slots):
            press_free(rigid, obstacles, contact, body, k, r, vector_of(rows, r, rows.at.force))


@ti.func
def press_free(
    rigid: ti.template(), obstacles: ti.template(), contact: ti.template(), body: ti.template(), k, r, force
):
    """Subtract the force [3] of row r on node k from the force on its obstacle, if that moves freely."""
    p = obstacles.candidates[r]
    if kind_of(rigid, p) == FREE:
        at = record_of(p)
        moment = arm_to(obstacles, contact, body, k, p).cross(force)
        put_three(rigid.values, at + FORCE, three(rigid.values, at + FORCE) - force)
        put_three(rigid.values, at + MOMENT, three(rigid.values, at + MOMENT) - moment)


@ti.func
def wall_acceleration(
    rigid: ti.template(), obstacles: ti.template(), contact: ti.template(), body: ti.template(), k, r
):
    """Return the acceleration [3] of the obstacle of row r at node k by its present force; 0 unless it moves freely."""
    p = obstacles.candidates[r]
    result = ti.Vector.zero(ti.f64, 3)
    if kind_of(rigid, p) == FREE:
        at = record_of(p)
        turning = inverse_inertia(rigid, at, turn_of(rigid, at), three(rigid.values, at + MOMENT))
        result = rigid.values[at + INVERSE_MASS] * three(rigid.values, at + FORCE)
        result += turning.cross(arm_to(obstacles, contact, body, k, p))
    return result


@ti.func
def point_mobility(rigid: ti.template(), obstacles: ti.template(), contact: ti.template(), body: ti.template(), k, r):
    """Return the acceleration [3, 3] of the obstacle of row r at node k by a unit force there."""
    p = obstacles.candidates[r]
    result = ti.Matrix.zero(ti.f64, 3, 3)
    if kind_of(rigid, p) == FREE:
        at, arm = record_of(p), arm_to(obstacles, contact, body, k, p)
        for j in ti.static(range(3)):
            axis = ti.Vector([1.0 if i == j else 0.0 for i in ti.static(range(3))])
            turning = inverse_inertia(rigid, at, turn_of(rigid, at), arm.cross(axis)).cross(arm)
            for i in ti.static(range(3)):
                result[i, j] = turning[i] + rigid.values[at + INVERSE_MASS] * axis[i]
    return result
