"""Compute winding numbers of a closed surface at the nodes of a grid: signed crossings of the ray upward.

Columns of nodes are cut by the triangles over them. The side of an edge a column passes is computed from the edge's
points in the same order for both its triangles, so no column slips through between them; columns stand a little off
the nodes, so none passes through an edge or a corner of a surface that lies on the grid. A column must enter as often
as it leaves.
"""

from __future__ import annotations

import numpy as np

SHIFTS = ((0.7548776662, 0.5698402910), (-0.3819660113, 0.8191725134), (0.2360679775, -0.6823278038))
ASIDE = 1e-6  # of the spacing
AT_ONCE = 1 << 20  # columns over triangles at once


def winding_numbers(
    points: np.ndarray, triangles: np.ndarray, origin: np.ndarray, spacing: float, count: tuple[int, int, int]
) -> np.ndarray | None:
    """Return winding numbers [nx, ny, nz] at the nodes of a grid; None where rounding spoiled each attempt."""
    scaled = (points - origin) / spacing  # nodes at whole numbers
    for shift in SHIFTS:
        steps = np.zeros((count[0], count[1], count[2] + 1), dtype=np.int64)
        for column, row, height, sign in _crossings(scaled - np.array([*shift, 0.0]) * ASIDE, triangles, count):
            # the crossing lies above the nodes before this one
            above = np.clip(np.ceil(height), 0, count[2]).astype(np.int64)
            np.add.at(steps, (column, row, above), sign)
        total = np.cumsum(steps[:, :, ::-1], axis=2)[:, :, ::-1]
        if not total[:, :, 0].any():
            return np.asarray(total[:, :, 1:])
    return None


def _crossings(points: np.ndarray, triangles: np.ndarray, count: tuple[int, int, int]):
    """Yield column, row, height and sense (+1 out of the solid, upward) of the crossings, in portions."""
    corner = points[triangles][:, :, :2]
    low = np.maximum(np.ceil(corner.min(axis=1)), 0).astype(np.int64)
    high = np.minimum(np.floor(corner.max(axis=1)), np.array(count[:2]) - 1).astype(np.int64)
    wide = np.maximum(high - low + 1, 0)
    over = wide[:, 0] * wide[:, 1]
    portion = np.cumsum(over) // AT_ONCE
    for number in np.unique(portion):
        members = np.flatnonzero((portion == number) & (over > 0))
        if not len(members):
            continue
        owner = np.repeat(members, over[members])
        within = np.arange(len(owner)) - np.repeat(np.cumsum(over[members]) - over[members], over[members])
        column = low[owner, 0] + within // wide[owner, 1]
        row = low[owner, 1] + within % wide[owner, 1]
        yield _hits(points, triangles[owner], column, row)


def _hits(
    points: np.ndarray, triangles: np.ndarray, column: np.ndarray, row: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    weights, left = [], []
    for i in range(3):
        start, end = triangles[:, (i + 1) % 3], triangles[:, (i + 2) % 3]
        a, b = points[np.minimum(start, end)], points[np.maximum(start, end)]
        area = (b[:, 0] - a[:, 0]) * (row - a[:, 1]) - (b[:, 1] - a[:, 1]) * (column - a[:, 0])
        weights.append(np.abs(area))
        left.append((area >= 0.0) == (start < end))
    same = (left[0] == left[1]) & (left[1] == left[2])
    weight = np.stack(weights, axis=1)[same]
    total = weight.sum(axis=1, keepdims=True)
    height = np.einsum("ni,ni->n", weight / np.where(total > 0.0, total, 1.0), points[triangles[same], 2])
    return column[same], row[same], height, np.where(left[0][same], 1, -1)
