"""The record of a rigid body (rigid_places.py): its pose, its inertia turned into the world, its angular velocity."""

from ..columns import RIGID
from ..engine import ti
from ..language.entries import three
from ..rigid_places import AXES, COUNT, HEAD, INVERSE_MOMENTS, KIND, MOMENTS, MOVED, RECORD, SPIN, START, SUMS_AT, TURN
from .rotations import matrix_of


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
def turned_moments(rigid: ti.template(), at, turn, vector, moments: ti.template()):
    """Return the tensor of the moments about the principal axes, turned, times a vector [3]."""
    axes = ti.Matrix([[rigid.values[at + AXES + 3 * i + j] for j in range(3)] for i in range(3)])
    now = axes @ matrix_of(turn).transpose()
    own = now @ vector
    scaled = ti.Vector([rigid.values[at + moments + j] * own[j] for j in ti.static(range(3))])
    return now.transpose() @ scaled


@ti.func
def inverse_inertia(rigid: ti.template(), at, turn, vector):
    """Return I^-1 of the body, turned, times a vector [3]."""
    return turned_moments(rigid, at, turn, vector, INVERSE_MOMENTS)


@ti.func
def inertia(rigid: ti.template(), at, turn, vector):
    """Return I of the body, turned, times a vector [3]."""
    return turned_moments(rigid, at, turn, vector, MOMENTS)


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
