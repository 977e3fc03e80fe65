"""Midpoint rule: f* = f((x0 + x1)/2), contact alike. It keeps momenta, energy to second order only (paper 3.1)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from .scheme import ImplicitScheme


@dataclass(frozen=True)
class Midpoint(ImplicitScheme):
    """The scheme f* = f(x_m), fc* = fc(x_m), x_m = (x0 + x1)/2; second order. Options: `ImplicitScheme`.

    Exact contact closes gaps at x1; its force is along the mean normal of the step (nu* of METHOD 4).
    """

    name: ClassVar[str] = "midpoint"
    level: ClassVar[float] = 0.5
