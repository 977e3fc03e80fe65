"""HHT-alpha scheme (Hilber, Hughes and Taylor, Earthquake Eng. Struct. Dyn. 5, 283, 1977), -1/3 <= alpha <= 0.

M a1 + (1 + alpha) f(x1) - alpha f(x0) = f_ext, contact alike (exact contact: lambda nu(x0 + (1 + alpha) d)),
x1 = x0 + dt v0 + dt^2 [(1/2 - beta) a0 + beta a1],   v1 = v0 + dt [(1 - gamma) a0 + gamma a1],
beta = (1 - alpha)^2/4,  gamma = (1 - 2 alpha)/2:     dissipates high frequencies, second order
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...base import validate
from .scheme import ImplicitScheme


@dataclass(frozen=True)
class HilberHughesTaylor(ImplicitScheme):
    """HHT scheme, alpha from 0 (Newmark's trapezoidal rule) to -1/3 (maximum dissipation). Others: `ImplicitScheme`."""

    alpha: float = -0.1

    name: ClassVar[str] = "hilber-hughes-taylor"
    dissipates: ClassVar[bool] = True
    conserves: ClassVar[tuple[str, ...]] = ("linear momentum",)

    def __post_init__(self) -> None:
        super().__post_init__()
        validate.keep(self, "alpha", low=-1.0 / 3.0, high=0.0, strict=False)

    @property
    def beta(self) -> float:
        """Newmark's beta."""
        return 0.25 * (1.0 - self.alpha) ** 2

    @property
    def gamma(self) -> float:
        """Newmark's gamma."""
        return 0.5 - self.alpha

    @property
    def present(self) -> float:
        """Weight of the force at x1."""
        return 1.0 + self.alpha

    @property
    def past(self) -> float:
        """Weight of the force at x0."""
        return -self.alpha

    @property
    def blend(self) -> float:
        """Share of the new acceleration in v1 - v0."""
        return self.gamma

    def inertia(self, dt: float, v0: np.ndarray, a0: np.ndarray) -> tuple[float, np.ndarray]:
        """Return c and b of the acceleration a1 = c d - b."""
        return 1.0 / (self.beta * dt * dt), v0 / (self.beta * dt) + (0.5 / self.beta - 1.0) * a0

    def motion(self, dt: float, d: np.ndarray, v0: np.ndarray, a0: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return velocity and acceleration of Newmark's formulas."""
        factor, known = self.inertia(dt, v0, a0)
        a1 = factor * d - known
        return v0 + dt * ((1.0 - self.gamma) * a0 + self.gamma * a1), a1
