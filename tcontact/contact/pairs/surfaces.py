"""The contact surfaces of the bodies of a domain: faces in its numbering of nodes."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...planning.domain import Domain
from ...scene.meeting import area_vectors as vectors_of
from ...scene.pairs import slave_order

REACH = 0.25  # gap over the mean size of a slave face within which a row exists
CLOSED = 1e-6  # gap over the size of a slave face that counts as closed on flat surfaces too
SMOOTH = 0.9  # flatness of a node (coupling.py) below which it is an edge of the surface
THIN = 0.4  # the reach over the shortest edge of either body, at most


@dataclass(frozen=True)
class Surface:
    """The contact faces of one body.

    body: its place in the domain; order: a slave stands before its masters; faces [f, 4]: nodes of the domain, outward,
    a triangle with its last node twice; nodes [k]: all nodes of the faces; size [m]: root of the mean area of a face;
    edge [m]: shortest edge of the body.
    """

    body: int
    order: int
    faces: np.ndarray
    nodes: np.ndarray
    size: float
    edge: float


@dataclass(frozen=True)
class Facing:
    """The surface of a slave, and the joint surface of all its masters in pairs.

    master_faces [f, 4]: nodes of the domain; master_bodies [f]: place of their body in the domain; pair [bodies]:
    number of the pair with this master; reach, margin [m]: of rows and of the search; sagitta [m]: gap h^2 kappa / 8
    that flat faces of size h leave on surfaces of curvature kappa; closed [m]: gaps of the start up to this size count
    as 0.
    """

    slave: Surface
    master_faces: np.ndarray
    master_bodies: np.ndarray
    pair: np.ndarray
    reach: float
    sagitta: float
    closed: float

    @property
    def margin(self) -> float:
        """Way [m] that the surfaces may go towards each other before the next search."""
        return 0.5 * self.slave.size

    @cached_property
    def local(self) -> tuple[np.ndarray, Facing]:
        """The nodes [k] of all faces, ascending, and the same facing in their numbering."""
        own = self.slave.faces
        nodes, numbers = np.unique(np.concatenate([own, self.master_faces]), return_inverse=True)
        parts = np.split(numbers.reshape(-1, 4), [len(own)])
        slave = replace(self.slave, faces=parts[0], nodes=np.unique(parts[0]))
        return nodes, replace(self, slave=slave, master_faces=parts[1])


def surfaces_of(domain: Domain) -> list[Surface]:
    """Return the surfaces of the bodies that are in pairs; a rank that shares them has those of the whole domain."""
    if domain.surfaces is not None:
        return list(domain.surfaces)
    place = {number: index for index, number in enumerate(domain.numbers)}
    order = slave_order(domain.pairs, max(domain.numbers) + 1)
    found = []
    for number in sorted({number for pair in domain.pairs for number in (pair.first, pair.second)}):
        index = place[number]
        plan = domain.bodies[index]
        faces = plan.place[plan.body.contact_faces] + domain.node_start[index]
        faces = faces if faces.shape[1] == 4 else faces[:, [0, 1, 2, 2]]
        edge = plan.body.mesh.shortest_edge
        size = float(np.sqrt(np.linalg.norm(area_vectors(domain.reference, faces), axis=1).mean()))
        found.append(Surface(index, order[number], faces.astype(np.int64), np.unique(faces), size, edge))
    return found


def facings_of(domain: Domain, surfaces: Sequence[Surface]) -> list[Facing]:
    """Return one entry for every body that is slave in a pair, masters of others first."""
    place = {number: index for index, number in enumerate(domain.numbers)}
    by_body = {surface.body: surface for surface in surfaces}
    found = []
    for slave in sorted(surfaces, key=lambda surface: (-surface.order, surface.body)):
        pair = np.full(len(domain.bodies), -1)
        masters = []
        for number, one in enumerate(domain.pairs):
            if place[one.slave] == slave.body:
                pair[place[one.master]] = number
                masters.append(by_body[place[one.master]])
        if masters:
            faces = np.concatenate([master.faces for master in masters])
            bodies = np.repeat([master.body for master in masters], [len(master.faces) for master in masters])
            reach = min(REACH * slave.size, THIN * min(surface.edge for surface in (slave, *masters)))
            sagitta = max(_sagitta(surface, domain.reference) for surface in (slave, *masters))
            wants = any(one.initial_gap == "closed" for one in domain.pairs if place[one.slave] == slave.body)
            closed = sagitta + CLOSED * slave.size if wants else 0.0
            found.append(Facing(slave, faces, bodies, pair, reach, sagitta, closed))
    return found


def _sagitta(surface: Surface, positions: np.ndarray) -> float:
    """Return the largest sagitta h^2 kappa / 8 [m] of the faces of a surface, without its edges.

    For two nodes of a face h is their distance, kappa h the angle between their normals.
    """
    faces, vectors = surface.faces, area_vectors(positions, surface.faces)
    flat = flatness(faces, vectors, np.linalg.norm(vectors, axis=1), len(positions))
    normals = np.zeros_like(positions)
    for corner in faces.T[:3]:
        np.add.at(normals, corner, vectors)
    quads = faces[:, 3] != faces[:, 2]
    np.add.at(normals, faces[quads, 3], vectors[quads])
    largest = 0.0
    for one, other in itertools.combinations(faces.T, 2):
        smooth = (flat[one] >= SMOOTH) & (flat[other] >= SMOOTH) & (one != other)
        first, second = normals[one[smooth]], normals[other[smooth]]
        angle = np.arctan2(np.linalg.norm(np.cross(first, second), axis=1), np.einsum("ij,ij->i", first, second))
        apart = np.linalg.norm(positions[one[smooth]] - positions[other[smooth]], axis=1)
        largest = max(largest, float((apart * angle).max(initial=0.0)) / 8.0)
    return largest


def area_vectors(positions: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return area times outward unit normal [f, 3] [m^2] of faces [f, 4] of nodes at positions [n, 3]."""
    return vectors_of(positions[faces])


def flatness(faces: np.ndarray, vectors: np.ndarray, sizes: np.ndarray, count: int) -> np.ndarray:
    """Return |sum of areas times normals| over the sum of the areas of the faces around each node [n]; 1 is flat."""
    total, area = np.zeros((count, 3)), np.zeros(count)
    corners = np.where(faces[:, 3] == faces[:, 2], 3, 4)
    for a in range(4):
        some = a < corners
        np.add.at(total, faces[some, a], vectors[some])
        np.add.at(area, faces[some, a], sizes[some])
    return np.asarray(np.linalg.norm(total, axis=1) / np.where(area > 0.0, area, 1.0))
