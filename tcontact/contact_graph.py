"""The surface problem as index arrays: contact-touching cells, the graph of contact nodes, its colouring.

Built once per body, by brute numpy; the kernels only walk these lists.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class ContactGraph:
    """Contact nodes are numbered 0..k-1 colour by colour; an entry is a block (row node, column node) of K_KK.

    nodes [k]: node ids; colour_start [colours]: first node of each colour; cells [c]: contact-touching cells;
    pair_start [c+1], pair_corners [p, 2], pair_nodes [p, 2]: per cell its pairs of corners in K and their numbers;
    row_start [k+1], column [e]: block rows of K_KK, the diagonal entry first; entry_start [e+1], entry_pairs [p]: the
    pairs that add up to an entry; corner_start [k+1], corners [..]: the cell corners (cell * width + corner) of a node.
    """

    nodes: np.ndarray
    colour_start: np.ndarray
    cells: np.ndarray
    pair_start: np.ndarray
    pair_corners: np.ndarray
    pair_nodes: np.ndarray
    row_start: np.ndarray
    column: np.ndarray
    entry_start: np.ndarray
    entry_pairs: np.ndarray
    corner_start: np.ndarray
    corners: np.ndarray

    @property
    def colours(self) -> int:
        """Number of colours."""
        return len(self.colour_start)


def contact_graph(cells: np.ndarray, nodes: np.ndarray, node_count: int) -> ContactGraph:
    """Graph of the contact nodes [k] in a body with the given cells [m, corners]."""
    slot = np.full(node_count, -1)
    slot[nodes] = np.arange(len(nodes))
    touched = np.flatnonzero((slot[cells] >= 0).any(axis=1))
    colour = _colours(slot[cells[touched]], len(nodes))
    order = np.lexsort((nodes, colour))
    nodes = nodes[order]
    slot[nodes] = np.arange(len(nodes))
    local = slot[cells[touched]]  # [c, corners]
    width = cells.shape[1]

    first, second = np.meshgrid(np.arange(width), np.arange(width), indexing="ij")
    both = (local[:, first.ravel()] >= 0) & (local[:, second.ravel()] >= 0)  # [c, width^2]
    cell, pair = np.nonzero(both)
    corners = np.stack([first.ravel()[pair], second.ravel()[pair]], axis=1)
    numbers = np.stack([local[cell, corners[:, 0]], local[cell, corners[:, 1]]], axis=1)
    key = numbers[:, 0] * (len(nodes) + 1) + np.where(numbers[:, 0] == numbers[:, 1], 0, numbers[:, 1] + 1)
    unique, entry = np.unique(key, return_inverse=True)
    row, shifted = np.divmod(unique, len(nodes) + 1)
    corner_cell, corner = np.nonzero(local >= 0)
    corner_node = local[corner_cell, corner]
    by_node = np.argsort(corner_node, kind="stable")
    return ContactGraph(
        nodes=nodes,
        colour_start=_starts(colour, int(colour.max(initial=0)) + 1)[:-1],
        cells=touched,
        pair_start=_starts(cell, len(touched)),
        pair_corners=corners,
        pair_nodes=numbers,
        row_start=_starts(row, len(nodes)),
        column=np.where(shifted == 0, row, shifted - 1),
        entry_start=_starts(entry.reshape(-1), len(unique)),
        entry_pairs=np.argsort(entry.reshape(-1), kind="stable"),
        corner_start=_starts(corner_node, len(nodes)),
        corners=(corner_cell * width + corner)[by_node],
    )


def _starts(owner: np.ndarray, count: int) -> np.ndarray:
    return np.concatenate([[0], np.cumsum(np.bincount(owner, minlength=count))])


def _colours(local: np.ndarray, count: int) -> np.ndarray:
    """Greedy colouring of the graph whose edges join contact nodes of one cell."""
    neighbours: list[set[int]] = [set() for _ in range(count)]
    for row in local.tolist():
        members = [node for node in row if node >= 0]
        for node in members:
            neighbours[node].update(members)
    colour = np.full(count, -1)
    for node in range(count):
        used = {colour[other] for other in neighbours[node] if other != node}
        colour[node] = next(number for number in range(len(used) + 1) if number not in used)
    return colour
