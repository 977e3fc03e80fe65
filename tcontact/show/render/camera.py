"""The camera, and its place once it is known what must be visible."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...base.errors import InputError
from ...scene.obstacles.base import direction as unit_of
from .triangles import Triangles

THIN = 0.2  # thickness over width below which a body is seen from its broad side
BROAD = 0.55  # sine of the angle to a thin body from which on it is not seen edge-on
PARALLEL = 1e-9  # sine of the angle below which two directions count as one


@dataclass(frozen=True)
class Camera:
    """The view of a picture: `direction` points from the body to the eye, `up` is upward on the picture (any length).

    up: None = z, or y for a look along z. The distance follows from what must be visible. Raises `InputError` for
    directions that are zero or parallel.
    """

    direction: tuple[float, float, float]
    up: tuple[float, float, float] | None = None

    def __post_init__(self) -> None:
        remedy = "give three finite numbers that are not all zero"
        back = unit_of("Camera.direction", self.direction, remedy)
        if self.up is None:
            along = np.hypot(back[0], back[1]) < PARALLEL
            object.__setattr__(self, "up", (0.0, 1.0, 0.0) if along else (0.0, 0.0, 1.0))
        elif np.linalg.norm(np.cross(back, unit_of("Camera.up", self.up, remedy))) < PARALLEL:
            raise InputError("Camera.up", self.up, f"must not be parallel to the direction {self.direction}")


class Signs(NamedTuple):
    """The names of obstacles, the triangles on the screen that each may stand on, and points of the bodies there."""

    names: tuple[str, ...]
    places: tuple[Triangles, ...]
    bodies: np.ndarray


@dataclass(frozen=True)
class Eye:
    """A placed camera: position [m], `axes` right, up, back, focal length and centre [pixel]; `fixed`: the scenery.

    distance [m]: to the middle of the bodies, where the scale bar holds; 0 for a picture without one.
    """

    position: np.ndarray
    axes: np.ndarray
    focal: float
    centre: tuple[float, float]
    fixed: Triangles
    shadow: tuple[np.ndarray, np.ndarray] | None  # point and normal of the plane that catches the shadow
    moving: Callable[[Eye, float], Eye] | None = None  # this eye with the scenery of a time [s]
    distance: float = 0.0
    signs: Signs | None = None

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


def thin_normals(bodies: Sequence[np.ndarray]) -> np.ndarray:
    """Return the normals [k, 3] of those bodies, given by points [n, 3] each, that are flat and thin as a plate is."""
    found = []
    for points in bodies:
        if not np.isfinite(points).all():
            continue
        ways = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2]
        widths = np.ptp(points @ ways.T, axis=0)
        if len(widths) == 3 and widths[2] < THIN * widths[1]:
            found.append(ways[2])
    return np.array(found).reshape(-1, 3)


def usual_direction(
    view: str, up: np.ndarray, walls: Sequence[np.ndarray], sides: Sequence[np.ndarray], plates: np.ndarray
) -> np.ndarray:
    """Return the direction [3] to the eye in a three-quarter view from "above" or "below".

    Of the turns around `up` it is the first that shows most: walls by their fronts, given by their normals, cuts by
    their open sides, thin plates by their broad sides.
    """
    first = np.eye(3)[np.argmin(np.abs(up))]
    first = first - up * (first @ up)
    first /= np.linalg.norm(first)
    second = np.cross(up, first)
    turns = np.radians((-60 if view == "above" else -76) + 30 * np.arange(12))
    around = [math.cos(turn) * first + math.sin(turn) * second for turn in turns]
    rises = np.radians((20, 35, 50) if view == "above" else (-58,))
    ways = [math.cos(rise) * way + math.sin(rise) * up for rise in rises for way in around]

    def shown(way: np.ndarray) -> float:
        fronts = sum(float(wall @ way > 0.05) for wall in walls)
        opened = sum(min(0.5, float(side @ way)) for side in sides)
        broad = sum(min(BROAD, abs(float(plate @ way))) for plate in plates)
        return fronts + opened + broad / max(1, len(plates))

    return max(ways, key=shown)


def fitted(points: np.ndarray, slope_x: float, slope_y: float) -> np.ndarray:
    """Return the nearest eye, in camera axes, from which all points [n,3] (same axes) lie within the slopes."""
    x, y, z = points.T
    distances, centres = [], []
    for across, slope in ((x, slope_x), (y, slope_y)):
        one, other = (across + slope * z).max(), (-across + slope * z).max()
        distances.append((one + other) / (2 * slope))
        centres.append((one - other) / 2)
    return np.array([*centres, max(*distances, z.max() + 1e-9 + 1e-3 * np.ptp(points, axis=0).max())])
