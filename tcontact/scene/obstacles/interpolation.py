"""Interpolate a sampled distance trilinearly, and linearly beyond the grid.

D(y) = D(c) + grad D(c) . (y - c) with c the point of the grid nearest to y: exact for a plane, and a lower bound of
the distance to a convex body. For a body within the grid it grows outward, since grad D(c) . (y - c) > 0 there.
"""

from __future__ import annotations

from itertools import product

import numpy as np


def interpolate(
    grid: np.ndarray, origin: np.ndarray, spacing: float, positions: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return distance [n] [m] and gradient [n, 3] at positions [n, 3], in the axes of the grid [nx, ny, nz, 4]."""
    count = np.array(grid.shape[:3])
    scaled = np.clip((positions - origin) / spacing, 0.0, count - 1.0)
    cell = np.clip(np.nan_to_num(scaled), 0.0, count - 2.0).astype(np.int64)
    part = scaled - cell
    value = np.zeros((len(positions), 4))
    for corner in product((0, 1), repeat=3):
        weight = np.prod(np.where(corner, part, 1.0 - part), axis=1)
        value += weight[:, None] * grid[tuple((cell + corner).T)]
    beyond = positions - (origin + spacing * scaled)
    # rounding of the nearest point within the grid is not a step out of it
    outside = ((positions - origin) / spacing != scaled).any(axis=1)
    distance = value[:, 0] + np.where(outside, np.einsum("ni,ni->n", value[:, 1:], beyond), 0.0)
    return distance, value[:, 1:]
