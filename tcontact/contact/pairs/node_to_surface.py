"""Node-to-surface rows of a slave surface whose nodes have mass, for the penalty (METHOD 7).

    g = n . (x_s - sum_a P_a x_a),   n ~ sum_f s_f n_f,   P = sum_f s_f N_f,   area A_s

N_f are the shape functions of a master face f where the slave node meets it along its normal n_f. A node has one row,
on its closest face. Faces that are equally close share it. At a distance b_f from the node along each of them,

    s_f ~ (1 - (d_f - min d) / e) / (b_f + e),   e = TIED h

is continuous in d_f and b_f, and no numbering of faces enters it. Between two faces, before an edge or behind a groove,
where the closest point is on their common side, n is then the direction from there to the node, since
n sin(a + b) = n_1 sin b + n_2 sin a at angles a and b from n to n_1 and n_2; where a node stands on the side that two
faces share, or as deep behind both, n is the mean of their normals.
"""

from __future__ import annotations

import numpy as np

from ...planning.lumped_mass import QUAD_CORNERS, node_areas
from .coupling import FAR, Coupling, starts
from .surfaces import Facing, area_vectors

BEYOND = 0.025  # share of a face by which a node may lie beside it and have a row with its shape functions
WEDGE = 1.0  # distance from a face along it over that across it with which a node between two faces has a row
ITERATIONS = 10  # of Newton's method for the local coordinates
FARTHEST = 2.0  # largest local coordinate
ROUNDING = 1e-9  # of a distance over the size of a face
TIED = 1e-6  # the same, by which a face may be further away than the closest one and have a share in the row


def couple_nodes(facing: Facing, positions: np.ndarray, pairs: np.ndarray) -> Coupling:
    """Return the rows of a slave surface at positions [n, 3] [m]; pairs [p, 2]: faces that may meet."""
    masters = facing.master_faces
    candidates = np.stack([facing.slave.faces[pairs[:, 0]], np.broadcast_to(pairs[:, 1:], (len(pairs), 4))], axis=2)
    nodes, f = np.unique(candidates.reshape(-1, 2), axis=0).T
    corners = positions[masters[f]] - positions[nodes][:, None]  # from the node
    vectors = area_vectors(positions, masters)[f]
    size = np.linalg.norm(vectors, axis=1)
    normals = vectors / size[:, None]
    shares = _shares(corners, normals)
    place, away = _closest(shares, corners)
    closest = np.einsum("pa,pai->pi", place, corners)
    distance = np.linalg.norm(closest, axis=1)
    along = np.linalg.norm(closest - np.einsum("pi,pi->p", closest, normals)[:, None] * normals, axis=1)
    weights = _weights(shares, BEYOND)
    apart = -np.einsum("pa,pai->pi", weights, corners)
    gap = np.einsum("pi,pi->p", apart, normals)
    aside = np.linalg.norm(apart - gap[:, None] * normals, axis=1) - ROUNDING * np.sqrt(size)
    bends = _bends(positions, masters)[f]
    beyond = shares < -BEYOND
    between = beyond.any(axis=1) & ((bends * gap[:, None] < 0.0) | ~beyond).all(axis=1)
    near = (gap <= facing.reach) & (gap >= -FAR * facing.reach)
    kept = near & (aside <= np.where(between, WEDGE * np.abs(gap), 0.0))
    least = np.full(len(positions), np.inf)
    np.minimum.at(least, nodes[kept], distance[kept])
    further = np.abs(distance - least[nodes]) / (TIED * np.sqrt(size))
    chosen = np.flatnonzero((kept | near & between) & (further < 1.0))
    chosen = chosen[np.lexsort((f[chosen], nodes[chosen]))]
    nodes, f = nodes[chosen], f[chosen]
    slaves, row, faces = np.unique(nodes, return_inverse=True, return_counts=True)
    share = (1.0 - further[chosen]) / (along[chosen] + TIED * np.sqrt(size[chosen]))
    share /= np.bincount(row, share)[row]
    ends = np.isnan(bends)  # sides where the surface ends, which a node may lie beside; others are those of two faces
    beside = (ends & (away <= away.min(axis=1)[:, None] + ROUNDING * np.sqrt(size)[:, None])).any(axis=1)[chosen]
    at_end = _weights(shares[chosen], np.where(ends[chosen], BEYOND, 0.0))
    shared = np.where(beside[:, None], at_end, place[chosen])
    weights = share[:, None] * np.where((faces[row] > 1)[:, None], shared, weights[chosen])
    there = weights != 0.0  # not of the fourth corner of a triangle
    count = len(positions)
    entries, entry = np.unique((row[:, None] * count + masters[f])[there], return_inverse=True)
    row_of, master = np.divmod(entries, count)
    owner = np.zeros(count, dtype=np.int64)
    owner[masters] = facing.master_bodies[:, None]
    return Coupling(
        slaves=slaves,
        area=node_areas(positions, facing.slave.faces)[slaves],
        first=np.searchsorted(row_of, np.arange(len(slaves) + 1)),
        masters=master,
        weights=np.bincount(entry, weights[there], len(entries)),
        bodies=owner[master],
        first_face=starts(faces),
        faces=masters[f],
        face_weights=share,
    )


def _shares(corners: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Return how far inside each side of a face with corners [p, 4, 3] the origin lies, seen along its normal [p, 4].

    0 on a side, 1 at the opposite one (of a quadrilateral) or corner (of a triangle, whose third side counts as
    infinitely far); sides go from their corner to the next one.
    """
    first = corners[:, 1] - corners[:, 0]
    first -= np.einsum("pi,pi->p", first, normals)[:, None] * normals
    first /= np.linalg.norm(first, axis=1)[:, None]
    axes = np.stack([first, np.cross(normals, first)], axis=1)
    flat = np.einsum("pai,pji->paj", corners, axes)
    result = np.empty((len(corners), 4))
    triangle = (corners[:, 3] == corners[:, 2]).all(axis=1)
    one, two, three = (flat[triangle, a] for a in range(3))
    parts = [_cross(a, b) for a, b in ((one, two), (two, three), (three, one))]
    result[triangle] = (
        np.stack([*parts[:2], np.full(len(one), np.inf), parts[2]], axis=1) / np.sum(parts, axis=0)[:, None]
    )
    quads = flat[~triangle]
    local = np.zeros((len(quads), 2))
    for _ in range(ITERATIONS):
        factors = 1.0 + local[:, None] * QUAD_CORNERS
        slopes = [0.25 * QUAD_CORNERS[:, 0] * factors[:, :, 1], 0.25 * QUAD_CORNERS[:, 1] * factors[:, :, 0]]
        along, across = (np.einsum("pa,paj->pj", slope, quads) for slope in slopes)
        rest = np.einsum("pa,paj->pj", 0.25 * factors.prod(axis=2), quads)
        with np.errstate(divide="ignore", invalid="ignore"):  # a crushed face: it has no row
            step = np.stack([_cross(across, rest), _cross(rest, along)], axis=1) / _cross(along, across)[:, None]
        local = np.clip(local + step, -FARTHEST, FARTHEST)
    a, b = local.T
    result[~triangle] = 0.5 * np.stack([1.0 + b, 1.0 - a, 1.0 - b, 1.0 + a], axis=1)
    return result


def _closest(shares: np.ndarray, corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the shape functions [p, 4] of the place of a face that is closest to the origin.

    And the distances of the sides [p, 4] from it, infinite of the missing side of a triangle. shares [p, 4]: of
    `_shares`; corners [p, 4, 3].
    """
    sides = np.roll(corners, -1, axis=1) - corners
    length = np.einsum("pai,pai->pa", sides, sides)
    way = -np.einsum("pai,pai->pa", corners, sides) / np.where(length > 0.0, length, 1.0)
    way = np.clip(way, 0.0, 1.0)
    away = np.where(length > 0.0, np.linalg.norm(corners + way[:, :, None] * sides, axis=2), np.inf)
    every, side = np.arange(len(way)), away.argmin(axis=1)
    result = np.zeros(shares.shape)
    result[every, side], result[every, (side + 1) % 4] = 1.0 - way[every, side], way[every, side]
    above = np.asarray((shares >= 0.0).all(axis=1))
    return np.where(above[:, None], _weights(shares, 0.0), result), away


def _weights(shares: np.ndarray, beyond: float | np.ndarray) -> np.ndarray:
    """Return the shape functions [p, 4] of the closest place that is at most `beyond` outside a face.

    beyond: of all sides, or of every side of each face [p, 4].
    """
    beyond = np.broadcast_to(beyond, shares.shape)
    inside = np.maximum(shares, -beyond)
    triangle = np.isinf(shares[:, 2])
    three = np.stack([inside[:, 1], inside[:, 3], inside[:, 0], np.zeros(len(shares))], axis=1)
    a, b = (np.minimum(inside[:, one], 1.0 + beyond[:, opposite]) for one, opposite in ((3, 1), (0, 2)))
    quads = np.stack([(1.0 - a) * (1.0 - b), a * (1.0 - b), a * b, (1.0 - a) * b], axis=1)
    return np.where(triangle[:, None], three / three.sum(axis=1)[:, None], quads)


def _cross(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    return np.asarray(one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0])


def _bends(positions: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return how the surface of faces [f, 4] bends at every side [f, 4]: 1 to a groove, -1 to an edge, NaN at its end.

    Beyond a side a node lies between two faces only before an edge, or behind a groove; elsewhere another face has it.
    """
    ends = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2)
    _, side, count = np.unique(np.sort(ends, axis=2).reshape(-1, 2), axis=0, return_inverse=True, return_counts=True)
    order = np.argsort(side.reshape(-1), kind="stable")
    first = order[(np.cumsum(count) - count)[count == 2]]
    second = order[(np.cumsum(count) - 1)[count == 2]]
    middle = positions[ends].mean(axis=2).reshape(-1, 3)
    normals, centres = area_vectors(positions, faces), positions[faces].mean(axis=1)
    result = np.full(faces.size, np.nan)
    for one, other in ((first, second), (second, first)):
        away = centres[other // 4] - middle[one]
        result[one] = np.sign(np.einsum("si,si->s", normals[one // 4], away))
    return result.reshape(faces.shape)
