"""The rigid circular cylinder without ends, in contact from outside or from within."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ...base import validate
from .base import Obstacle, axes_around, direction, flag, unit_or


@dataclass(frozen=True, eq=False)
class Cylinder(Obstacle):
    """A rigid cylinder of infinite length, or with inside=True a rigid tube around the bodies.

    point: any point of its axis [m], the one it turns about; axis: its direction, any length but zero (stored as a
    unit vector); radius: [m] > 0. inertia: three moments are about its own axes through `point`, two across its axis
    and then the one about it; a number stands for all three. Raises `InputError`.
    """

    point: Any = (0.0, 0.0, 0.0)
    axis: Any = (0.0, 0.0, 1.0)
    radius: float = 1.0
    inside: bool = False
    shape: ClassVar[str] = "cylinder"

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "point", validate.vector("Cylinder.point", self.point))
        remedy = "give a direction of non-zero length, along the axis"
        object.__setattr__(self, "axis", direction("Cylinder.axis", self.axis, remedy))
        object.__setattr__(self, "radius", validate.number("Cylinder.radius", self.radius, low=0.0))
        flag("Cylinder.inside", self.inside)
        if self.free:
            self.inertia_about_center()

    @property
    def reference(self) -> np.ndarray:
        """The point given [3] [m]."""
        return np.asarray(self.point)

    @property
    def frame(self) -> np.ndarray:
        """Local axes [3, 3] in rows; the third is the axis."""
        return axes_around(self.axis)

    @property
    def parameters(self) -> tuple[float, ...]:
        """Radius [m]; 1, or -1 for a tube."""
        return float(self.radius), -1.0 if self.inside else 1.0

    def local(self, positions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return gap [n] [m] and unit normal [n, 3] at local coordinates [n, 3]."""
        radius, side = self.parameters
        across = positions * np.array([1.0, 1.0, 0.0])
        length, outward = unit_or(across, np.array([1.0, 0.0, 0.0]))
        return side * (length - radius), side * outward
