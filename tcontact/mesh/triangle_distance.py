"""Compute the smallest distance between two sets of triangles, up to a given reach.

A uniform grid finds the pairs of triangles that may be near. Two triangles are nearest at a corner and a face or at two
edges, unless an edge of one pierces the other (Ericson, Real-Time Collision Detection, 2005, sections 5.1.5, 5.1.9).
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

FIRST, AT_ONCE = 64, 1 << 17  # pairs at once, the nearest boxes first
ROUNDING = 1e-12  # of a length


def smallest_distance(first: np.ndarray, second: np.ndarray, reach: float) -> float:
    """Return the distance [m] of triangles first [k, 3, 3] and second [m, 3, 3] [m], 0 if they cut, at most `reach`."""
    pairs, apart = near_boxes(first, second, reach)
    best, order = reach, np.argsort(apart)
    start, count = 0, FIRST
    while start < len(order) and apart[order[start]] < best:  # boxes further apart than the smallest distance
        picked = order[start : start + count]
        picked = picked[apart[picked] < best]
        best = min(best, float(_distances(first[pairs[picked, 0]], second[pairs[picked, 1]]).min()))
        start, count = start + count, min(4 * count, AT_ONCE)
    return best


def boxes_of(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the smallest and the largest coordinates [n, 3] of groups of corners [n, k, 3], k > 0.

    A minimum along a short axis takes ten times as long as one of whole columns.
    """
    columns = np.ascontiguousarray(corners.transpose(1, 0, 2))
    return columns.min(axis=0), columns.max(axis=0)


def near_boxes(first: np.ndarray, second: np.ndarray, reach: float) -> tuple[np.ndarray, np.ndarray]:
    """Return pairs [p, 2] of cells or faces [.., corners, 3] whose boxes come within reach, and their distances [p].

    Each pair stands there once, with the distance of its boxes; a reach below 0 asks for boxes that overlap by as much.
    """
    none = np.zeros((0, 2), dtype=np.int64), np.zeros(0)
    if not len(first) or not len(second):
        return none
    (low_a, high_a), (low_b, high_b) = boxes_of(first), boxes_of(second)
    low_a, high_a = low_a - reach, high_a + reach
    kept_a = np.flatnonzero(((low_a <= high_b.max(axis=0)) & (high_a >= low_b.min(axis=0))).all(axis=1))
    kept_b = np.flatnonzero(((low_b <= high_a.max(axis=0)) & (high_b >= low_a.min(axis=0))).all(axis=1))
    if not len(kept_a) or not len(kept_b):
        return none
    low_a, high_a, low_b, high_b = low_a[kept_a], high_a[kept_a], low_b[kept_b], high_b[kept_b]
    size = max(float((high_a - low_a).max()), float((high_b - low_b).max())) * (1.0 + 1e-9)
    origin = np.minimum(low_a.min(axis=0), low_b.min(axis=0))
    cells_a, owner_a = _cells_of(low_a, high_a, origin, size)
    cells_b, owner_b = _cells_of(low_b, high_b, origin, size)
    order = np.argsort(cells_b, kind="stable")
    cells_b, owner_b = cells_b[order], owner_b[order]
    begin, end = np.searchsorted(cells_b, cells_a, "left"), np.searchsorted(cells_b, cells_a, "right")
    count = end - begin
    left = np.repeat(owner_a, count)
    place = np.arange(len(left)) - np.repeat(np.cumsum(count) - count, count) + np.repeat(begin, count)
    right = owner_b[place]
    meets = ((low_a[left] <= high_b[right]) & (high_a[left] >= low_b[right])).all(axis=1)
    found = np.unique(left[meets] * np.int64(len(kept_b)) + right[meets])
    left, right = found // len(kept_b), found % len(kept_b)
    between = np.maximum(low_a[left] - high_b[right], low_b[right] - high_a[left]) + reach
    pairs = np.stack([kept_a[left], kept_b[right]], axis=1)
    return pairs, np.linalg.norm(np.maximum(between, 0.0), axis=1)


def _cells_of(low: np.ndarray, high: np.ndarray, origin: np.ndarray, size: float) -> tuple[np.ndarray, np.ndarray]:
    """Return keys of the grid cells of boxes no larger than a cell, at most eight each, and their boxes."""
    first, last = (np.floor((corner - origin) / size).astype(np.int64) for corner in (low, high))
    keys, owners = [], []
    for step in np.ndindex(2, 2, 2):
        inside = (first + step <= last).all(axis=1)
        cell = first[inside] + step
        keys.append((cell[:, 0] << 42) + (cell[:, 1] << 21) + cell[:, 2])
        owners.append(np.flatnonzero(inside))
    return np.concatenate(keys), np.concatenate(owners)


def _distances(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the distance [n] of the triangles a and b [n, 3, 3], pair by pair."""
    count = len(a)
    corners = np.concatenate([a, b]).transpose(1, 0, 2).reshape(-1, 3)  # all first ones, all second ones, ...
    ends = np.concatenate([a, b])[:, [1, 2, 0]].transpose(1, 0, 2).reshape(-1, 3)
    others = np.tile(np.concatenate([b, a]), (3, 1, 1))
    apart = np.where(_pierces(corners, ends, others), 0.0, point_to_triangle(corners, others))
    starts = [np.repeat(a, 3, axis=1), np.tile(b, (1, 3, 1))]  # every edge of one with every edge of the other
    stops = [np.repeat(a[:, [1, 2, 0]], 3, axis=1), np.tile(b[:, [1, 2, 0]], (1, 3, 1))]
    edges = (starts[0], stops[0], starts[1], stops[1])
    between = _between_segments(*(end.reshape(-1, 3) for end in edges)).reshape(count, 9)
    return np.minimum(apart.reshape(6, count).min(axis=0), between.min(axis=1))


def _cross(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return x[:, [1, 2, 0]] * y[:, [2, 0, 1]] - x[:, [2, 0, 1]] * y[:, [1, 2, 0]]


def _dot(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return np.asarray(np.einsum("ni,ni->n", x, y))


def _point_to_segment(p: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    along = end - start
    length = np.maximum(_dot(along, along), 1e-300)
    part = np.clip(_dot(p - start, along) / length, 0.0, 1.0)
    return np.asarray(np.linalg.norm(p - start - part[:, None] * along, axis=1))


def point_to_triangle(p: np.ndarray, triangle: np.ndarray) -> np.ndarray:
    """Return the distance [n] of points [n, 3] to triangles [n, 3, 3], which have an area, one by one.

    That to the plane if the foot lies within the triangle, else to the nearest edge.
    """
    corner = [triangle[:, i] for i in range(3)]
    normal = _cross(corner[1] - corner[0], corner[2] - corner[0])
    area = np.maximum(np.linalg.norm(normal, axis=1), 1e-300)
    inside = np.ones(len(p), dtype=bool)
    edges = np.full(len(p), np.inf)
    for i in range(3):
        start, end = corner[i], corner[(i + 1) % 3]
        inside &= _dot(_cross(end - start, p - start), normal) >= 0.0
        edges = np.minimum(edges, _point_to_segment(p, start, end))
    return np.where(inside, np.abs(_dot(p - corner[0], normal)) / area, edges)


def _pierces(start: np.ndarray, end: np.ndarray, triangle: np.ndarray) -> np.ndarray:
    """Return whether the segment passes through the triangle, its boundary included."""
    a, b, c = (triangle[:, i] for i in range(3))
    normal = _cross(b - a, c - a)
    above, below = _dot(start - a, normal), _dot(end - a, normal)
    crosses = above * below < 0.0
    part = np.where(crosses, above / np.where(crosses, above - below, 1.0), 0.0)
    p = start + part[:, None] * (end - start)
    slack = -ROUNDING * _dot(normal, normal)
    for one, other in ((a, b), (b, c), (c, a)):
        crosses &= _dot(_cross(other - one, p - one), normal) >= slack
    return np.asarray(crosses)


def _between_segments(p1: np.ndarray, q1: np.ndarray, p2: np.ndarray, q2: np.ndarray) -> np.ndarray:
    """Return the distance if both nearest points lie within the segments, else inf: corners are treated apart."""
    d1, d2, r = q1 - p1, q2 - p2, p1 - p2
    a, e, b = _dot(d1, d1), _dot(d2, d2), _dot(d1, d2)
    c, f = _dot(d1, r), _dot(d2, r)
    denominator = a * e - b * b
    skew = denominator > 1e-12 * a * e
    safe = np.where(skew, denominator, 1.0)
    s, t = (b * f - c * e) / safe, (a * f - b * c) / safe
    within = skew & (s >= 0.0) & (s <= 1.0) & (t >= 0.0) & (t <= 1.0)
    apart = np.linalg.norm(r + s[:, None] * d1 - t[:, None] * d2, axis=1)
    return np.where(within, apart, np.inf)


def winding_number(point: np.ndarray, triangles: np.ndarray) -> float:
    """Return the winding number of a closed surface [k, 3, 3] about a point [3]: 1 inside, 0 outside."""
    a, b, c = (triangles[:, i] - point for i in range(3))
    la, lb, lc = (np.linalg.norm(corner, axis=1) for corner in (a, b, c))
    below = la * lb * lc + _dot(a, b) * lc + _dot(b, c) * la + _dot(c, a) * lb
    return float(np.arctan2(_dot(a, np.cross(b, c)), below).sum() / (2.0 * np.pi))


def _pieces(count: int, triangles: np.ndarray) -> np.ndarray:
    """Return a node of every connected piece of a surface of so many nodes."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    start, end = triangles.ravel(), np.roll(triangles, 1, axis=1).ravel()
    _count, label = connected_components(coo_matrix((np.ones(len(start)), (start, end)), (count, count)), False)
    return np.unique(label, return_index=True)[1]


def pieces_inside(points: np.ndarray, triangles: np.ndarray, around: np.ndarray) -> Iterator[np.ndarray]:
    """Yield a node [3] [m] of every piece of a surface that lies within another one.

    points [n, 3] [m], triangles [m, 3] (nodes): of the surface; around [k, 3, 3] [m]: triangles of the other one, which
    is closed. A node of a piece decides where no surfaces cut.
    """
    low, high = around.min(axis=(0, 1)), around.max(axis=(0, 1))
    for node in points[_pieces(len(points), triangles)]:
        if (node > low).all() and (node < high).all() and winding_number(node, around) > 0.5:
            yield node


def triangles_of(faces: np.ndarray) -> np.ndarray:
    """Return the triangles [m, 3] of faces [k, 4|3]; one of four corners may repeat its last corner."""
    if faces.shape[1] == 3:
        return faces
    second = faces[faces[:, 3] != faces[:, 2]]
    return np.concatenate([faces[:, [0, 1, 2]], second[:, [0, 2, 3]]])
