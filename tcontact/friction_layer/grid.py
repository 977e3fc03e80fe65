"""The grid of a layer and the constants of its heat equation for (grid, dt, metal) (METHOD 5)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base import validate
from ..base.errors import InputError
from .metals import Metal

THINNEST, THICKEST = 1e-12, 1e3  # [m], far beyond any layer


def depths(points: int, grading: float, thickness: float) -> np.ndarray:
    """Return the depths of the nodes [points] [m] with spacings in geometric progression; grading: last over first.

    Raises `InputError`.
    """
    validate.whole("points", points, 3, 10**5)
    grading = validate.number("grading", grading, low=1e-4, high=1e4, strict=False)
    thickness = validate.number("thickness", thickness, low=THINNEST, high=THICKEST)
    spacing = grading ** (np.arange(points - 1) / max(points - 2, 1))
    depth = np.concatenate([[0.0], np.cumsum(spacing)])
    depth *= thickness / depth[-1]
    if not np.all(np.diff(depth) > 0.0):
        raise InputError("grading", grading, "leaves neighbouring points at the same depth; take it nearer to 1")
    return depth


@dataclass(frozen=True)
class Column:
    """Constants of backward Euler on one side of the interface, all [points].

    weight: half-cell widths [m], the trapezoidal rule; gain, link, back: elimination (see
    kernels/layer/layer1d_phases);
    warmth: Bq, the rise of temperature per heat flux through the surface [K m^2/W].
    """

    depth: np.ndarray
    weight: np.ndarray
    gain: np.ndarray
    link: np.ndarray
    back: np.ndarray
    warmth: np.ndarray

    def table(self) -> np.ndarray:
        """Return the columns of the kernel, [points, 6]."""
        with np.errstate(divide="ignore", over="ignore"):
            room = np.minimum(1.0 / self.warmth, 1e300)
        return np.column_stack([self.weight, self.gain, self.link, self.back, self.warmth, room])


def half_cells(depth: np.ndarray) -> np.ndarray:
    """Return the widths [points] [m] of the nodes, the weights of the trapezoidal rule."""
    spacing = np.diff(depth)
    weight = np.zeros_like(depth)
    weight[:-1] += spacing / 2
    weight[1:] += spacing / 2
    return weight


def column(metal: Metal, depth: np.ndarray, dt: float, far_end: float = 0.0) -> Column:
    """Compute the constants for a time step dt [s]; far_end: conductance of the far end [W/(m^2 K)], 0: insulated.

    The pivots are sums of positive numbers only (the nodes below a node act on it as a capacity in series with a
    conductance), so they keep all digits for any dt.
    """
    spacing, weight = np.diff(depth), half_cells(depth)
    capacity = metal.volumetric_heat * weight / dt
    conductance = metal.conductivity / spacing  # between node i and i + 1
    count = len(depth)
    gain, link, back, warmth = (np.zeros(count) for _ in range(4))
    below = far_end  # effective capacity of the nodes below this one
    for i in range(count - 1, -1, -1):
        above = conductance[i - 1] if i > 0 else 0.0
        own = capacity[i] + below
        pivot = own + above
        gain[i] = capacity[i] / pivot
        link[i] = (conductance[i] if i < count - 1 else far_end) / pivot
        back[i] = above / pivot
        below = above * own / pivot
        if i == 0:
            warmth[0] = 1.0 / pivot
    for i in range(1, count):
        warmth[i] = back[i] * warmth[i - 1]
    return Column(depth, weight, gain, link, back, warmth)
