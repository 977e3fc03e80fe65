"""The order of the sweeps: contact nodes of one colour side by side in lanes, their matrix rows entry by entry.

Nodes of one colour do not couple, so a sweep may take several at once; rows are filled up to the longest of their pack
with entries of value zero.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from .contact_graph import ContactGraph
from .kernels.lanes import SWEEP_LANES as LANES


@dataclass(frozen=True)
class SweepOrder:
    """pack_start, lane_start [packs+1]: contact nodes and entries of a pack; column [entries, LANES].

    entry_place [e]: where entry e of the graph puts its block, values[entry_place + (i * block + j) * LANES]; the
    diagonal ones have no place (-1).
    """

    pack_start: np.ndarray
    lane_start: np.ndarray
    column: np.ndarray
    entry_place: np.ndarray


def sweep_order(graph: ContactGraph, block: int) -> SweepOrder:
    """Lanes for the nodes of a graph with blocks of block x block."""
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
        column[lane_start[number] : lane_start[number + 1]] = pack[0]  # filling: any node of the island will do
        for lane, node in enumerate(pack):
            entries = np.arange(graph.row_start[node] + 1, graph.row_start[node + 1])
            places = lane_start[number] + np.arange(len(entries))
            column[places, lane] = graph.column[entries]
            entry_place[entries] = places * block * block * LANES + lane
    pack_start = np.array([pack[0] for pack in packs] + [len(graph.nodes)])
    return SweepOrder(pack_start, lane_start, column, entry_place)
