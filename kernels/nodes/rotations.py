"""Rotations as unit quaternions (w, x, y, z), whose matrices stay orthogonal to rounding over any number of steps."""

from ..engine import ti


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
