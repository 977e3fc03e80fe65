"""Find the pairs of faces that may come together: boxes in a uniform hash grid.

The boxes of the masters' faces, larger by reach and margin, are entered into the cells of the grid that they touch;
every face of the slave looks into the cells of its own box. The list stays valid until the surfaces have moved by half
the margin against each other; an empty one longer, where the surfaces are further apart.
"""

from __future__ import annotations

import numpy as np

from ...mesh.triangle_distance import boxes_of
from ...scene.meeting import FACING
from .surfaces import Facing, area_vectors

CELL = 1.5  # edge of a grid cell over the longest edge of any box
MAXIMUM_CELLS = 1 << 20  # of the grid along an axis


def close_faces(facing: Facing, positions: np.ndarray) -> np.ndarray:
    """Return the pairs [p, 2] of a slave face and a master face that may meet, by slave face, then by master face."""
    slave, masters = positions[facing.slave.faces], positions[facing.master_faces]
    inflated = facing.reach + facing.margin
    (own_low, own_high), (low, high) = boxes_of(slave), boxes_of(masters)
    low, high = low - inflated, high + inflated
    near = ((own_high >= low.min(axis=0)) & (own_low <= high.max(axis=0))).all(axis=1)
    there = ((high >= own_low.min(axis=0)) & (low <= own_high.max(axis=0))).all(axis=1)
    mine, theirs = np.flatnonzero(near), np.flatnonzero(there)
    if not len(mine) or not len(theirs):
        return np.zeros((0, 2), dtype=np.int64)
    first, second = _same_cell(own_low[mine], own_high[mine], low[theirs], high[theirs])
    first, second = mine[first], theirs[second]
    meet = ((own_high[first] >= low[second]) & (own_low[first] <= high[second])).all(axis=1)
    count = len(masters)
    first, second = np.divmod(np.unique(first[meet] * count + second[meet]), count)
    normals = [area_vectors(positions, faces) for faces in (facing.slave.faces, facing.master_faces)]
    sizes = [np.linalg.norm(part, axis=1) for part in normals]
    cosine = np.einsum("ij,ij->i", normals[0][first], normals[1][second]) / (sizes[0][first] * sizes[1][second])
    return np.stack([first, second], axis=1)[cosine < FACING]


def apart(facing: Facing, positions: np.ndarray) -> float:
    """Return the largest distance [m] along an axis of the boxes of both surfaces; below 0: they overlap."""
    slave, masters = positions[facing.slave.nodes], positions[facing.master_faces].reshape(-1, 3)
    between = masters.min(axis=0) - slave.max(axis=0), slave.min(axis=0) - masters.max(axis=0)
    return float(np.max(between))


def _same_cell(
    low: np.ndarray, high: np.ndarray, other_low: np.ndarray, other_high: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the pairs of boxes that share a cell of the grid, once for every cell."""
    edge = CELL * max(float((high - low).max()), float((other_high - other_low).max()), 1e-300)
    origin = np.minimum(low.min(axis=0), other_low.min(axis=0))
    boxes, cells = _cells(low - origin, high - origin, edge)
    others, there = _cells(other_low - origin, other_high - origin, edge)
    order = np.argsort(there, kind="stable")
    others, there = others[order], there[order]
    first, last = np.searchsorted(there, cells, "left"), np.searchsorted(there, cells, "right")
    counts = last - first
    mine = np.repeat(boxes, counts)
    starts = np.concatenate([[0], np.cumsum(counts)])[:-1]
    places = np.arange(counts.sum()) - np.repeat(starts, counts) + np.repeat(first, counts)
    return mine, others[places]


def _cells(low: np.ndarray, high: np.ndarray, edge: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the number of a box and a key of a cell for all cells that each box touches."""
    first, last = (np.minimum(np.floor(values / edge), MAXIMUM_CELLS).astype(np.int64) for values in (low, high))
    spans = last - first + 1
    counts = spans.prod(axis=1)
    box = np.repeat(np.arange(len(low)), counts)
    number = np.arange(counts.sum()) - np.repeat(np.concatenate([[0], np.cumsum(counts)])[:-1], counts)
    x = number % spans[box, 0]
    y = number // spans[box, 0] % spans[box, 1]
    z = number // (spans[box, 0] * spans[box, 1])
    cell = first[box] + np.stack([x, y, z], axis=1)
    return box, (cell[:, 0] * (MAXIMUM_CELLS + 1) + cell[:, 1]) * (MAXIMUM_CELLS + 1) + cell[:, 2]
