"""Obstacles that move freely: their load, and their pose and velocity in the records of the obstacles.

Record p of the rigid bodies belongs to obstacle p (nodes/rigid_body.py). The pose of level n + 1 is known before the
static solve of that level, so that the massless nodes stand exactly at the obstacle; the force of the level then acts
on nodes and obstacle alike.
"""

import taichi as ti

from ..columns import OBSTACLE_LOAD, OBSTACLE_LOADS, RIGID, loads_place
from ..language.entries import put_three, three
from ..nodes.rigid_body import angular_velocity, inverse_inertia, kind_of, matrix_of, record_of, turn_of
from ..rigid_places import (
    CENTRE,
    FORCE,
    FRAME,
    FREE,
    INVERSE_MASS,
    MEAN_SPIN,
    MOMENT,
    MOVED,
    START,
    SUMS_AT,
    VELOCITY,
)
from . import obstacles as place_of


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
def point_acceleration(rigid: ti.template(), p, arm, force, moment):
    """Return the acceleration [3] of the point of free obstacle p at an arm [3] from its centre by force and moment."""
    at = record_of(p)
    turning = inverse_inertia(rigid, at, turn_of(rigid, at), moment)
    return rigid.values[at + INVERSE_MASS] * force + turning.cross(arm)
