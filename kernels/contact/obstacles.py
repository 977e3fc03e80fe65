"""Gaps to rigid obstacles and their normals into the body: g_p(x) is the signed distance, open positive.

An obstacle is a record of RECORD numbers in `obstacles.records`: shape, a reference point o of it, a frame Q (rows:
its own axes), parameters of the shape, velocity of o and angular velocity, now and as means over the step that led
here. Positions are relative to a point among the contact nodes, so that gaps keep their precision far from the origin.
If obstacles move, `obstacles.motion` holds a row of records per time level and `set_pose` takes the next one; the grids
of sampled distances follow the rows. Only the shapes in `obstacles.options.shapes` are compiled.
"""

from ..engine import ti
from ..lanes import OBSTACLE
from ..language.entries import three
from ..language.threads import item, meet, turns
from .obstacle_shapes import box_gap_normal, grid_gap_normal, level_face

# places in a record
SHAPE, POINT, FRAME, PARAMETERS, VELOCITY, SPIN, MEAN_VELOCITY, MEAN_SPIN = 0, 1, 4, 13, 21, 24, 27, 30
RECORD = OBSTACLE
CODES = {"plane": 0, "sphere": 1, "cylinder": 2, "box": 3, "sdf": 4}


@ti.func
def gap_and_normal(obstacles: ti.template(), p, x):
    """Return the gap [m] of position x to obstacle p, and the unit normal into the body there."""
    gap, normal, _face = gap_normal_face(obstacles, p, x, 0.0)
    return gap, normal


@ti.func
def gap_normal_face(obstacles: ti.template(), p, x, entered):
    """Return gap and normal, and of a block the number of the face that x is at (`box_gap_normal`), else 0."""
    values = ti.static(obstacles.records)
    start = RECORD * p
    y = x - three(values, start + POINT)
    gap = 1e300
    normal = three(values, start + FRAME + 6)  # normal of a plane, axis of a cylinder
    face = 0.0
    shape = int(values[start + SHAPE])
    alone = ti.static(len(obstacles.options.shapes) == 1)
    if ti.static("plane" in obstacles.options.shapes):
        if alone or shape == 0:
            gap = normal.dot(y)
    if ti.static("sphere" in obstacles.options.shapes):
        if alone or shape == 1:
            gap, normal = round_gap(y, values[start + PARAMETERS], values[start + PARAMETERS + 1])
    if ti.static("cylinder" in obstacles.options.shapes):
        if alone or shape == 2:
            gap, normal = round_gap(
                y - normal.dot(y) * normal, values[start + PARAMETERS], values[start + PARAMETERS + 1]
            )
    if ti.static("box" in obstacles.options.shapes or "sdf" in obstacles.options.shapes):
        if shape == 3 or shape == 4:
            gap, normal, face = framed_gap(obstacles, start, shape, y, entered)
    return gap, normal, face


@ti.func
def round_gap(y, radius, side):
    """Return gap and normal of a sphere about 0 (of a cylinder: y across its axis); side = 1 outside, -1 inside."""
    length = y.norm()
    normal = ti.Vector([0.0, 0.0, 1.0])
    if length > 1e-12 * radius:
        normal = y / length
    return side * (length - radius), side * normal


@ti.func
def framed_gap(obstacles: ti.template(), start, shape, y, entered):
    """Return gap, normal and face of a shape with axes of its own: box or sampled distance."""
    values = ti.static(obstacles.records)
    place = start + PARAMETERS
    frame = ti.Matrix([[values[start + FRAME + 3 * i + j] for j in range(3)] for i in range(3)])
    own = frame @ y
    gap = 1e300
    normal = ti.Vector([0.0, 0.0, 1.0])
    face = 0.0
    if ti.static("box" in obstacles.options.shapes):
        if shape == 3:
            gap, normal, face = box_gap_normal(own, three(values, place), entered)
    if ti.static("sdf" in obstacles.options.shapes):
        if shape == 4:
            gap, normal = grid_gap_normal(
                obstacles.motion,
                ti.cast(values[place + 7], ti.i32),
                three(values, place),
                values[place + 3],
                values[place + 4],
                values[place + 5],
                values[place + 6],
                own,
            )
    return gap, frame.transpose() @ normal, face


@ti.func
def level_with(obstacles: ti.template(), p, x, gap, normal):
    """Return the number of the face of block p in one plane with a surface to which x has this gap and normal, or 0."""
    values = ti.static(obstacles.records)
    start = RECORD * p
    found = 0.0
    if int(values[start + SHAPE]) == 3:
        frame = ti.Matrix([[values[start + FRAME + 3 * i + j] for j in range(3)] for i in range(3)])
        own = frame @ (x - three(values, start + POINT))
        found = level_face(own, three(values, start + PARAMETERS), gap, frame @ normal)
    return found


@ti.func
def velocity_at(obstacles: ti.template(), p, x, velocity: ti.template()):
    """Return the velocity [m/s] of the material point of obstacle p at x; velocity: VELOCITY or MEAN_VELOCITY."""
    start = RECORD * p
    arm = x - three(obstacles.records, start + POINT)
    spin = three(obstacles.records, start + velocity + 3)
    return three(obstacles.records, start + velocity) + spin.cross(arm)


@ti.func
def set_pose(obstacles: ti.template(), contact: ti.template(), level):
    """Set the records of the obstacles to row `level` of their motion."""
    count = obstacles.records.shape[0]
    for turn in range(turns(contact, count)):
        j = item(contact, turn)
        obstacles.records[j] = obstacles.motion[level * count + j]
    meet(contact)
