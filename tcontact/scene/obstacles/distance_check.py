"""Check that the samples of a function are those of a signed distance: both signs, and slopes of length 1."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

from ...base.errors import InputError

NEAR = 1.5  # spacings from the surface within which slopes are looked at
SLOPE = 0.1  # difference of a slope from 1 that is not told
SHARE = 0.25  # of the nodes near the surface that may differ more, as at edges


def check_distance(distance: Any, grid: np.ndarray, spacing: float) -> None:
    """Raise `InputError` if a sampled distance has one sign alone; warn if it is no distance near its surface.

    grid [nx, ny, nz, 4]: values [m] and gradient at the nodes.
    """
    value = grid[..., 0]
    if not (value.min() < 0.0 < value.max()):
        side, wanted = ("outside", "inside") if value.max() > 0.0 else ("inside", "outside")
        remedy = f"all {value.size} nodes are {side} the solid, none is {wanted}; distances are positive outside: give"
        raise InputError("Sdf.distance", distance, f"{remedy} a box around the solid, or more cells")
    slope = np.linalg.norm(grid[..., 1:], axis=-1)
    slope = slope[np.abs(value) <= NEAR * spacing * np.maximum(slope, 1e-300)]
    if len(slope) and np.mean(np.abs(slope - 1.0) > SLOPE) > SHARE:
        low, middle, high = np.quantile(slope, (0.05, 0.5, 0.95))
        warnings.warn(
            f"Sdf.distance: near its surface the function has slopes of {low:.3g} to {high:.3g}, {middle:.3g} in the"
            " middle, where a distance has 1; gaps, and forces of a penalty, are wrong by that factor: divide it by the"
            " length of its gradient",
            RuntimeWarning,
            stacklevel=3,
        )
