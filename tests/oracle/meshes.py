"""Small meshes to try things on: boxes of hexes or tets, shaken or turned, and their faces."""

import numpy as np
from scipy.spatial.transform import Rotation

HEX_FACES = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
TET_FACES = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]
HEX_TO_TETS = np.array([[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]])


def box(size, count, kind):
    """Nodes [n, 3] and cells [m, 8|4] of a box with one corner in the origin."""
    nx, ny, nz = count
    axes = [np.linspace(0, length, number + 1) for length, number in zip(size, count, strict=True)]
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    i, j, k = (a.ravel() for a in np.meshgrid(range(nx), range(ny), range(nz), indexing="ij"))

    def node(a, b, c):
        return ((i + a) * (ny + 1) + j + b) * (nz + 1) + k + c

    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    cells = np.stack([node(*corner) for corner in corners], axis=1)
    if kind == "tet4":
        cells = cells[:, HEX_TO_TETS].reshape(-1, 4)
    return nodes, cells


def boundary_faces(cells, kind):
    """Faces that belong to one cell alone [f, 4|3], nodes in outward order, and their cells [f]."""
    pattern = np.array(HEX_FACES if kind == "hex8" else TET_FACES)
    faces = cells[:, pattern].reshape(-1, pattern.shape[1])
    owner = np.repeat(np.arange(len(cells)), len(pattern))
    _, index, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    chosen = np.sort(index[count == 1])
    return faces[chosen], owner[chosen]


def faces_on(nodes, cells, kind, axis, value):
    """Boundary faces in the plane x[axis] = value."""
    faces, _ = boundary_faces(cells, kind)
    size = np.ptp(nodes, axis=0).max()
    return faces[np.all(np.abs(nodes[faces][:, :, axis] - value) < 1e-9 * size, axis=1)]


def shaken(nodes, amount, seed):
    """The nodes inside the bounding box moved at random by at most `amount` [m] per axis."""
    low, high = nodes.min(axis=0), nodes.max(axis=0)
    inside = np.all((nodes > low + 1e-9 * (high - low)) & (nodes < high - 1e-9 * (high - low)), axis=1)
    move = np.random.default_rng(seed).uniform(-amount, amount, nodes.shape)
    return nodes + inside[:, None] * move


def rotation(seed):
    """A random rotation matrix [3, 3]."""
    return Rotation.random(random_state=seed).as_matrix()
