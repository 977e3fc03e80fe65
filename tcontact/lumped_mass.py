"""Row-sum lumped mass of the cells and area weights of contact faces (METHOD 1)."""

from __future__ import annotations

import numpy as np

from .mesh import Mesh

# corners of the reference hexahedron [-1, 1]^3 and quadrilateral [-1, 1]^2, VTK order
HEX_CORNERS = np.array(
    [[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]], dtype=float
)
QUAD_CORNERS = HEX_CORNERS[:4, :2]
GAUSS = 1.0 / np.sqrt(3.0)


def shape_functions(kind: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Values [q, corners], reference gradients [q, corners, 3] and weights [q] at the integration points of a cell."""
    if kind == "tet4":
        gradients = np.array([[-1, -1, -1], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
        return np.full((1, 4), 0.25), gradients[None], np.array([1.0 / 6.0])
    points = GAUSS * HEX_CORNERS
    factors = 1.0 + points[:, None, :] * HEX_CORNERS[None]  # [q, a, 3]
    values = factors.prod(axis=2) / 8.0
    gradients = np.empty((8, 8, 3))
    for axis in range(3):
        one, two = [other for other in range(3) if other != axis]
        gradients[:, :, axis] = HEX_CORNERS[:, axis] * factors[:, :, one] * factors[:, :, two] / 8.0
    return values, gradients, np.ones(8)


def cell_masses(mesh: Mesh, density: float) -> np.ndarray:
    """Lumped mass of each corner of each cell [m, corners] [kg]: density times the integral of N_a."""
    values, gradients, weights = shape_functions(mesh.kind)
    masses = np.zeros(mesh.cells.shape)
    corners = mesh.nodes[mesh.cells]
    for value, gradient, weight in zip(values, gradients, weights, strict=True):
        jacobian = np.linalg.det(np.einsum("mad,ac->mdc", corners, gradient, optimize=True))
        masses += density * weight * jacobian[:, None] * value
    return masses


def node_areas(nodes: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Area weight A_k [n] [m^2]: integral of N_k over the faces, in the reference state."""
    areas = np.zeros(len(nodes))
    if faces.shape[1] == 3:
        normal = np.cross(nodes[faces[:, 1]] - nodes[faces[:, 0]], nodes[faces[:, 2]] - nodes[faces[:, 0]])
        np.add.at(areas, faces, (np.linalg.norm(normal, axis=1) / 6.0)[:, None])
        return areas
    for point in GAUSS * QUAD_CORNERS:
        factors = 1.0 + point * QUAD_CORNERS
        value = factors.prod(axis=1) / 4.0
        along = (QUAD_CORNERS[:, 0] * factors[:, 1] / 4.0, QUAD_CORNERS[:, 1] * factors[:, 0] / 4.0)
        tangents = [np.einsum("kad,a->kd", nodes[faces], gradient) for gradient in along]
        np.add.at(areas, faces, np.linalg.norm(np.cross(*tangents), axis=1)[:, None] * value)
    return areas
