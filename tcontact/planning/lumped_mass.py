"""Row-sum lumped mass of the cells and area weights of contact faces (METHOD 1)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..mesh.elements import GAUSS, HEX_CORNERS, shape_functions
from ..mesh.geometry import determinants
from ..mesh.late_rows import Rows
from ..scene.body import Body
from ..scene.springs import PointMass

QUAD_CORNERS = HEX_CORNERS[:4, :2]  # corners of the reference quadrilateral [-1, 1]^2, in VTK's order


class NodeMasses:
    """Lumped mass of the nodes of the mesh of a body.

    own [n] [kg]: that of its cells; total [n] [kg]: with its point masses; nodes of one image each, not of all.
    """

    def __init__(self, body: Body) -> None:
        self.body = body
        self.own = np.zeros(body.mesh.node_count)
        for block in body.blocks:
            for part, masses in masses_in_parts(block.kind, body.mesh.node_rows, block.rows, block.material.density):
                np.add.at(self.own, block.rows[part], masses)
        self.total = self.own
        if body.point_masses:
            self.total = self.own.copy()
            for point in body.point_masses:
                nodes, shares = _point_shares(point, body)
                self.total[nodes] += shares

    def of_cells(self, numbers: np.ndarray) -> np.ndarray:
        """Return the mass of each place in some cells [k] of the mesh [k, corners] [kg]; 0 where one repeats a corner.

        The share of a node in point masses is divided among its places as its own mass is, also those of its images.
        """
        body, mesh = self.body, self.body.mesh
        nodes, rows = mesh.node_rows, mesh.cell_rows
        masses = np.zeros((len(numbers), rows.shape[1]))
        for block in body.blocks:
            inside = np.ones(len(numbers), dtype=bool)
            if len(body.blocks) > 1:
                inside = np.isin(numbers, np.arange(mesh.cell_count)[block.numbers])
            cells = rows[numbers[inside], : block.facts.corners]
            masses[inside, : cells.shape[1]] = corner_masses(block.kind, nodes, cells, block.material.density)
        if self.total is self.own:
            return masses
        own, total = self.own, self.total
        if body.images is not None:
            own, total = (body.images.follow(body.images.total(values)) for values in (own, total))
        growth = np.divide(total, own, out=np.ones_like(own), where=own > 0.0)
        return masses * growth[rows[numbers]]


def _point_shares(point: PointMass, body: Body) -> tuple[np.ndarray, np.ndarray | float]:
    """Return the nodes of a point mass, with all images, and their shares [kg]; images halve or quarter that of one."""
    nodes, images = body.mesh.nodes_of(point.set), body.images
    if images is None:
        return nodes, point.mass / len(nodes)
    everyone = images.with_images(nodes)
    return everyone, point.mass / len(images.once(nodes)) / images.size[everyone]


def masses_in_parts(kind: str, nodes: Rows, cells: Rows, density: float) -> Iterator[tuple[slice, np.ndarray]]:
    """Yield (cells, lumped mass of each of their corners [c, corners] [kg]): density times the integral of N_a."""
    values, gradients, weights = shape_functions(kind)
    shares = density * weights[:, None] * values
    for part, jacobian in determinants(nodes, cells, gradients):
        yield part, jacobian.T @ shares


def corner_masses(kind: str, nodes: Rows, cells: np.ndarray, density: float) -> np.ndarray:
    """Return the lumped mass of each corner of the cells [m, corners] [kg], see `masses_in_parts`."""
    masses = np.zeros(cells.shape)
    for part, own in masses_in_parts(kind, nodes, cells, density):
        masses[part] = own
    return masses


def node_areas(nodes: Rows, faces: np.ndarray) -> np.ndarray:
    """Return the area weight A_k [n] [m^2]: integral of N_k over the faces, in the reference state.

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
