"""The rigid sphere, in contact from outside or from within."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ...base import validate
from .base import Obstacle, flag, unit_or


@dataclass(frozen=True, eq=False)
class Sphere(Obstacle):
    """A rigid ball, or with inside=True a rigid shell around the bodies.

    center: [m], the point it turns about; radius: [m] > 0. Raises `InputError`.
    """

    center: Any = (0.0, 0.0, 0.0)
    radius: float = 1.0
    inside: bool = False
    shape: ClassVar[str] = "sphere"

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "center", validate.vector("Sphere.center", self.center))
        object.__setattr__(self, "radius", validate.number("Sphere.radius", self.radius, low=0.0))
        flag("Sphere.inside", self.inside)
        if self.free:
            self.inertia_about_center()

    def solid_inertia(self) -> float | None:
        """Return 2/5 m r^2 of the ball; None for a shell."""
        return None if self.inside or self.mass is None else 0.4 * self.mass * self.radius * self.radius

    @property
    def reference(self) -> np.ndarray:
        """The centre [3] [m]."""
        return np.asarray(self.center)

    @property
    def parameters(self) -> tuple[float, ...]:
        """Radius [m]; 1, or -1 for a shell."""
        return float(self.radius), -1.0 if self.inside else 1.0

    def local(self, positions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return gap [n] [m] and unit normal [n, 3] at local coordinates [n, 3]."""
        radius, side = self.parameters
        length, outward = unit_or(positions, np.array([0.0, 0.0, 1.0]))
        return side * (length - radius), side * outward
