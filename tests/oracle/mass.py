"""Lumped mass, its redistribution away from the contact nodes, and area weights."""

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import dijkstra

from oracle.cells import assemble

SUPPORT_TOLERANCE = 1e-6


@dataclass(frozen=True)
class Redistribution:
    """Mass tensors [n, 3, 3] [kg] after the removal; `contact` [k] are the nodes of K, `basis` [k, 3, 3] has as
    columns the orthonormal directions the static solve may move a contact node in (zero where there are fewer)."""

    tensor: np.ndarray
    contact: np.ndarray
    basis: np.ndarray

    @property
    def removed(self):
        """Projector on the massless free components of every contact node [k, 3, 3]."""
        return self.basis @ np.swapaxes(self.basis, 1, 2)


def lumped_cell_mass(quad, density):
    """Row sums of the consistent mass of every cell [m, a] [kg]."""
    return density * np.einsum("mq,qa->ma", quad.weight, quad.shape)


def face_area_weights(nodes, faces):
    """A_k = integral of N_k over the faces in the reference state [n] [m^2]; [a, b, c, c] is a triangle."""
    if faces.shape[1] == 4 and (faces[:, 2] == faces[:, 3]).any():
        flat = faces[:, 2] == faces[:, 3]
        return face_area_weights(nodes, faces[flat, :3]) + face_area_weights(nodes, faces[~flat])
    corner = nodes[faces]
    if faces.shape[1] == 3:
        normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        weight = np.repeat(np.linalg.norm(normal, axis=1)[:, None] / 6, 3, axis=1)
    else:
        sign = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], dtype=float)
        point = sign / np.sqrt(3)
        factor = 1 + point[:, None, :] * sign
        shape = factor.prod(axis=2) / 4
        along = np.stack([sign[:, 0] * factor[..., 1], sign[:, 1] * factor[..., 0]], axis=2) / 4
        tangent = np.einsum("fai,qad->fqdi", corner, along)
        area = np.linalg.norm(np.cross(tangent[:, :, 0], tangent[:, :, 1]), axis=2)
        weight = area @ shape
    return assemble(faces, weight, len(nodes))


def node_graph(cells, node_count):
    """Nodes that share a cell, as a sparse matrix [n, n]."""
    rows = cells.ravel()
    columns = np.repeat(np.arange(len(cells)), cells.shape[1])
    incidence = sparse.csr_matrix((np.ones(len(rows)), (rows, columns)), shape=(node_count, len(cells)))
    graph = (incidence @ incidence.T).tocsr()
    graph.data[:] = 1
    return graph


def graph_distance(graph, sources):
    """Number of cells to pass from the nearest source to every node [n]."""
    if len(sources) == 0:
        return np.full(graph.shape[0], np.inf)
    return dijkstra(graph, unweighted=True, indices=sources, min_only=True)


def orthonormal(vectors):
    """Orthonormal columns [3, 3] that span the row vectors, zero columns at the end."""
    u, s, _ = np.linalg.svd(np.atleast_2d(vectors).T, full_matrices=False)
    basis = np.zeros((3, 3))
    rank = int(np.sum(s > 1e-9 * s[0]))
    basis[:, :rank] = u[:, :rank]
    return basis


def directions(free, normals, removal):
    """Removed directions, as columns, and movable ones of a contact node with free axes [3]; None if it leaves K."""
    reachable = [normal * free for normal in normals]
    reachable = [d / np.linalg.norm(d) for d in reachable if np.linalg.norm(d) >= SUPPORT_TOLERANCE]
    if not reachable:
        return None
    if removal == "full":
        return np.eye(3), np.diag(free)
    basis = orthonormal(np.array(reachable))
    return basis, basis


def layers(graph, level, first, depth):
    """Up to `depth` layers of nodes, each the neighbours of the one before that lie one level further from K."""
    found = [np.asarray(first)]
    while len(found) < depth:
        last = found[-1]
        near = np.unique(graph[last].indices)
        following = near[level[near] == level[last].max() + 1]
        if len(following) == 0:
            break
        found.append(following)
    return found


def redistribute(nodes, cells, cell_mass, contact, removal, normals, depth=1, free=None):
    """Take the mass of the contact nodes away and hand it to the others.

    cell_mass [m, a] [kg]; contact: node ids; removal: "full" or "normal"; normals [p, 3] of the planes; free [n, 3]:
    False on supported components. Raises ValueError when no node is left to carry the mass.
    """
    count = len(nodes)
    normals = np.atleast_2d(np.asarray(normals, dtype=float))
    free = np.ones((count, 3), bool) if free is None else free
    chosen = {}
    for k in np.unique(contact):
        found = directions(free[k].astype(float), normals, removal)
        if found is not None:
            chosen[int(k)] = found
    kept = np.array(sorted(chosen), dtype=int)
    in_contact = np.zeros(count, bool)
    in_contact[kept] = True
    if in_contact.all():
        raise ValueError("every node is a contact node: none is left to carry the mass")

    graph = node_graph(cells, count)
    level = graph_distance(graph, kept)
    tensor = assemble(cells, cell_mass, count)[:, None, None] * np.eye(3)
    for cell, masses in zip(cells, cell_mass, strict=True):
        for k, mass in zip(cell, masses, strict=True):
            if not in_contact[k]:
                continue
            inner = cell[~in_contact[cell]]
            if len(inner) == 0:
                steps = graph_distance(graph, [k])
                steps[in_contact] = np.inf
                inner = np.flatnonzero(steps == steps.min())
            for direction in chosen[int(k)][0].T:
                if not direction.any():
                    continue
                able = inner[np.all(free[inner] | (np.abs(direction) < 1e-12), axis=1)]
                shells = layers(graph, level, able if len(able) else inner, depth)
                part = np.outer(direction, direction) * mass
                tensor[k] -= part
                for shell in shells:
                    weight = 1 / np.linalg.norm(nodes[shell] - nodes[k], axis=1)
                    weight /= weight.sum() * len(shells)
                    np.add.at(tensor, shell, weight[:, None, None] * part)

    full_mass = assemble(cells, cell_mass, count)
    for k in kept:  # exact zeros instead of the rounding of a sum that cancels
        removed = chosen[int(k)][0]
        tensor[k] = full_mass[k] * (np.eye(3) - removed @ removed.T)
        tensor[k][np.abs(tensor[k]) < 1e-14 * full_mass[k]] = 0
    basis = np.array([chosen[int(k)][1] for k in kept]).reshape(-1, 3, 3)
    return Redistribution(tensor, kept, basis)


def choose_removal(nodes, faces, inward, normals):
    """The rule of `auto`: "normal" if all planes share one direction and all faces look at it within 15 degrees.

    inward [f, 3]: for every face a point inside the body, which tells its outer side.
    """
    normals = np.atleast_2d(normals)
    if np.any(np.abs(normals @ normals[0]) < 1 - 1e-9):
        return "full"
    corner = nodes[faces]
    outward = np.cross(corner[:, 1] - corner[:, 0], corner[:, -1] - corner[:, 0])
    outward /= np.linalg.norm(outward, axis=1)[:, None]
    outward *= np.where(np.sum(outward * (corner[:, 0] - inward), axis=1) < 0, -1, 1)[:, None]
    cosine = (-outward @ normals.T).max(axis=1)
    return "normal" if np.all(cosine >= np.cos(np.radians(15))) else "full"
