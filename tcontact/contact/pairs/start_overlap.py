"""Refuse bodies of a pair that overlap at the start where no row of contact holds them apart.

Rows exist between faces that look at each other within reach. Bodies may overlap beside them: by an edge or a corner,
with sides that lie in one plane, or one within the other. The cells at both surfaces show it, and a node of each piece.
"""

from __future__ import annotations

import numpy as np

from ...base.errors import InputError
from ...mesh.geometry import cells_at
from ...mesh.hull_overlap import Hulls, Overlaps, hulls_of, overlaps
from ...mesh.triangle_distance import pieces_inside, point_to_triangle, triangles_of
from ...planning.domain import Domain
from .coupling import Coupling
from .surfaces import SMOOTH, Facing, area_vectors, flatness

SEEN = 2.0  # overlap of two cells along the normal of a row between them over the reach that is left to the row
FLAT = 1.0 - 1e-9  # flatness of a node below which the surface bends there
SHALLOW = 0.4  # overlap of two cells over their thickness up to which it is that of the bodies
WAYS = 256  # most directions in which the way out of an overlap is measured


def refuse_overlaps(
    domain: Domain, facing: Facing, rows: Coupling, positions: np.ndarray, least: float, held: float
) -> None:
    """Refuse a slave that starts more than `least` [m] inside one of its masters. Raises `InputError`.

    positions [n, 3] [m]; rows: those of the slave at the start; held: overlap [m] that a row may have there, as then
    that of cells beside it. Cells that overlap by little along the normal of a row of the slave's cell are left to it:
    facets of curved surfaces do, and an edge that another run has pressed into a face. Where surfaces are curved, cells
    may overlap by the sagitta of their facets.
    """
    slave = facing.slave.body
    rows = rows.chosen(rows.gaps(positions) >= -max(held, facing.closed))
    row = np.full(len(positions), -1)
    row[rows.slaves] = np.arange(len(rows.slaves))
    deep = max(SEEN * facing.reach, held)
    for master in np.unique(facing.master_bodies):
        allowed = max(held if (rows.bodies == master).any() else least, facing.closed)
        boxes = [_box(domain, body, positions) for body in (slave, int(master))]
        if not (np.minimum(boxes[0][1], boxes[1][1]) - np.maximum(boxes[0][0], boxes[1][0]) > allowed).all():
            continue
        (own, nodes), (others, _) = (_surface_cells(domain, body, facing, positions) for body in (slave, int(master)))
        found = overlaps(own, others, allowed)
        free = ~_left_to_rows(found, own, others, row[nodes], rows.normals(positions), deep)
        found = Overlaps(*(part[free] for part in found))
        if len(found.pairs):
            depth, place = _extent(found, own, others)
        else:
            inner = _nested(domain, slave, int(master), positions, allowed)
            if inner is None:
                continue
            depth, place = inner
        where = ", ".join(f"{part:.4g}" for part in place)
        master_label, label = domain.bodies[int(master)].label, domain.bodies[slave].label
        remedy = f"it starts {depth:.3g} m inside {master_label} near ({where}), where no contact"
        raise InputError("Scene.bodies", label, f"{remedy} of faces holds them: move them apart (mesh.translated)")


def _box(domain: Domain, body: int, positions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the lowest and highest corner [3] [m] of a body of the domain."""
    own = positions[domain.node_start[body] : domain.node_start[body + 1]]
    return own.min(axis=0), own.max(axis=0)


def _surface_cells(domain: Domain, body: int, facing: Facing, positions: np.ndarray) -> tuple[Hulls, np.ndarray]:
    """Return the hulls of the cells with a node on the surface of a body, and their nodes [k, 8] in the domain.

    Those with a node where contact faces bend smoothly may overlap by the sagitta.
    """
    plan, first = domain.bodies[body], int(domain.node_start[body])
    outer = np.zeros(plan.node_count, dtype=bool)
    outer[plan.place[np.unique(plan.body.mesh.boundary_faces())]] = True
    found, numbers = [], []
    for block in plan.blocks:
        cells = block.rows[cells_at(outer, block.rows)]
        found.append((block.own.facts.kind, positions[first + cells], outer[cells]))
        numbers.append(first + cells[:, np.minimum(np.arange(8), cells.shape[1] - 1)])
    hulls, nodes = hulls_of(found), np.concatenate(numbers)
    curved = np.zeros(len(positions), dtype=bool)
    for faces in (facing.slave.faces, facing.master_faces):
        vectors = area_vectors(domain.reference, faces)
        flat = flatness(faces, vectors, np.linalg.norm(vectors, axis=1), len(positions))
        curved |= (flat >= SMOOTH) & (flat < FLAT)
    return hulls._replace(slack=hulls.slack + np.where(curved[nodes].any(axis=1), facing.sagitta, 0.0)), nodes


def _left_to_rows(
    found: Overlaps, own: Hulls, others: Hulls, row: np.ndarray, normals: np.ndarray, deep: float
) -> np.ndarray:
    """Return for every overlap [p] whether a row of the slave's cell is there, along whose normal it is not deep.

    row [k, 8]: rows of the corners of the slave's cells, -1 without; normals [r, 3]: those of the rows.
    """
    if not len(found.pairs) or not len(normals):
        return np.zeros(len(found.pairs), dtype=bool)
    mine = row[found.pairs[:, 0]]
    into = np.where((mine >= 0)[:, :, None], normals[mine], 0.0)
    low = np.einsum("pai,pci->pac", into, own.points[found.pairs[:, 0]]).min(axis=2)
    high = np.einsum("pai,pci->pac", into, others.points[found.pairs[:, 1]]).max(axis=2)
    return np.asarray(((mine >= 0) & (high - low <= deep)).any(axis=1))


def _extent(found: Overlaps, own: Hulls, others: Hulls) -> tuple[float, np.ndarray]:
    """Return how far [m] the cells of the slave have to move to leave those of its master, and a place [3] there.

    The deepest overlap of two of them, unless it is as deep as a cell: then the shortest way along normals of faces of
    all of these cells.
    """
    deepest = found.depth.argmax()
    pair = [hulls.points[number] for hulls, number in zip((own, others), found.pairs[deepest], strict=True)]
    low, high = np.max([one.min(axis=0) for one in pair], axis=0), np.min([one.max(axis=0) for one in pair], axis=0)
    place = 0.5 * (low + high)
    normals = [hulls.normals[number] for hulls, number in zip((own, others), found.pairs[deepest], strict=True)]
    thick = min(
        float(np.ptp(one @ axes[axes.any(axis=1)].T, axis=0).min()) for one, axes in zip(pair, normals, strict=True)
    )
    if found.depth[deepest] <= SHALLOW * thick:
        return float(found.depth[deepest]), place
    mine, theirs = (np.unique(part) for part in found.pairs.T)
    ways = np.concatenate([own.normals[mine], others.normals[theirs]]).reshape(-1, 3)
    ways = np.unique(np.round(ways[ways.any(axis=1)], 6), axis=0)
    ways = ways[:: -(-len(ways) // WAYS)]
    ways = np.concatenate([ways, -ways])
    end = (others.points[theirs] @ ways.T).max(axis=(0, 1))
    start = (own.points[mine] @ ways.T).min(axis=(0, 1))
    return float((end - start).min()), place


def _nested(
    domain: Domain, slave: int, master: int, positions: np.ndarray, least: float
) -> tuple[float, np.ndarray] | None:
    """Return how deep [m] a piece of one body lies in the other, and a node [3] of it; None without any.

    One node of a piece decides, as no surfaces cut.
    """
    points, triangles = [], []
    for body in (slave, master):
        plan, first = domain.bodies[body], int(domain.node_start[body])
        faces = plan.place[plan.body.mesh.boundary_faces()]
        nodes, numbers = np.unique(faces, return_inverse=True)
        points.append(positions[first + nodes])
        triangles.append(triangles_of(numbers.reshape(faces.shape)))
    for one, other in ((0, 1), (1, 0)):
        around = points[other][triangles[other]]
        for node in pieces_inside(points[one], triangles[one], around):
            depth = float(point_to_triangle(np.broadcast_to(node, (len(around), 3)), around).min())
            if depth > least:
                return depth, node
    return None
