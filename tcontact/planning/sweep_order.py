"""Order the sweeps: contact nodes of one colour stand side by side in lanes, their matrix rows entry by entry.

Nodes of one colour do not couple, so a sweep takes several at once; rows are filled up with zeros to the longest of
their pack.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ..kernels.lanes import SWEEP_LANES as LANES
from .contact_graph import ContactGraph


@dataclass(frozen=True)
class SweepOrder:
    """Packs of contact nodes and the places of their matrix entries.

    pack_start, lane_start [packs+1]: first contact node and entry of a pack; column [entries, LANES]: contact node of
    an entry; entry_place [e]: block of entry e of the graph, values[entry_place + (i * block + j) * LANES], -1 for
    diagonal ones.
    """

    pack_start: np.ndarray
    lane_start: np.ndarray
    column: np.ndarray
    entry_place: np.ndarray


def sweep_order(graph: ContactGraph, block: int) -> SweepOrder:
    """Arrange the nodes of a graph in lanes; its matrix entries are blocks of block x block."""
    starts = [*graph.colour_start, len(graph.nodes)]
    packs = [
        np.arange(first, min(first + LANES, end))
        for begin, end in pairwise(starts)
        for first in range(begin, end, LANES)
    ]
    others = np.diff(graph.row_start) - 1  # entries of a row off the diagonal
    lengths = [int(others[pack].max()) for pack in packs]
    lane_start = np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64)
    column = np.zeros((int(lane_start[-1]), LANES), dtype=np.int64)
    entry_place = np.full(len(graph.column), -1)
    for number, pack in enumerate(packs):
        # filling: any node of the island is right, and its own node is one that no other thread of a GPU changes
        column[lane_start[number] : lane_start[number + 1]] = np.resize(pack, LANES)
        for lane, node in enumerate(pack):
            entries = np.arange(graph.row_start[node] + 1, graph.row_start[node + 1])
            places = lane_start[number] + np.arange(len(entries))
            column[places, lane] = graph.column[entries]
            entry_place[entries] = places * block * block * LANES + lane
    pack_start = np.array([pack[0] for pack in packs] + [len(graph.nodes)])
    return SweepOrder(pack_start, lane_start, column, entry_place)
