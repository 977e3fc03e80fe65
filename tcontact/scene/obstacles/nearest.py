"""Find the nearest point of many triangles, by a tree over small pieces of them."""

from __future__ import annotations

from typing import Any

import numpy as np

FEW, MANY = 8, 32  # pieces searched for every point, and for points close to the surface if that may not be enough
AT_ONCE = 1 << 16  # points at once


def pieces_of(corners: np.ndarray, longest: float) -> np.ndarray:
    """Halve triangles [m, 3, 3] at their longest edge until none is longer; return pieces [p, 3, 3]."""
    done = []
    while len(corners):
        edges = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
        worst = edges.argmax(axis=1)
        rows = np.arange(len(corners))
        small = edges[rows, worst] <= longest
        done.append(corners[small])
        rows, worst, corners = np.arange((~small).sum()), worst[~small], corners[~small]
        a, b, c = (corners[rows, (worst + i) % 3] for i in range(3))
        middle = 0.5 * (a + b)
        corners = np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])
    return np.concatenate(done)


def nearest_points(corners: np.ndarray, positions: np.ndarray, reach: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the nearest points [n, 3] of triangles [m, 3, 3] to positions [n, 3], and their triangles [n].

    Exact where the triangles with the nearest centres include the nearest one: `MANY` of them closer than `reach`,
    `FEW` beyond, where another triangle may be nearer by a small part of its size (see `ask_neighbours`).
    """
    from scipy.spatial import cKDTree

    centre = corners.mean(axis=1)
    radius = np.linalg.norm(corners - centre[:, None], axis=2).max(axis=1)
    tree = cKDTree(centre)
    found, owner = np.empty_like(positions), np.empty(len(positions), dtype=np.int64)
    for start in range(0, len(positions), AT_ONCE):
        part = slice(start, start + AT_ONCE)
        found[part], owner[part] = _portion(tree, corners, radius, positions[part], reach)
    return found, owner


def _portion(
    tree: Any, corners: np.ndarray, radius: np.ndarray, positions: np.ndarray, reach: float
) -> tuple[np.ndarray, np.ndarray]:
    """Do `nearest_points` for a portion; tree: of the centres of the triangles; radius [m]: their extent from these."""
    best = np.full(len(positions), np.inf)
    found, owner = np.zeros_like(positions), np.zeros(len(positions), dtype=np.int64)
    rows = np.arange(len(positions))
    before = 0
    for count in (FEW, MANY):
        count = min(count, tree.n)
        away, pieces = (np.reshape(part, (len(rows), count)) for part in tree.query(positions[rows], k=count))
        for rank in range(before, count):
            worth = away[:, rank] - radius[pieces[:, rank]] < best[rows]
            who, piece = rows[worth], pieces[worth, rank]
            point = closest_on_triangles(corners[piece], positions[who])
            distance = np.linalg.norm(positions[who] - point, axis=1)
            nearer = distance < best[who]
            who, piece = who[nearer], piece[nearer]
            best[who], found[who], owner[who] = distance[nearer], point[nearer], piece
        rows, before = rows[(best[rows] < reach) & (away[:, -1] - radius.max() < best[rows])], count
        if before == tree.n or not len(rows):
            break
    return found, owner


def ask_neighbours(
    corners: np.ndarray, positions: np.ndarray, found: np.ndarray, owner: np.ndarray, spacing: float
) -> None:
    """Improve nearest points [nx, ny, nz, 3] and triangles [nx, ny, nz] at the nodes of a grid, in place, by those of
    the next nodes: a triangle nearest to x + h lies within sqrt(D(x)^2 + h^2) of x if it is nearest to x too."""
    for axis in range(3):
        for step in (1, -1):
            rest, ahead = [slice(None)] * 3, [slice(None)] * 3
            rest[axis], ahead[axis] = (slice(None, -1), slice(1, None))[::step]
            here, there = tuple(rest), tuple(ahead)
            best = np.sum((positions[here] - found[here]) ** 2, axis=-1)
            other = np.sum((positions[here] - found[there]) ** 2, axis=-1)
            worth = (owner[here] != owner[there]) & (other < best + spacing**2)
            piece, where = owner[there][worth], positions[here][worth]
            point = closest_on_triangles(corners[piece], where)
            nearer = np.sum((where - point) ** 2, axis=-1) < best[worth]
            changed = worth.copy()
            changed[worth] = nearer
            found[here][changed], owner[here][changed] = point[nearer], piece[nearer]


def closest_on_triangles(corners: np.ndarray, positions: np.ndarray) -> np.ndarray:
    """Return the nearest point [n, 3] of one triangle [n, 3, 3] to each position [n, 3]."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    normal = np.cross(b - a, c - a)
    square = np.einsum("ni,ni->n", normal, normal)
    from_a = positions - a
    safe = np.where(square > 0.0, square, 1.0)
    second = np.einsum("ni,ni->n", np.cross(from_a, c - a), normal) / safe
    third = np.einsum("ni,ni->n", np.cross(b - a, from_a), normal) / safe
    result = a + second[:, None] * (b - a) + third[:, None] * (c - a)
    off = np.flatnonzero(~((second >= 0.0) & (third >= 0.0) & (second + third <= 1.0) & (square > 0.0)))
    smallest = np.full(len(off), np.inf)
    for start, end in ((a, b), (b, c), (c, a)):
        origin, along, here = start[off], end[off] - start[off], positions[off]
        length = np.einsum("ni,ni->n", along, along)
        part = np.einsum("ni,ni->n", here - origin, along) / np.where(length > 0.0, length, 1.0)
        point = origin + np.clip(part, 0.0, 1.0)[:, None] * along
        distance = np.einsum("ni,ni->n", here - point, here - point)
        nearer = distance < smallest
        smallest[nearer] = distance[nearer]
        result[off[nearer]] = point[nearer]
    return result
