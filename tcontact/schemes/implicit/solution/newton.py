"""Newton's method with full steps, then with a line search; if both fail the caller halves the time step (METHOD 4)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ....base.stages import detail
from .linear_solver import Direct, Krylov, NoSolution

FLOOR = 1e-8  # a residual that stops falling counts as rounding below this share of the forces
GROWN = 1e8  # over the first residual: diverged
HALVINGS = 8
FAILED = NoSolution, np.linalg.LinAlgError  # what an iterate far from the solution can raise; a smaller step may not


class NotConverged(ArithmeticError):
    """Newton's method did not reach the tolerance."""


class Equations(Protocol):
    """Residual and tangent of a step."""

    def evaluate(self, d: np.ndarray) -> tuple[np.ndarray, float]:
        """Return the residual [n, 3] [N] at the increment d [n, 3] [m] and the size of the forces in it [N]."""

    def tangent(self, d: np.ndarray) -> np.ndarray:
        """Return the derivative of the residual at d, as blocks [b, 3, 3] [N/m]."""


@dataclass(frozen=True)
class Settings:
    """Settings: rtol: residual over forces; iterations: maximum number; verbose: log every residual."""

    rtol: float = 1e-12
    iterations: int = 15
    verbose: bool = False


@dataclass(frozen=True)
class Solution:
    """The increment, the number of linear systems solved, and the largest residual over the size of the forces."""

    d: np.ndarray
    iterations: int
    residual: float


def newton(equations: Equations, start: np.ndarray, solver: Direct | Krylov, settings: Settings) -> Solution:
    """Solve from `start` with full steps, then with a line search. Raises `NotConverged`."""
    with np.errstate(all="ignore"):  # an overflow fails the test of the residual
        try:
            return _iterate(equations, start, solver, settings, False)
        except (NotConverged, *FAILED):
            try:
                return _iterate(equations, start, solver, settings, True)
            except FAILED as error:
                raise NotConverged(str(error)) from error


def _iterate(
    equations: Equations, start: np.ndarray, solver: Direct | Krylov, settings: Settings, search: bool
) -> Solution:
    d = start.copy()
    residual, scale = equations.evaluate(d)
    size = before = first = float(np.abs(residual).max())
    for iteration in range(2 * settings.iterations if search else settings.iterations):
        if settings.verbose:
            detail(f"newton {iteration}: residual {size / max(scale, 1e-300):.3e}")
        stuck = iteration > 2 and size > 0.5 * before and size <= FLOOR * scale
        if size <= settings.rtol * scale or stuck:
            return Solution(d, iteration, size / max(scale, 1e-300))
        goal = 0.01 * settings.rtol * scale / size
        forcing = max(goal, min(1e-3, 0.01 * (size / before) ** 2)) if iteration else max(goal, 1e-3)
        step = solver.solve(equations.tangent(d), -residual, forcing)
        before, share = size, 1.0
        for _ in range(HALVINGS if search else 1):
            residual, here = equations.evaluate(d + share * step)
            size = float(np.abs(residual).max())
            if size < before or not search:
                break
            share *= 0.5
        d, scale = d + share * step, here
        if not np.isfinite(size) or size > GROWN * max(first, scale):
            raise NotConverged("the iteration diverged")
    if size <= settings.rtol * scale or 0.5 * before < size <= FLOOR * scale:
        return Solution(d, iteration + 1, size / scale)
    raise NotConverged(f"a residual of {size / max(scale, 1e-300):.1e} of the forces is left")
