"""The largest eigenvalue of the matrix of springs, found in each set of springs that nodes or rigid parts connect.

The matrix is V V^T + sum_p T_p, with the share V [springs, nodes] of each spring in the motion of its nodes and terms
T_p of the springs at rigid part p. Springs that share neither nodes nor parts do not meet in it: its eigenvalues are
those of the blocks of connected springs. V V^T of a block has the eigenvalues of V^T V besides zeros, and none above
its trace, which is the eigenvalue where the block has one spring or one node.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np


class Shares(NamedTuple):
    """The entries of V: springs [e], nodes [e], values [e] [1/s], which add up where spring and node are the same.

    spring_count, node_count: numbers of springs and nodes.
    """

    springs: np.ndarray
    nodes: np.ndarray
    values: np.ndarray
    spring_count: int
    node_count: int


def largest_eigenvalue(shares: Shares, parts: Sequence[tuple[np.ndarray, np.ndarray]] = ()) -> float:
    """Return the largest eigenvalue [1/s^2] of V V^T + sum_p T_p; parts: springs [m] and terms [m, m] of each part."""
    shares = _summed(shares)
    block = _blocks(shares, parts)
    order = np.argsort(block[shares.springs], kind="stable")
    springs, nodes, values = (each[order] for each in (shares.springs, shares.nodes, shares.values))
    owner, count = block[springs], int(block.max()) + 1
    starts = np.searchsorted(owner, np.arange(count + 1))
    trace = np.bincount(owner, values * values, minlength=count)
    with_parts: dict[int, list[tuple[np.ndarray, np.ndarray]]] = {}
    for here, terms in parts:
        with_parts.setdefault(int(block[here[0]]), []).append((here, terms))
    largest = -np.inf
    for number in with_parts:
        own = np.flatnonzero(block == number)
        entries = slice(starts[number], starts[number + 1])
        dense = _dense(np.searchsorted(own, springs[entries]), nodes[entries], values[entries], len(own))
        matrix = dense @ dense.T
        for here, terms in with_parts[number]:
            rows = np.searchsorted(own, here)
            matrix[np.ix_(rows, rows)] += terms
        largest = max(largest, float(np.linalg.eigvalsh(matrix).max()))
    for number in np.argsort(-trace, kind="stable").tolist():
        if number in with_parts:
            continue
        if trace[number] <= largest:
            break
        entries = slice(starts[number], starts[number + 1])
        largest = max(largest, _alone(springs[entries], nodes[entries], values[entries], float(trace[number])))
    return largest


def _summed(shares: Shares) -> Shares:
    """Return the shares with one entry for each spring and node."""
    keys, place = np.unique(shares.springs * shares.node_count + shares.nodes, return_inverse=True)
    springs, nodes = np.divmod(keys, shares.node_count)
    return shares._replace(springs=springs, nodes=nodes, values=np.bincount(place.reshape(-1), shares.values))


def _blocks(shares: Shares, parts: Sequence[tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
    """Return for every spring the number of the block of connected springs that it belongs to."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    moved = shares.values != 0.0
    first = shares.spring_count + shares.node_count
    rows = [shares.springs[moved], *(here for here, _ in parts)]
    columns = [shares.spring_count + shares.nodes[moved]]
    columns += [np.full(len(here), first + number) for number, (here, _) in enumerate(parts)]
    ends = np.concatenate(rows), np.concatenate(columns)
    size = first + len(parts)
    graph = coo_array((np.ones(len(ends[0])), ends), shape=(size, size))
    label = connected_components(graph, directed=False)[1][: shares.spring_count]
    return np.unique(label, return_inverse=True)[1].reshape(-1)


def _alone(springs: np.ndarray, nodes: np.ndarray, values: np.ndarray, trace: float) -> float:
    """Return the largest eigenvalue of a block without rigid parts, of which the trace is known."""
    rows = np.unique(springs, return_inverse=True)[1].reshape(-1)
    moved = values != 0.0
    if rows.max() == 0 or len(np.unique(nodes[moved])) == 1:
        return trace
    dense = _dense(rows, nodes, values, int(rows.max()) + 1)
    small = dense @ dense.T if dense.shape[0] <= dense.shape[1] else dense.T @ dense
    return float(np.linalg.eigvalsh(small).max())


def _dense(rows: np.ndarray, nodes: np.ndarray, values: np.ndarray, count: int) -> np.ndarray:
    """Return V [count, m] of a block, for the m nodes that it has."""
    used, columns = np.unique(nodes, return_inverse=True)
    dense = np.zeros((count, len(used)))
    dense[rows, columns.reshape(-1)] = values
    return dense
