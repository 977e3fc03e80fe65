"""The camera, and its place once it is known what must be visible."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...base.errors import InputError
from ...scene.obstacles.base import direction as unit_of
from .triangles import Triangles

PARALLEL = 1e-9  # sine of the angle below which two directions count as one


@dataclass(frozen=True)
class Camera:
    """The view of a picture: `direction` points from the body to the eye, `up` is upward on the picture (any length).

    The distance follows from what must be visible. Raises `InputError` for directions that are zero or parallel.
    """

    direction: tuple[float, float, float]
    up: tuple[float, float, float] = (0.0, 0.0, 1.0)

    def __post_init__(self) -> None:
        remedy = "give three finite numbers that are not all zero"
        ways = [unit_of(f"Camera.{name}", getattr(self, name), remedy) for name in ("direction", "up")]
        if np.linalg.norm(np.cross(ways[0], ways[1])) < PARALLEL:
            raise InputError("Camera.up", self.up, f"must not be parallel to the direction {self.direction}")


@dataclass(frozen=True)
class Eye:
    """A placed camera: position [m], `axes` right, up, back, focal length and centre [pixel]; `fixed`: the scenery."""

    position: np.ndarray
    axes: np.ndarray
    focal: float
    centre: tuple[float, float]
    fixed: Triangles
    shadow: tuple[np.ndarray, np.ndarray] | None  # point and normal of the plane that catches the shadow
    moving: Callable[[Eye, float], Eye] | None = None  # this eye with the scenery of a time [s]

    def at(self, time: float) -> Eye:
        """Return the eye with the obstacles where they are at a time [s]."""
        return self if self.moving is None else self.moving(self, time)

    def project(self, points: np.ndarray) -> np.ndarray:
        """Project points [n,3] to columns x, y [pixel], inverse depth [1/m]; NaN behind the eye."""
        right, up, back = ((points - self.position) @ self.axes.T).T
        inverse = 1.0 / np.where(back < 0, -back, np.nan)
        return np.stack(
            [self.centre[0] + self.focal * right * inverse, self.centre[1] - self.focal * up * inverse, inverse], 1
        )


def fitted(points: np.ndarray, slope_x: float, slope_y: float) -> np.ndarray:
    """Return the nearest eye, in camera axes, from which all points [n,3] (same axes) lie within the slopes."""
    x, y, z = points.T
    distances, centres = [], []
    for across, slope in ((x, slope_x), (y, slope_y)):
        one, other = (across + slope * z).max(), (-across + slope * z).max()
        distances.append((one + other) / (2 * slope))
        centres.append((one - other) / 2)
    return np.array([*centres, max(*distances, z.max() + 1e-9 + 1e-3 * np.ptp(points, axis=0).max())])
