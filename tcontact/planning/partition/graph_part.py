"""The part of a contact graph that one rank has: whole rows of its own nodes, parts of rows of its copies.

A rank computes the blocks of K_KK of its own cells. The entries of a row that it owns are those of the whole graph, in
their order; those of a row of another rank are the ones to which its cells contribute, which it sends there.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..contact_graph import ContactGraph


def ranges(start: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """Return the numbers start[i] .. start[i + 1] of every chosen i, one range after another."""
    lengths = start[chosen + 1] - start[chosen]
    before = np.concatenate([[0], np.cumsum(lengths)])[:-1]
    return np.arange(int(lengths.sum())) + np.repeat(start[chosen] - before, lengths)


def _starts(lengths: np.ndarray) -> np.ndarray:
    return np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64)


def graph_part(
    graph: ContactGraph,
    nodes: np.ndarray,
    owned: np.ndarray,
    ghosts: np.ndarray,
    cells: np.ndarray,
) -> tuple[ContactGraph, np.ndarray]:
    """Return the graph of some nodes, and the number in the whole graph of each of its entries [e].

    nodes [k]: numbers in the whole graph; owned [k]: whether this rank solves for them; ghosts [g]: other nodes of the
    rows of these, which stand behind the nodes in `column`; cells [c]: numbers of the contact cells of this rank.
    Node ids and cells of the result are those of the whole graph; its colours begin where the colour changes, or where
    nodes of other ranks begin.
    """
    place = np.full(len(graph.nodes), -1, dtype=np.int64)
    place[nodes] = np.arange(len(nodes))
    place[ghosts] = len(nodes) + np.arange(len(ghosts))
    kept = ranges(graph.pair_start, cells)
    pair = np.full(len(graph.pair_nodes), -1, dtype=np.int64)
    pair[kept] = np.arange(len(kept))

    row = np.repeat(np.arange(len(nodes)), graph.row_start[nodes + 1] - graph.row_start[nodes])
    entries = ranges(graph.row_start, nodes)
    lengths = graph.entry_start[entries + 1] - graph.entry_start[entries]
    sources = graph.entry_pairs[ranges(graph.entry_start, entries)]
    entry = np.repeat(np.arange(len(entries)), lengths)
    number = pair[np.where(sources < 0, -1 - sources, sources)]
    here = number >= 0
    count = np.bincount(entry[here], minlength=len(entries))
    stays = owned[row] | (count > 0)
    colour = np.searchsorted(graph.colour_start, nodes, side="right")
    key = np.where(owned, colour, -1)
    found = replace(
        graph,
        nodes=graph.nodes[nodes],
        colour_start=np.flatnonzero(np.concatenate([[True], key[1:] != key[:-1]]))[: len(nodes)],
        cells=graph.cells[cells],
        pair_start=_starts(graph.pair_start[cells + 1] - graph.pair_start[cells]),
        pair_corners=graph.pair_corners[kept],
        pair_nodes=place[graph.pair_nodes[kept]],
        row_start=_starts(np.bincount(row[stays], minlength=len(nodes))),
        column=place[graph.column[entries[stays]]],
        entry_start=_starts(count[stays]),
        entry_pairs=np.where(sources < 0, -1 - number, number)[here],
    )
    return found, entries[stays]
