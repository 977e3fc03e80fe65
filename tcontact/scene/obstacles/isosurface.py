"""Triangulate the surface of zero sampled distance by marching tetrahedra, six in each cell of the grid."""

from __future__ import annotations

from itertools import permutations

import numpy as np

# corners of a cell as offsets; each tetrahedron runs from (0, 0, 0) to (1, 1, 1) along the axes in some order
TETRAHEDRA = [np.cumsum([[0, 0, 0], *np.eye(3, dtype=int)[list(order)]], axis=0) for order in permutations(range(3))]


def isosurface(distance: np.ndarray, origin: np.ndarray, spacing: float) -> tuple[np.ndarray, np.ndarray]:
    """Return points [k, 3] and triangles [m, 3], oriented towards positive distance [nx, ny, nz]."""
    value = np.where(distance == 0.0, 1e-300, distance).reshape(-1)
    ids = np.arange(value.size).reshape(distance.shape)
    nx, ny, nz = distance.shape
    corners = []
    for tetrahedron in TETRAHEDRA:
        tet = np.stack([ids[i : nx - 1 + i, j : ny - 1 + j, k : nz - 1 + k].ravel() for i, j, k in tetrahedron], axis=1)
        below = value[tet] < 0.0
        order = np.argsort(~below, axis=1, kind="stable")  # negative ones first
        tet, count = np.take_along_axis(tet, order, axis=1), below.sum(axis=1)
        for inside, ends in (
            (1, [[(0, 1), (0, 2), (0, 3)]]),
            (3, [[(0, 3), (1, 3), (2, 3)]]),
            (2, [[(0, 2), (0, 3), (1, 3)], [(0, 2), (1, 3), (1, 2)]]),
        ):
            chosen = tet[count == inside]
            corners += [np.stack([chosen[:, pair] for pair in triangle], axis=1) for triangle in ends]
    cut = np.concatenate(corners).reshape(-1, 2)  # edges of the grid, inside end first
    edges, triangles = np.unique(cut, axis=0, return_inverse=True)
    low, high = value[edges[:, 0]], value[edges[:, 1]]
    place = np.stack(np.unravel_index(edges, distance.shape), axis=-1).astype(np.float64)
    part = (low / (low - high))[:, None]
    points = place[:, 0] + part * (place[:, 1] - place[:, 0])
    triangles = triangles.reshape(-1, 3)
    middle = points[triangles]
    normal = np.cross(middle[:, 1] - middle[:, 0], middle[:, 2] - middle[:, 0])
    outward = (place[:, 1] - place[:, 0])[triangles].sum(axis=1)  # from negative to positive
    wrong = np.einsum("ni,ni->n", normal, outward) < 0.0
    triangles[wrong] = triangles[wrong][:, ::-1]
    return np.asarray(origin + spacing * points), triangles
