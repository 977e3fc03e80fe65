"""Mass redistribution from the contact nodes to their neighbours (METHOD 1, paper 4.2).

    Mbar_T = I_T M_T I_T^t,   w_i = dist(i, k)^-1 / sum_j dist(j, k)^-1   over the nodes i, j of cell T outside K

For row-sum lumped mass, with the mass m of node k in cell T and each massless direction b of k, this is
M_k -= m b b^t and M_i += w_i m b b^t. The total mass is exact and every M_i only grows.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..mesh.geometry import cells_at
from ..mesh.late_rows import Rows
from ..scene.periodic import Images
from .lumped_mass import NodeMasses
from .removal import MasslessNodes


@dataclass(frozen=True)
class Redistribution:
    """Mass tensors [k, 3, 3] [kg] of the nodes [k] that lost or gained mass; every other node keeps its scalar."""

    nodes: np.ndarray
    tensors: np.ndarray


class _Transfers:
    """Collects transfers (receiver, mass, direction) as arrays and sums them into tensors."""

    def __init__(self) -> None:
        self.parts: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []

    def add(self, receivers: np.ndarray, masses: np.ndarray, directions: np.ndarray) -> None:
        self.parts.append((receivers.reshape(-1), masses.reshape(-1), directions.reshape(-1, 3)))

    def tensors(self) -> tuple[np.ndarray, np.ndarray]:
        receivers, masses, directions = (np.concatenate(column) for column in zip(*self.parts, strict=True))
        nodes, slot = np.unique(receivers, return_inverse=True)
        tensors = np.zeros((len(nodes), 3, 3))
        np.add.at(tensors, slot.reshape(-1), masses[:, None, None] * directions[:, :, None] * directions[:, None, :])
        return nodes, tensors


def redistribute(masses: NodeMasses, massless: MasslessNodes, free: np.ndarray, depth: int = 1) -> Redistribution:
    """Return the mass tensors after the contact nodes have lost their mass to their neighbours.

    masses: those of the body; free [n, 3]: components without support (a supported neighbour receives only if the cell
    has no free one); depth: equal shares over that many layers of nodes, the first one inside the cell, weights
    1/distance inside a layer. Of a periodic body the masters alone lose and receive mass.
    """
    mesh, images = masses.body.mesh, masses.body.images
    slot = np.full(mesh.node_count, -1)
    slot[massless.nodes] = np.arange(len(massless.nodes))
    nodes, rows = mesh.node_rows, mesh.cell_rows
    named = rows if images is None else images.master[rows]
    cells_here = cells_at(slot >= 0, named)
    cells, share = named[cells_here], masses.of_cells(cells_here)
    cell, corner = np.nonzero(slot[cells] >= 0)  # one row per (cell, corner in K); a repeated corner has no mass
    donor = cells[cell, corner]
    around = cells[cell]  # [rows, corners]
    outside = slot[around] < 0
    if mesh.repeated is not None:
        outside &= ~mesh.repeated[cells_here][cell]
    places = nodes[rows[cells_here]][cell]  # where the corners are, not where their masters are
    distance = np.linalg.norm(places - places[np.arange(len(cell)), corner][:, None], axis=2)
    inverse = np.where(outside, 1.0 / np.where(outside, distance, 1.0), 0.0)
    graph = _Graph(named, slot)
    layers = graph.layer_count(massless.nodes, depth) if depth > 1 else np.ones(len(massless.nodes), dtype=int)
    transfers = _Transfers()
    for column in range(3):
        direction = massless.basis[slot[donor], :, column]
        has = np.abs(direction).any(axis=1)
        able = (free[around] | (np.abs(direction) <= 1e-6)[:, None, :]).all(axis=2)
        weight = np.where(able, inverse, 0.0)
        some: np.ndarray = weight.sum(axis=1) > 0.0
        weight = np.where(some[:, None], weight, inverse)
        total = weight.sum(axis=1)
        mass = share[cell, corner] / layers[slot[donor]]
        inner = has & (total > 0.0)
        rows = np.flatnonzero(inner)
        part = weight[rows] / total[rows][:, None] * mass[rows][:, None]
        row, receiver = np.nonzero(part)
        transfers.add(around[rows[row], receiver], part[row, receiver], direction[rows[row]])
        for lone in np.flatnonzero(has & (total == 0.0)):  # a cell without any node outside K
            near = graph.nearest(int(donor[lone]))
            weights = 1.0 / _distance(nodes[near] - nodes[donor[lone]], images)
            transfers.add(near, weights / weights.sum() * mass[lone], np.tile(direction[lone], (len(near), 1)))
    if depth > 1:
        whole = np.zeros(len(massless.nodes))
        np.add.at(whole, slot[donor], share[cell, corner])
        for index, node in enumerate(massless.nodes):
            for layer in graph.layers(int(node), int(layers[index]))[1:]:
                weights = 1.0 / _distance(nodes[layer] - nodes[node], images)
                part = weights / weights.sum() * whole[index] / layers[index]
                for direction in massless.basis[index].T[: massless.rank[index]]:
                    transfers.add(layer, part, np.tile(direction, (len(layer), 1)))
    receivers, gained = transfers.tensors()
    lumped = masses.total if images is None else images.total(masses.total)
    removed = np.einsum("kic,kjc->kij", massless.basis, massless.basis)
    kept = (
        np.where((massless.rank == 3)[:, None, None], 0.0, np.eye(3) - removed) * lumped[massless.nodes][:, None, None]
    )
    gained += lumped[receivers][:, None, None] * np.eye(3)
    return Redistribution(np.concatenate([massless.nodes, receivers]), np.concatenate([kept, gained]))


def _distance(difference: np.ndarray, images: Images | None) -> np.ndarray:
    return np.asarray(np.linalg.norm(difference if images is None else images.shortest(difference), axis=1))


class _Graph:
    """Neighbourhood of nodes through cells, for receivers that lie in other cells than the contact node."""

    def __init__(self, cells: Rows, slot: np.ndarray) -> None:
        self._rows, self.slot = cells, slot

    @cached_property
    def cells(self) -> np.ndarray:
        """All cells [m, corners]."""
        return np.asarray(self._rows)

    @cached_property
    def _around(self) -> tuple[np.ndarray, np.ndarray]:
        """Cells of each node in turn, and where those of each node start."""
        flat = self.cells.reshape(-1)
        owners = np.argsort(flat, kind="stable") // self.cells.shape[1]
        return owners, np.concatenate([[0], np.cumsum(np.bincount(flat, minlength=len(self.slot)))])

    def neighbours(self, nodes: np.ndarray) -> np.ndarray:
        """Return all nodes that share a cell with any of the nodes."""
        owners, start = self._around
        parts = [owners[start[node] : start[node + 1]] for node in nodes]
        return np.unique(self.cells[np.unique(np.concatenate(parts))])

    def nearest(self, node: int) -> np.ndarray:
        """Return the nodes with mass in the nearest graph layer around a node of K."""
        front = np.array([node])
        while True:
            front = self.neighbours(front)
            outside = front[self.slot[front] < 0]
            if len(outside):
                return outside

    def layers(self, node: int, depth: int) -> list[np.ndarray]:
        """Return the first `depth` layers of nodes with mass behind a node of K; fewer if the body ends."""
        found = [self.nearest(node)]
        for number in range(2, depth + 1):
            around = self.neighbours(found[-1])
            layer = around[self._levels[around] == number]
            if len(layer) == 0:
                break
            found.append(layer)
        return found

    def layer_count(self, nodes: np.ndarray, depth: int) -> np.ndarray:
        """Count the layers behind each node of K, at most `depth`."""
        return np.array([len(self.layers(int(node), depth)) for node in nodes])

    @cached_property
    def _levels(self) -> np.ndarray:
        """Graph distance of every node to K; -1 where no path leads there."""
        level = np.where(self.slot >= 0, 0, -1)
        reached, distance = self.slot >= 0, 0
        while (level < 0).any():
            distance += 1
            hit = reached[self.cells].any(axis=1)
            new = np.zeros_like(reached)
            new[self.cells[hit]] = True
            new &= ~reached
            if not new.any():
                break
            level[new] = distance
            reached |= new
        return level
