"""Row-sum lumped mass of the cells and area weights of contact faces (METHOD 1)."""

from __future__ import annotations

import numpy as np

from ..mesh.elements import GAUSS, HEX_CORNERS, shape_functions
from ..scene.body import Body

QUAD_CORNERS = HEX_CORNERS[:4, :2]  # corners of the reference quadrilateral [-1, 1]^2, in VTK's order


def body_masses(body: Body) -> np.ndarray:
    """Lumped mass of each place in the cells of the mesh of a body [m, corners] [kg]; 0 where one repeats a corner.

    The share of a node in point masses is divided among its places as its own mass is.
    """
    masses = _cell_masses(body)
    if not body.point_masses:
        return masses
    cells = body.mesh.cells
    own, added = np.zeros(body.mesh.node_count), np.zeros(body.mesh.node_count)
    np.add.at(own, cells, masses)
    for point in body.point_masses:
        nodes = body.mesh.nodes_of(point.set)
        added[nodes] += point.mass / len(nodes)
    return masses * (1.0 + added / np.where(own > 0.0, own, 1.0))[cells]


def _cell_masses(body: Body) -> np.ndarray:
    blocks, mesh = body.blocks, body.mesh
    if len(blocks) == 1:
        return corner_masses(blocks[0].kind, mesh.nodes[mesh.cells], blocks[0].material.density)
    masses = np.zeros(mesh.cells.shape)
    for block in blocks:
        own = corner_masses(block.kind, mesh.nodes[block.cells], block.material.density)
        masses[block.numbers, : own.shape[1]] = own
    return masses


def corner_masses(kind: str, corners: np.ndarray, density: float) -> np.ndarray:
    """Lumped mass of each corner of each cell [m, corners] [kg]: density times the integral of N_a.

    corners [m, corners, 3] [m]: positions.
    """
    values, gradients, weights = shape_functions(kind)
    masses = np.zeros(corners.shape[:2])
    for value, gradient, weight in zip(values, gradients, weights, strict=True):
        jacobian = np.linalg.det(np.einsum("mad,ac->mdc", corners, gradient, optimize=True))
        masses += density * weight * jacobian[:, None] * value
    return masses


def node_areas(nodes: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Area weight A_k [n] [m^2]: integral of N_k over the faces, in the reference state.

    Among quadrilaterals a triangle repeats its last corner; the quadrature is exact for it too.
    """
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
