"""The fixed sparsity of the tangent: 3x3 blocks between nodes that share a cell, and an order of cells for summing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Sparsity:
    """Sparsity of the tangent by rows.

    starts [n+1], columns [b] sorted within a row; diagonal [n]: places of the diagonal blocks;
    slots [m, corners, corners]: place of each pair of corners, -1 where a node is not among the unknowns; order [m]:
    cells colour by colour, colour_starts [colours+1]; node_starts [n+1], node_corners: cell corners of each node of
    the body, for sums of forces.
    """

    starts: np.ndarray
    columns: np.ndarray
    diagonal: np.ndarray
    slots: np.ndarray
    order: np.ndarray
    colour_starts: np.ndarray
    node_starts: np.ndarray
    node_corners: np.ndarray

    @property
    def rows(self) -> np.ndarray:
        """Rows of the blocks [b]."""
        return np.repeat(np.arange(len(self.diagonal)), np.diff(self.starts))


def sparsity_of(cells: np.ndarray, node_count: int, unknowns: np.ndarray | None = None) -> Sparsity:
    """Build the sparsity of cells [m, corners] of a body of node_count nodes.

    unknowns [k]: the nodes that have rows, in that order; None = all.
    """
    count = node_count if unknowns is None else len(unknowns)
    number = np.full(node_count, -1, dtype=np.int64)
    number[np.arange(node_count) if unknowns is None else unknowns] = np.arange(count)
    local = number[cells]
    left, right = np.broadcast_arrays(local[:, :, None], local[:, None, :])
    wanted = (left >= 0) & (right >= 0)
    own = np.arange(count) * (count + 1)
    keys, place = np.unique(
        np.concatenate([own, left[wanted] * count + right[wanted]]), return_inverse=True
    )  # every node has a diagonal block
    place = place.reshape(-1)
    slots = np.full(left.shape, -1, dtype=np.int32)
    slots[wanted] = place[count:]
    starts = np.searchsorted(keys, np.arange(count + 1) * count)
    order, colour_starts = colours(cells, node_count)
    flat = cells.reshape(-1)
    corners = np.argsort(flat, kind="stable")
    node_starts = np.concatenate([[0], np.cumsum(np.bincount(flat, minlength=node_count))])
    return Sparsity(starts, keys % count, place[:count], slots, order, colour_starts, node_starts, corners)


def colours(cells: np.ndarray, node_count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return cells [m] colour by colour and the start of each colour: cells of one colour share no node.

    Each cell in turn takes the first colour that none of its nodes has yet.
    """
    taken = [0] * node_count  # bits of the colours around a node
    chosen = np.empty(len(cells), dtype=np.int64)
    for index, cell in enumerate(cells.tolist()):
        union = 0
        for node in cell:
            union |= taken[node]
        bit = ~union & (union + 1)
        for node in cell:
            taken[node] |= bit
        chosen[index] = bit.bit_length() - 1
    order = np.argsort(chosen, kind="stable")
    return order, np.concatenate([[0], np.cumsum(np.bincount(chosen))])
