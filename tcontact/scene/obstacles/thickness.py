"""Measure the thickness of a solid given by sampled distances: the smallest depth between opposite sides.

There a node is as deep as both its neighbours along an axis or deeper, and their gradients are opposite. At convex
edges and corners of 90 degrees they are at right angles, and no part of these counts as thin; an edge sharper than 60
degrees does.
"""

from __future__ import annotations

import numpy as np

OPPOSITE = -0.5  # cosine between two gradients


def half_thickness_of_grid(grid: np.ndarray, spacing: float) -> float:
    """Return the smallest depth [m] between opposite sides, at least half a spacing [m]; infinite where there is none.

    grid [nx, ny, nz, 4]: distance [m], negative inside, and its gradient.
    """
    smallest = np.inf
    for axis in range(3):
        along = np.moveaxis(grid, axis, 0)
        distance = along[..., 0]
        deepest = (distance[1:-1] < 0.0) & (distance[1:-1] <= distance[:-2]) & (distance[1:-1] <= distance[2:])
        node, *across = np.nonzero(deepest)
        places = [(node + offset, *across) for offset in (0, 1, 2)]
        depth, before, after = -distance[places[1]], along[places[0]][:, 1:], along[places[2]][:, 1:]
        lengths = np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1)
        opposite = np.einsum("ni,ni->n", before, after) < OPPOSITE * lengths
        smallest = min(smallest, float(depth[opposite].min(initial=np.inf)))
    return max(smallest, 0.5 * spacing)
