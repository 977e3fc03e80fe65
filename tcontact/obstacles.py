"""Rigid obstacles. The gap is the signed distance to them, open positive; the normal points into the body."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from . import validate
from .errors import InputError


@dataclass(frozen=True, eq=False)
class Plane:
    """A rigid half-space.

    point: any point of its surface [m]; normal: from the obstacle into the body, any length but zero (stored as a
    unit vector). Raises `InputError` for a zero or non-finite normal.
    """

    point: Any = (0.0, 0.0, 0.0)
    normal: Any = (0.0, 0.0, 1.0)
    name: str | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "point", validate.vector("Plane.point", self.point))
        normal = validate.vector("Plane.normal", self.normal)
        length = float(np.linalg.norm(normal))
        if length == 0.0:
            raise InputError(
                "Plane.normal", self.normal, "give a direction of non-zero length, from the wall into the body"
            )
        unit = normal / length
        unit.setflags(write=False)
        object.__setattr__(self, "normal", unit)
        if self.name is not None and not isinstance(self.name, str):
            raise InputError("Plane.name", self.name, "give a string or None")

    def project(self, position: np.ndarray) -> np.ndarray:
        """The point [3] of the plane nearest to a position [3] [m]."""
        return np.asarray(position - ((position - self.point) @ self.normal) * self.normal)

    def gap(self, positions: np.ndarray) -> np.ndarray:
        """Signed distance [m] of positions [n, 3], open positive."""
        return np.asarray((positions - self.point) @ self.normal)
