"""Obstacles over a step: gaps at both ends and a normal whose work is the change of the gap, nu*.dx = dg (METHOD 4).

    plane             nu* = nu
    sphere, cylinder  nu* = (y0 + y1)/(|y0| + |y1|), y = x - centre without its part along the axis: no torque about it
    any other         nu* = nu(x_m) + [dg - nu(x_m).dx] dx/(dx.dx), dropped for tiny dx

Derivatives of gap and normal of the last kind are central differences. A sampled distance takes them from its cubic
interpolation, and its normal is the gradient of that: with the kinks of the trilinear gap of the explicit steps,
[...]/|dx| above would not vanish with dx.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ....scene.obstacles.cubic import smooth_distance

TINY = 1e-9  # |dx| over the size of the body below which the last normal is not corrected


@dataclass(frozen=True)
class Passage:
    """Passage of nodes [k] at one obstacle over a step.

    Gaps before and after [k] [m], gradient of the second one [k, 3], normal [k, 3] of the step and its derivative
    [k, 3, 3] with the position after.
    """

    before: np.ndarray
    after: np.ndarray
    gradient: np.ndarray
    normal: np.ndarray
    turning: np.ndarray


class Surface:
    """An obstacle at rest."""

    def __init__(self, obstacle: Any) -> None:
        self.obstacle = obstacle

    def gap(self, x: np.ndarray) -> np.ndarray:
        """Return the gaps [k] [m] at x [k, 3]."""
        return np.asarray(self.obstacle.gap(x))


class Flat(Surface):
    """A plane."""

    def at(self, x: np.ndarray) -> Passage:
        """Return the passage of nodes at rest at x [k, 3]."""
        gap, normal = self.obstacle.gap(x), np.tile(self.obstacle.normal, (len(x), 1))
        return Passage(gap, gap, normal, normal, np.zeros((len(x), 3, 3)))

    def passage(self, x0: np.ndarray, x1: np.ndarray) -> Passage:
        """Return the passage from x0 to x1, both [k, 3]."""
        return replace(self.at(x1), before=self.obstacle.gap(x0))


class Round(Surface):
    """A sphere or a cylinder, in contact from outside or from within."""

    def __init__(self, obstacle: Any) -> None:
        super().__init__(obstacle)
        self.side = -1.0 if obstacle.inside else 1.0
        self.across = np.eye(3)
        if obstacle.shape == "cylinder":
            self.across = np.eye(3) - np.outer(obstacle.axis, obstacle.axis)

    def _arm(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        y = (x - self.obstacle.reference) @ self.across
        return y, np.maximum(np.linalg.norm(y, axis=1), 1e-300)

    def at(self, x: np.ndarray) -> Passage:
        """Return the passage of nodes at rest at x [k, 3]."""
        y, length = self._arm(x)
        unit = y / length[:, None]
        turning = (self.across - unit[:, :, None] * unit[:, None, :]) / length[:, None, None]
        gap, normal = self.side * (length - self.obstacle.radius), self.side * unit
        return Passage(gap, gap, normal, normal, self.side * turning)

    def passage(self, x0: np.ndarray, x1: np.ndarray) -> Passage:
        """Return the passage from x0 to x1, both [k, 3]."""
        y0, r0 = self._arm(x0)
        y1, r1 = self._arm(x1)
        both = r0 + r1
        unit = (y0 + y1) / both[:, None]
        turning = (self.across - unit[:, :, None] * (y1 / r1[:, None])[:, None, :]) / both[:, None, None]
        radius = self.obstacle.radius
        gaps = self.side * (r0 - radius), self.side * (r1 - radius)
        return Passage(*gaps, self.side * y1 / r1[:, None], self.side * unit, self.side * turning)


class Curved(Surface):
    """Any obstacle with `gap` and `normal_at`; size [m]: size of the body, for the steps of the differences."""

    def __init__(self, obstacle: Any, size: float) -> None:
        super().__init__(obstacle)
        self.size = size

    def _differences(self, function: Any, x: np.ndarray) -> np.ndarray:
        step = 1e-5 * self.size
        columns = []
        for axis in range(3):
            off = step * np.eye(3)[axis]
            columns.append((function(x + off) - function(x - off)) / (2.0 * step))
        return np.stack(columns, axis=-1)

    def end(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the gap [k] and its gradient [k, 3], which equals the normal but for rounding."""
        return self.gap(x), self._differences(self.obstacle.gap, x)

    def normal(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the normal [k, 3] and its derivative [k, 3, 3]."""
        return self.obstacle.normal_at(x), self._differences(self.obstacle.normal_at, x)

    def at(self, x: np.ndarray) -> Passage:
        """Return the passage of nodes at rest at x [k, 3]."""
        gap, gradient = self.end(x)
        return Passage(gap, gap, gradient, *self.normal(x))

    def passage(self, x0: np.ndarray, x1: np.ndarray) -> Passage:
        """Return the passage from x0 to x1, both [k, 3]."""
        before, (after, gradient) = self.gap(x0), self.end(x1)
        middle, dx = 0.5 * (x0 + x1), x1 - x0
        normal, turning = self.normal(middle)
        turning = 0.5 * turning
        square = np.einsum("ki,ki->k", dx, dx)
        moved = square > (TINY * self.size) ** 2
        square = np.where(moved, square, 1.0)
        share = np.where(moved, (after - before - np.einsum("ki,ki->k", normal, dx)) / square, 0.0)
        slope = gradient - normal - np.einsum("kij,ki->kj", turning, dx) - 2.0 * share[:, None] * dx
        slope = np.where(moved[:, None], slope / square[:, None], 0.0)
        turning = turning + dx[:, :, None] * slope[:, None, :] + share[:, None, None] * np.eye(3)
        return Passage(before, after, gradient, normal + share[:, None] * dx, turning)


class Sampled(Curved):
    """A sampled distance, interpolated smoothly, so that normals (of the length of grad g) turn without jumps."""

    def _smooth(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        obstacle = self.obstacle
        return smooth_distance(obstacle.grid[..., 0], obstacle.origin, obstacle.spacing, x)

    def gap(self, x: np.ndarray) -> np.ndarray:
        """Return the gaps [k] [m] at x [k, 3]."""
        return self._smooth(x)[0]

    def end(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the gap [k] and its gradient [k, 3]."""
        return self._smooth(x)[:2]

    def normal(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the normal [k, 3] and its derivative [k, 3, 3]."""
        return self._smooth(x)[1:]


def surface_of(obstacle: Any, size: float) -> Flat | Round | Curved:
    """Make the surface of an obstacle for implicit steps; size [m]: size of the body."""
    if obstacle.shape == "plane":
        return Flat(obstacle)
    if obstacle.shape in ("sphere", "cylinder"):
        return Round(obstacle)
    if obstacle.shape == "sdf":
        return Sampled(obstacle, size)
    return Curved(obstacle, size)
