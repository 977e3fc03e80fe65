"""Trapezoidal rule: f* = (f(x0) + f(x1))/2, contact alike. Stable for linear bodies only (paper 3.1)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from .scheme import ImplicitScheme


@dataclass(frozen=True)
class Trapezoidal(ImplicitScheme):
    """The scheme f* = (f(x0) + f(x1))/2, fc* = (fc(x0) + fc(x1))/2; second order. Options: `ImplicitScheme`.

    Exact contact has one force for the step, along the mean normal of the step (nu* of METHOD 4).
    """

    name: ClassVar[str] = "trapezoidal"
    conserves: ClassVar[tuple[str, ...]] = ("linear momentum",)

    @property
    def present(self) -> float:
        """Weight 1/2 of the force at x1."""
        return 0.5

    @property
    def past(self) -> float:
        """Weight 1/2 of the force at x0."""
        return 0.5
