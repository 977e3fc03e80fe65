"""Find cells of two bodies that overlap: their convex hulls, pair by pair, along all axes that can separate them.

Two convex bodies are apart if their shadows are, along a normal of a face of one or along the product of an edge of
each (Gottschalk, Lin and Manocha, OBBTree, 1996, section 5). The smallest overlap of the shadows is how far one of them
has to move until they touch. What touches overlaps by 0, whatever shares its planes, edges and corners.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .elements import ELEMENTS
from .triangle_distance import boxes_of, near_boxes

AT_ONCE = 2048  # pairs of cells at once
ENOUGH = 1 << 15  # pairs of cells, the deepest boxes first, after which a search that has found some ends
CORNERS, NORMALS, EDGES = 8, 24, 12  # most corners, normals of faces and edges of a cell


class Hulls(NamedTuple):
    """Convex hulls of cells.

    points [k, 8, 3] [m]: corners, the last one several times where a cell has fewer; normals [k, 24, 3], edges
    [k, 12, 3]: unit normals of their faces, and edges, 0 where a cell has fewer; slack [k] [m]: by how much a hull may
    stand out of the surface of its body.
    """

    points: np.ndarray
    normals: np.ndarray
    edges: np.ndarray
    slack: np.ndarray


class Overlaps(NamedTuple):
    """Pairs [p, 2] of hulls that overlap, and the way [p] [m] that one of them has to move until they touch."""

    pairs: np.ndarray
    depth: np.ndarray


def hulls_of(cells: Sequence[tuple[str, np.ndarray, np.ndarray]]) -> Hulls:
    """Return the hulls of cells: of every kind its name, corners [k, a, 3] [m], and which lie on the surface [k, a].

    A hull stands out of the surface where a quadrilateral of it is warped, at most by its fourth corner above the other
    three.
    """
    parts = []
    for kind, points, outer in cells:
        normals = np.zeros((len(points), NORMALS, 3))
        edges = np.zeros((len(points), EDGES, 3))
        slack = np.zeros(len(points))
        for number, (start, end) in enumerate(ELEMENTS[kind].edges):
            edges[:, number] = points[:, end] - points[:, start]
        place = 0
        for face in ELEMENTS[kind].faces:
            for left_out in range(len(face) if len(face) == 4 else 1):
                a, b, c = (points[:, corner] for corner in np.roll(face, -left_out)[:3])
                normals[:, place] = _unit(np.cross(b - a, c - a))
                place += 1
            if len(face) == 4:
                above = np.abs(np.einsum("ki,ki->k", normals[:, place - 4], points[:, face[3]] - points[:, face[0]]))
                slack = np.maximum(slack, np.where(outer[:, face].all(axis=1), above, 0.0))
        filled = points[:, np.minimum(np.arange(CORNERS), points.shape[1] - 1)]
        parts.append((filled, normals, edges, slack))
    return Hulls(*(np.concatenate(part) for part in zip(*parts, strict=True)))


def overlaps(first: Hulls, second: Hulls, least: float) -> Overlaps:
    """Return pairs of hulls, one of each, that overlap by more than `least` [m] and the slack of both.

    All of them, or where they are many the first ones that are found.
    """
    pairs, apart = near_boxes(first.points, second.points, -least)
    (low, high), (other_low, other_high) = boxes_of(first.points), boxes_of(second.points)
    low = np.maximum(low[pairs[:, 0]], other_low[pairs[:, 1]])
    high = np.minimum(high[pairs[:, 0]], other_high[pairs[:, 1]])
    pairs = pairs[np.argsort(-(high - low).min(axis=1, initial=np.inf), kind="stable")]
    found = [Overlaps(pairs[:0], apart[:0])]
    for start in range(0, len(pairs), AT_ONCE):
        if start >= ENOUGH and any(len(part.pairs) for part in found):
            break
        part = pairs[start : start + AT_ONCE]
        allowed = least + first.slack[part[:, 0]] + second.slack[part[:, 1]]
        points = first.points[part[:, 0]], second.points[part[:, 1]]
        depth = _shadows(*points, np.concatenate([first.normals[part[:, 0]], second.normals[part[:, 1]]], axis=1))
        kept = np.flatnonzero(depth > allowed)
        part = part[kept]
        axes = _unit(np.cross(first.edges[part[:, 0]][:, :, None], second.edges[part[:, 1]][:, None]))
        axes = axes.reshape(len(part), EDGES**2, 3)
        depth = np.minimum(depth[kept], _shadows(points[0][kept], points[1][kept], axes))
        kept = np.flatnonzero(depth > allowed[kept])
        found.append(Overlaps(part[kept], depth[kept]))
    return Overlaps(*(np.concatenate(part) for part in zip(*found, strict=True)))


def _shadows(one: np.ndarray, other: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """Return the smallest overlap [p] [m] of points [p, 8, 3] [m] along axes [p, a, 3], which are units or 0."""
    start = other[:, :1]
    mine, theirs = (axes @ (points - start).transpose(0, 2, 1) for points in (one, other))
    overlap = np.minimum(theirs.max(axis=2) - mine.min(axis=2), mine.max(axis=2) - theirs.min(axis=2))
    return np.asarray(np.where(axes.any(axis=2), overlap, np.inf).min(axis=1))


def _unit(vectors: np.ndarray) -> np.ndarray:
    """Return vectors [.., 3] with length 1, and 0 where they have none."""
    sizes = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(np.divide(vectors, sizes, out=np.zeros_like(vectors), where=sizes > 0.0))
