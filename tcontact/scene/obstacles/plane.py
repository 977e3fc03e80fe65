"""The rigid half-space."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ...base import validate
from .base import Obstacle, axes_around, direction


@dataclass(frozen=True, eq=False)
class Plane(Obstacle):
    """A rigid half-space.

    point: any point of its surface [m], the one it turns about; normal: from the obstacle into the body, any length
    but zero (stored as a unit vector). inertia: three moments are about its own axes through `point`, two along the
    surface and then the one about its normal. Raises `InputError` for a zero or non-finite normal.
    """

    point: Any = (0.0, 0.0, 0.0)
    normal: Any = (0.0, 0.0, 1.0)
    shape: ClassVar[str] = "plane"

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "point", validate.vector("Plane.point", self.point))
        remedy = "give a direction of non-zero length, from the wall into the body"
        object.__setattr__(self, "normal", direction("Plane.normal", self.normal, remedy))
        if self.free:
            self.inertia_about_center()

    @property
    def reference(self) -> np.ndarray:
        """The point given [3] [m]."""
        return np.asarray(self.point)

    @property
    def frame(self) -> np.ndarray:
        """Local axes [3, 3] in rows; the third is the normal."""
        return axes_around(self.normal)

    def local(self, positions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return gap [n] [m] and unit normal [n, 3] at local coordinates [n, 3]."""
        return positions[:, 2], np.tile((0.0, 0.0, 1.0), (len(positions), 1))

    def gap(self, positions: np.ndarray) -> np.ndarray:
        """Return the signed distance [n] [m] of positions [n, 3] at t = 0, open positive."""
        return np.asarray((positions - self.point) @ self.normal)

    def normal_at(self, positions: np.ndarray) -> np.ndarray:
        """Return the normal for each position [n, 3]."""
        return np.tile(self.normal, (len(positions), 1))
