"""How thin a solid is whose distance is sampled on a grid: the depth of the shallowest place between opposite sides.

There the gradients of the distance at neighbouring nodes are opposite. At convex edges and corners of 90 degrees they
are at right angles, and no part of these counts as thin; an edge sharper than 60 degrees does.
"""

from __future__ import annotations

import numpy as np

OPPOSITE = -0.5  # cosine between two gradients
AT_ONCE = 1 << 20  # nodes


def half_thickness_of_grid(grid: np.ndarray, spacing: float) -> float:
    """Smallest depth [m] between opposite sides, at least half a spacing [m]; infinite where there is none.

    grid [nx, ny, nz, 4]: distance [m], negative inside, and its gradient.
    """
    slab = max(1, AT_ONCE // (grid.shape[1] * grid.shape[2]))
    least = min(_of_slab(grid, start, start + slab) for start in range(0, grid.shape[0], slab))
    return max(least, 0.5 * spacing)


def _of_slab(grid: np.ndarray, start: int, end: int) -> float:
    """Smallest depth [m] between opposite sides at the nodes start to end along x."""
    inside = np.argwhere(grid[start:end, ..., 0] < 0.0) + (start, 0, 0)
    depth = -grid[tuple(inside.T)][:, 0]
    least = np.inf
    for axis in range(3):
        for before, after in ((0, 1), (-1, 0), (-1, 1)):
            ends = []
            for offset in (before, after):
                place = inside.copy()
                place[:, axis] += offset
                ends.append(place)
            there = (ends[0][:, axis] >= 0) & (ends[1][:, axis] < grid.shape[axis])
            one, other = (grid[tuple(place[there].T)][:, 1:] for place in ends)
            lengths = np.linalg.norm(one, axis=1) * np.linalg.norm(other, axis=1)
            opposite = np.einsum("ni,ni->n", one, other) < OPPOSITE * lengths
            least = min(least, float(depth[there][opposite].min(initial=np.inf)))
    return least
