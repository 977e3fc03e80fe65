"""Coupling of a slave surface with its masters: weights P, normals and areas of the rows (METHOD 7).

    D_s = int phi_s dA,   M_sm = int phi_s N_m dA,   P = M / D,   over the part of the slave faces that is covered

phi = A N_s are dual functions on the covered part of a slave face e: A = diag(int N_s) (int N_s N_s^t)^-1. Linear
fields are reproduced exactly, so the gap is that at the node itself.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...device import arrays
from ...kernels import pair_places as at
from .surfaces import SMOOTH, Facing, area_vectors, flatness

COVERED = 1e-6  # area of a slave face that is covered, over its area, below which it takes no part
DROPPED = 1e-4  # area D of a row over the area of its node below which there is no row
SINGULAR = 1e-13  # smallest over largest eigenvalue of int N_s N_s^t below which a face has no dual functions
LARGEST_WEIGHT = 1e3  # beyond it the ordinary shape functions replace the dual ones of a face
SHARP, FLATTER = 0.95, 0.05  # a slave node below the first flatness takes the normal of masters flatter by the second
FAR = 3.0  # reach of a pair of faces over that of a slave face; of a slave face where surfaces came in fast
FLUSH = 0.05  # distance over the size of a slave face by which another surface may lie behind the closest one
FAST = 0.6  # way of two faces towards each other in a step over the reach, which is fast


@dataclass(frozen=True)
class Coupling:
    """Rows of a slave surface.

    slaves [r]: nodes of the domain, ascending; area [r] [m^2]: D; first [r + 1], masters, weights, bodies [e]: entries
    with the place of the body of the master; first_face [r + 1], faces [f, 4], face_weights [f]: the faces whose mean
    unit normal is the normal of a row; waiting [m]: distance of the nearest surface that has no rows yet as it lies
    behind another one over the same slave face.
    """

    slaves: np.ndarray
    area: np.ndarray
    first: np.ndarray
    masters: np.ndarray
    weights: np.ndarray
    bodies: np.ndarray
    first_face: np.ndarray
    faces: np.ndarray
    face_weights: np.ndarray
    waiting: float = np.inf

    def chosen(self, kept: np.ndarray) -> Coupling:
        """Return the rows of which `kept` [r] says so."""
        if kept.all():
            return self
        entries, faces = np.diff(self.first), np.diff(self.first_face)
        own, beside = np.repeat(kept, entries), np.repeat(kept, faces)
        return Coupling(
            self.slaves[kept],
            self.area[kept],
            starts(entries[kept]),
            self.masters[own],
            self.weights[own],
            self.bodies[own],
            starts(faces[kept]),
            self.faces[beside],
            self.face_weights[beside],
            self.waiting,
        )

    def normals(self, positions: np.ndarray) -> np.ndarray:
        """Return the unit normal [r, 3] of every row, into the slave, at positions [n, 3] [m]."""
        if not len(self.slaves):
            return np.zeros((0, 3))
        across = area_vectors(positions, self.faces)
        across *= (self.face_weights / np.linalg.norm(across, axis=1))[:, None]
        normal = np.add.reduceat(across, self.first_face[:-1])
        return np.asarray(normal / np.linalg.norm(normal, axis=1)[:, None])

    def gaps(self, positions: np.ndarray) -> np.ndarray:
        """Return the gap [r] [m] of every row at positions [n, 3] [m]."""
        if not len(self.slaves):
            return np.zeros(0)
        there = np.add.reduceat(self.weights[:, None] * positions[self.masters], self.first[:-1])
        return np.asarray(np.einsum("ri,ri->r", positions[self.slaves] - there, self.normals(positions)))


def starts(counts: np.ndarray) -> np.ndarray:
    """Return where each of parts of so many entries begins, and the end of the last one."""
    return np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)


def integrals(slaves: np.ndarray, masters: np.ndarray, pairs: np.ndarray) -> np.ndarray:
    """Return the integrals [p, INTEGRALS] of pairs [p, 2] of faces with corners [.., 4, 3] [m]."""
    from ...kernels.contact.clipping import make_clipping

    if not len(pairs):
        return np.zeros((0, at.INTEGRALS))
    given = [arrays.put(values) for values in (slaves, masters, pairs, np.zeros(len(pairs) * at.INTEGRALS))]
    make_clipping()(len(pairs), *given)
    return arrays.get(given[3]).reshape(-1, at.INTEGRALS)


def empty() -> Coupling:
    """Return no rows."""
    none, start = np.zeros(0, dtype=np.int64), np.zeros(1, dtype=np.int64)
    return Coupling(none, np.zeros(0), start, none, np.zeros(0), none, start, none.reshape(0, 4), np.zeros(0))


def couple(facing: Facing, positions: np.ndarray, pairs: np.ndarray, fast: bool = False) -> Coupling:
    """Return the rows of a slave surface at positions [n, 3] [m]; pairs [p, 2]: faces that may meet.

    fast: surfaces came in fast (`came_in_fast`): slave faces stand up to 3 reach deep in their masters.
    """
    if not len(pairs):
        return empty()
    nodes, local = facing.local
    found = _coupled(local, positions[nodes], pairs, fast)
    return replace(found, slaves=nodes[found.slaves], masters=nodes[found.masters], faces=nodes[found.faces])


def came_in_fast(facing: Facing, positions: np.ndarray, moved: np.ndarray, steps: int, pairs: np.ndarray) -> bool:
    """Return whether faces stand in others because they came a large part of the reach in a step.

    positions, moved [k, 3] [m]: of the nodes of all faces (`Facing.local`), and their way in so many steps up to there,
    NaN before the first rows; pairs [p, 2]: faces that may meet. What moves slowly comes within the reach of the rows
    first. In slow contact at edges other faces overlap too, which are not to count.
    """
    fast = FAST * facing.reach * max(steps, 1)
    if not len(pairs) or not 2.0 * np.linalg.norm(moved - moved.mean(axis=0), axis=1).max() > fast:
        return False
    local = facing.local[1]
    slave, masters = local.slave.faces, local.master_faces
    centre = positions[local.slave.nodes].mean(axis=0)
    found = integrals(positions[slave] - centre, positions[masters] - centre, pairs)
    ways = [moved[faces].mean(axis=1) for faces in (slave, masters)]
    normals = area_vectors(positions, slave)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    e, f = pairs.T
    came = np.einsum("pi,pi->p", ways[0][e] - ways[1][f], normals[e])
    inside = (found[:, at.COMMON_AREA] > 0.0) & (found[:, at.POINT_GAP] < 0.0)
    inside &= found[:, at.DISTANCE] <= np.minimum(2.0 * came / max(steps, 1), FAR * facing.reach)
    return bool((inside & (came > fast)).any())


def _coupled(facing: Facing, positions: np.ndarray, pairs: np.ndarray, fast: bool) -> Coupling:
    """Return the rows of `couple` where all nodes are those of the faces."""
    slave, masters = facing.slave.faces, facing.master_faces
    centre = positions[facing.slave.nodes].mean(axis=0)
    corners = [positions[faces] - centre for faces in (slave, masters)]
    found = integrals(corners[0], corners[1], pairs)
    face_areas = np.linalg.norm(area_vectors(positions, slave), axis=1)
    near = found[:, at.COMMON_AREA] > 0.0
    distance = found[:, at.DISTANCE]
    if fast:
        distance = np.where(found[:, at.POINT_GAP] < 0.0, distance / FAR, distance)
    seen = near & (found[:, at.DISTANCE] <= FAR * facing.reach)
    vectors = area_vectors(positions, masters)
    flat = flatness(masters, vectors, np.linalg.norm(vectors, axis=1), len(positions))
    near, waiting = _on_surfaces(facing, flat, pairs, seen, distance, found[:, at.POINT_GAP] < 0.0)
    covered = np.bincount(pairs[near, 0], found[near, at.COMMON_AREA], len(slave))
    near &= (covered > COVERED * face_areas)[pairs[:, 0]]
    pairs, found = pairs[near], found[near]
    e, f = pairs.T
    own = found[:, at.SLAVE_PRODUCTS : at.SLAVE_PRODUCTS + 16].reshape(-1, 4, 4)
    products = np.zeros((len(slave), 4, 4))
    np.add.at(products, e, own)
    dual, areas = _dual(products)
    mixed = found[:, at.MASTER_PRODUCTS : at.MASTER_PRODUCTS + 16].reshape(-1, 4, 4)
    blocks = dual[e] @ mixed
    area, of_node = _node_areas(facing, positions, areas)
    kept = area >= DROPPED * np.where(of_node > 0.0, of_node, np.inf)
    weights = np.abs(blocks) / np.where(kept, area, np.inf)[slave[e]][:, :, None]
    wild = np.zeros(len(slave), dtype=bool)
    wild[e[weights.reshape(-1, 16).max(axis=1, initial=0.0) > LARGEST_WEIGHT]] = True
    blocks[wild[e]] = mixed[wild[e]]
    shares = own.sum(axis=2)
    rows = _rows(facing, positions, flat, e, f, blocks, np.where(kept, area, 0.0), shares)
    rows = replace(rows, waiting=waiting)
    return rows.chosen(rows.gaps(positions) >= _least_gaps(facing, e, found, shares)[rows.slaves] - facing.reach)


def _on_surfaces(
    facing: Facing, flat: np.ndarray, pairs: np.ndarray, seen: np.ndarray, distance: np.ndarray, inside: np.ndarray
) -> tuple[np.ndarray, float]:
    """Return which pairs [p, 2] of those `seen` [p] take part, and the distance [m] of the nearest surface that waits.

    flat [n]: flatness of the masters' nodes; distance [p] [m], inside [p]: of the faces, and whether one stands in the
    other. Over a slave face, master faces that share nodes are one surface. One of another body, or behind a step,
    waits until it is hardly further than the closest one: the mean gap of both would press where nothing touches. Of a
    surface, what is out of reach takes part if faces lead there over smooth nodes from what is in reach: a curved
    surface falls away from a flat face.
    """
    masters, reach = facing.master_faces, facing.reach
    closest = np.full(len(facing.slave.faces), np.inf)
    np.minimum.at(closest, pairs[seen, 0], distance[seen])
    closest = closest[pairs[:, 0]]
    seen = seen & (closest <= reach)
    level = closest + FLUSH * facing.slave.size
    first = seen & ((distance <= level) | (inside & (distance <= reach)))
    mixed = np.zeros(len(facing.slave.faces), dtype=bool)
    mixed[pairs[seen & ~first, 0]] = True
    some = np.flatnonzero(seen & mixed[pairs[:, 0]])
    if not len(some):
        return seen, np.inf
    e, f = pairs[some].T
    corners = _unique((e[:, None] * len(flat) + masters[f]).reshape(-1))[1].reshape(-1, 4)
    surface = _spread(first[some], corners, np.ones(corners.shape, dtype=bool))
    within = surface & (distance[some] <= np.maximum(reach, level[some]))
    seen[some] = _spread(within, corners, flat[masters[f]] >= SMOOTH)
    return seen, float(distance[some[~surface]].min(initial=np.inf))


def _spread(start: np.ndarray, corners: np.ndarray, through: np.ndarray) -> np.ndarray:
    """Return which entries [k] are reached from those of `start` [k] over corners [k, 4] that they share.

    through [k, 4]: the corners by which an entry can be reached.
    """
    reached, found, before = np.zeros(1 + int(corners.max()), dtype=bool), start, -1
    while (count := int(found.sum())) > before:
        before = count
        reached[corners[found]] = True
        found = found | (reached[corners] & through).any(axis=1)
    return found


def _least_gaps(facing: Facing, e: np.ndarray, found: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """Return the smallest gap [n] [m] in the parts of the faces of every slave node that are covered.

    e [p], found [p, INTEGRALS], shares [p, 4] [m^2]: slave faces, integrals and int N_s of the pairs. The gap of a row
    is that at its node, to where it is extrapolated from a face of which only a far part is covered: at an edge that
    another face looks at from the side it may be a cell deep though nothing touches.
    """
    least = np.full(1 + int(facing.slave.nodes.max()), np.inf)
    gaps = np.minimum(found[:, at.POINT_GAP], found[:, at.CORNER_GAP])
    for corner, share in zip(facing.slave.faces[e].T, shares.T, strict=True):
        np.minimum.at(least, corner[share != 0.0], gaps[share != 0.0])
    return least


def deepest_point(facing: Facing, positions: np.ndarray, pairs: np.ndarray) -> tuple[float, np.ndarray]:
    """Return the smallest gap [m] of two faces along the normal of the slave's, inf without any, and where it is [3].

    Only faces within 3 reach of each other count; the place is the centre of the slave face.
    """
    corners = [positions[faces] for faces in (facing.slave.faces, facing.master_faces)]
    centre = positions[facing.slave.nodes].mean(axis=0)
    found = integrals(corners[0] - centre, corners[1] - centre, pairs)
    near = np.flatnonzero(found[:, at.DISTANCE] <= FAR * facing.reach)
    if not len(near):
        return np.inf, np.full(3, np.nan)
    deepest = near[found[near, at.POINT_GAP].argmin()]
    return float(found[deepest, at.POINT_GAP]), corners[0][pairs[deepest, 0]].mean(axis=0)


def _node_areas(facing: Facing, positions: np.ndarray, areas: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the covered area D [n] of every node, and the whole area of its faces that belongs to it [n] [m^2]."""
    slave = facing.slave.faces
    sizes = np.linalg.norm(area_vectors(positions, slave), axis=1)
    corners = np.where(slave[:, 3] == slave[:, 2], 3, 4)
    covered, whole = np.zeros(len(positions)), np.zeros(len(positions))
    np.add.at(covered, slave, areas)
    np.add.at(whole, slave, np.where((np.arange(4) < corners[:, None]), (sizes / corners)[:, None], 0.0))
    return covered, whole


def _dual(products: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return A [f, 4, 4] = diag(D) M^-1 of faces with M [f, 4, 4], and D [f, 4]; a missing corner has only zeros."""
    areas = products.sum(axis=2)
    filled = products.copy()
    corner = np.arange(4)
    scale = products[:, corner, corner].max(axis=1, initial=0.0)
    empty = products[:, corner, corner] <= 0.0
    filled[:, corner, corner] += np.where(empty, np.where(scale > 0.0, scale, 1.0)[:, None], 0.0)
    values = np.linalg.eigvalsh(filled)
    singular = values[:, 0] <= SINGULAR * values[:, -1]  # to rounding: the ordinary shape functions, A = 1
    filled[singular] = np.eye(4)
    inverse = np.linalg.inv(filled)
    return np.where(singular[:, None, None], inverse, areas[:, :, None] * inverse), areas


def _rows(
    facing: Facing,
    positions: np.ndarray,
    flat: np.ndarray,
    e: np.ndarray,
    f: np.ndarray,
    blocks: np.ndarray,
    area: np.ndarray,
    shares: np.ndarray,
) -> Coupling:
    slave, masters = facing.slave.faces, facing.master_faces
    count = len(positions)
    vectors = area_vectors(positions, slave)
    sizes = np.linalg.norm(vectors, axis=1)
    slaves = np.flatnonzero(area > 0.0)
    row = np.full(count, -1)
    row[slaves] = np.arange(len(slaves))

    rows = np.broadcast_to(row[slave[e]][:, :, None], blocks.shape).reshape(-1)
    nodes = np.broadcast_to(masters[f][:, None, :], blocks.shape).reshape(-1)
    values = blocks.reshape(-1)
    there = (rows >= 0) & (values != 0.0)
    key, place = _unique(rows[there] * count + nodes[there])
    total = np.bincount(place, values[there], len(key))
    owner = np.zeros(count, dtype=np.int64)
    owner[masters] = facing.master_bodies[:, None]
    r, node = np.divmod(key, count)
    first = np.searchsorted(r, np.arange(len(slaves) + 1))

    faces, face_weights, first_face = _normals(facing, flat, slaves, row, e, f, shares, vectors, sizes)
    return Coupling(
        slaves, area[slaves], first, node, total / area[slaves][r], owner[node], first_face, faces, face_weights
    )


def _unique(keys: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the keys [k], below 2^63 / k, in order and each once, and the place of every key there."""
    order = np.sort(keys * len(keys) + np.arange(len(keys)))
    sorted_keys, places = np.divmod(order, max(1, len(keys)))
    new = np.concatenate([[True], sorted_keys[1:] != sorted_keys[:-1]])[: len(keys)]
    result = np.empty(len(keys), dtype=np.int64)
    result[places] = np.cumsum(new) - 1
    return sorted_keys[new], result


def _normals(
    facing: Facing,
    flat: np.ndarray,
    slaves: np.ndarray,
    row: np.ndarray,
    e: np.ndarray,
    f: np.ndarray,
    shares: np.ndarray,
    vectors: np.ndarray,
    sizes: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return faces, their weights and the first face of every row.

    The normal of a row is the inward one of the slave's faces around the node, unless the node is sharp. Then it is the
    outward one of the master's faces that cover these, if the master is flatter there, and else the mean of both, the
    slave's faces weighted by their covered area: the free sides of edges that lie flush on each other do not count.
    """
    slave, masters = facing.slave.faces, facing.master_faces
    own_flat = flatness(slave, vectors, sizes, len(flat))
    least = np.full(len(slaves), np.inf)
    covered = row[slave[e]]
    for a in range(4):
        some = (covered[:, a] >= 0) & (shares[:, a] != 0.0)
        np.minimum.at(least, covered[some, a], flat[masters[f[some]]].min(axis=1))
    edge = own_flat[slaves] < SHARP
    sharp = edge & (least > own_flat[slaves] + FLATTER) & np.isfinite(least)
    areas = np.bincount(e, shares.sum(axis=1), len(slave))

    rows, faces, weights = [], [], []
    corners = np.where(slave[:, 3] == slave[:, 2], 3, 4)
    for a in range(4):
        some = np.flatnonzero((row[slave[:, a]] >= 0) & (a < corners))
        some = some[~sharp[row[slave[some, a]]]]
        rows.append(row[slave[some, a]])
        faces.append(slave[some])
        weights.append(-np.where(edge[row[slave[some, a]]], areas[some], sizes[some]))
        some = np.flatnonzero((covered[:, a] >= 0) & (shares[:, a] != 0.0))
        some = some[edge[covered[some, a]]]
        rows.append(covered[some, a])
        faces.append(masters[f[some]])
        weights.append(shares[some, a])
    of = np.concatenate(rows)
    order = np.argsort(of, kind="stable")
    first = np.searchsorted(of[order], np.arange(len(slaves) + 1))
    return np.concatenate(faces)[order], np.concatenate(weights)[order], first
