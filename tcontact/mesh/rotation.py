"""Rotation matrices from the forms that a user may give."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.errors import InputError
from ..base.validate import floats, number, vector
from .geometry import FloatArray


def rotation_matrix(rotation: Any) -> FloatArray:
    """Return the rotation matrix [3, 3] from a matrix or from (axis, angle [rad]) by Rodrigues' formula.

    Raises `InputError` for a zero axis and for a matrix that stretches, shears or mirrors.
    """
    if isinstance(rotation, (tuple, list)) and len(rotation) == 2:
        axis = vector("rotation axis", rotation[0])
        angle = number("rotation angle", rotation[1])
        largest = float(np.abs(axis).max())
        if largest == 0.0:
            raise InputError("rotation axis", rotation[0], "give a direction that is not zero")
        unit = axis / largest
        unit /= np.linalg.norm(unit)
        x, y, z = unit
        cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        return np.eye(3) + np.sin(angle) * cross + 2.0 * np.sin(angle / 2.0) ** 2 * (cross @ cross)
    matrix = floats("rotation", rotation, (3, 3))
    with np.errstate(over="ignore", invalid="ignore"):
        proper = np.allclose(matrix @ matrix.T, np.eye(3), rtol=0.0, atol=1e-9) and np.linalg.det(matrix) > 0.0
    if not proper:
        raise InputError("rotation", rotation, "give an orthonormal matrix with determinant +1, or (axis, angle)")
    return matrix
