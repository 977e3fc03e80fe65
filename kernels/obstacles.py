"""Gaps to rigid obstacles and their normals into the body: g_p(x) is the signed distance, open positive.

An obstacle is a record of RECORD numbers in `touching.obstacles`: shape, a reference point o of it, a frame Q (rows:
its own axes), parameters of the shape, velocity of o and angular velocity, now and as means over the step that led
here. Positions count from a point among the contact nodes, reference [k, 3] lists where these start: the gap keeps its
digits far from the origin. Where obstacles move, `touching.motion` holds a row of records per time level and `set_pose`
takes the next one; behind them stand the grids of sampled distances.
Only the shapes in `touching.kinds.shapes` are compiled.
"""

import taichi as ti

from .boundary_nodes import row
from .columns import OBSTACLE_LOAD, OBSTACLE_LOADS, loads_place
from .lanes import MOST_SLOTS, OBSTACLE
from .obstacle_shapes import box_gap_normal, grid_gap_normal

# places in a record
SHAPE, POINT, FRAME, PARAMETERS, VELOCITY, SPIN, MEAN_VELOCITY, MEAN_SPIN = 0, 1, 4, 13, 21, 24, 27, 30
RECORD = OBSTACLE
CODES = {"plane": 0, "sphere": 1, "cylinder": 2, "box": 3, "sdf": 4}


@ti.func
def vector(values: ti.template(), place):
    return ti.Vector([values[place + j] for j in ti.static(range(3))])


@ti.func
def gap_and_normal(touching: ti.template(), p, x):
    """Gap of a position to obstacle p, and the normal there."""
    values = ti.static(touching.obstacles)
    start = RECORD * p
    y = x - vector(values, start + POINT)
    gap = 1e300
    normal = vector(values, start + FRAME + 6)  # of a plane, axis of a cylinder
    shape = int(values[start + SHAPE])
    alone = ti.static(len(touching.kinds.shapes) == 1)
    if ti.static("plane" in touching.kinds.shapes):
        if alone or shape == 0:
            gap = normal.dot(y)
    if ti.static("sphere" in touching.kinds.shapes):
        if alone or shape == 1:
            gap, normal = round_gap(y, values[start + PARAMETERS], values[start + PARAMETERS + 1])
    if ti.static("cylinder" in touching.kinds.shapes):
        if alone or shape == 2:
            gap, normal = round_gap(
                y - normal.dot(y) * normal, values[start + PARAMETERS], values[start + PARAMETERS + 1]
            )
    if ti.static("box" in touching.kinds.shapes or "sdf" in touching.kinds.shapes):
        if shape == 3 or shape == 4:
            gap, normal = framed_gap(touching, start, shape, y)
    return gap, normal


@ti.func
def round_gap(y, radius, side):
    """Of a sphere about 0, or of a cylinder for the part of y across its axis; side = 1 outside, -1 inside."""
    length = y.norm()
    normal = ti.Vector([0.0, 0.0, 1.0])
    if length > 1e-12 * radius:
        normal = y / length
    return side * (length - radius), side * normal


@ti.func
def framed_gap(touching: ti.template(), start, shape, y):
    """Of shapes with axes of their own."""
    values = ti.static(touching.obstacles)
    place = start + PARAMETERS
    frame = ti.Matrix([[values[start + FRAME + 3 * i + j] for j in range(3)] for i in range(3)])
    own = frame @ y
    gap = 1e300
    normal = ti.Vector([0.0, 0.0, 1.0])
    if ti.static("box" in touching.kinds.shapes):
        if shape == 3:
            gap, normal = box_gap_normal(own, vector(values, place))
    if ti.static("sdf" in touching.kinds.shapes):
        if shape == 4:
            gap, normal = grid_gap_normal(
                touching.motion,
                ti.cast(values[place + 7], ti.i32),
                vector(values, place),
                values[place + 3],
                values[place + 4],
                values[place + 5],
                values[place + 6],
                own,
            )
    return gap, frame.transpose() @ normal


@ti.func
def velocity_at(touching: ti.template(), p, x, velocity: ti.template()):
    """Of the material point of obstacle p at x [m/s]; velocity: VELOCITY or MEAN_VELOCITY."""
    start = RECORD * p
    arm = x - vector(touching.obstacles, start + POINT)
    spin = vector(touching.obstacles, start + velocity + 3)
    return vector(touching.obstacles, start + velocity) + spin.cross(arm)


@ti.func
def set_pose(touching: ti.template(), level):
    """Put the obstacles where they are at row `level` of the motion."""
    count = touching.obstacles.shape[0]
    for j in range(count):
        touching.obstacles[j] = touching.motion[level * count + j]


@ti.func
def clear_loads(touching: ti.template()):
    for j in range(ti.static(loads_place(touching.kinds.friction != "")), touching.sums.shape[0]):
        touching.sums[j] = 0.0


@ti.func
def add_load(touching: ti.template(), p, x, force):
    """The force on a body at x, by obstacle p: the obstacle feels the opposite. The power is that into the bodies."""
    arm = x - vector(touching.obstacles, RECORD * p + POINT)
    moment = arm.cross(force)
    power = ti.static(loads_place(touching.kinds.friction != ""))
    pushed = power + 1 + OBSTACLE_LOADS * p + OBSTACLE_LOAD.obstacle_force
    turned = power + 1 + OBSTACLE_LOADS * p + OBSTACLE_LOAD.obstacle_moment
    for j in ti.static(range(3)):
        touching.sums[pushed + j] = touching.sums[pushed + j] - force[j]
        touching.sums[turned + j] = touching.sums[turned + j] - moment[j]
    touching.sums[power] = touching.sums[power] + force.dot(velocity_at(touching, p, x, VELOCITY))


@ti.func
def position(reference: ti.template(), k, u: ti.template(), node):
    return row(reference, k) + row(u, node)


@ti.func
def nearest_obstacles(touching: ti.template(), u: ti.template()):
    """near: the obstacles with the smallest gaps at each node, where there are more than slots for them.

    They stand in the order of the scene: obstacles out of reach leave the arithmetic of the others as it is. The order
    stays while they are the same: what a node knows of its obstacles stays with them.
    """
    count = touching.obstacles.shape[0] // RECORD
    if count > MOST_SLOTS:
        for k in range(touching.nodes.shape[0]):
            x = position(touching.reference, k, u, touching.nodes[k])
            found = ti.Vector([-1 for _ in range(MOST_SLOTS)])
            missing = 0
            for slot in ti.static(range(MOST_SLOTS)):
                best = 1e300
                for p in range(count):
                    g, _normal = gap_and_normal(touching, p, x)
                    taken = 0
                    for before in ti.static(range(slot)):
                        if found[before] == p:
                            taken = 1
                    if taken == 0 and g < best:
                        best = g
                        found[slot] = p
                known = 0
                for other in ti.static(range(MOST_SLOTS)):
                    if touching.near[MOST_SLOTS * k + other] == found[slot]:
                        known = 1
                missing += 1 - known
            for _, slot in ti.static(ti.ndrange(MOST_SLOTS - 1, MOST_SLOTS - 1)):
                first, second = found[slot], found[slot + 1]
                found[slot] = ti.min(first, second)
                found[slot + 1] = ti.max(first, second)
            if missing > 0:
                for slot in ti.static(range(MOST_SLOTS)):
                    touching.near[MOST_SLOTS * k + slot] = found[slot]


@ti.func
def smallest_gap(touching: ti.template(), u: ti.template()):
    """Smallest gap of the contact set to any obstacle."""
    least = 1e300
    for i in range(touching.all_nodes.shape[0]):
        x = position(touching.all_reference, i, u, touching.all_nodes[i])
        for p in range(touching.obstacles.shape[0] // RECORD):
            g, _normal = gap_and_normal(touching, p, x)
            least = ti.min(least, g)
    return least
