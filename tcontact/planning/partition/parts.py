"""The nodes of every part of a cut mesh, and what the parts share.

A node on a cut has a copy in every part with a cell at it. Its owner is the lowest rank with a copy: sums over nodes
(energy, momentum) count it there. Forces of copies are added in the order of the ranks by every copy, which then have
equal bits.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...mesh.geometry import Blocks, IntArray


@dataclass(frozen=True, eq=False)
class Part:
    """What one rank has of a mesh; nodes and cells by their numbers in the whole mesh, ascending.

    rank; cells [m]; nodes [n]; owner [n]: the rank that owns each node; shared: for every rank with copies of its
    nodes, ascending, the places [k] in `nodes` of these, in the order that both ranks have.
    """

    rank: int
    cells: IntArray
    nodes: IntArray
    owner: IntArray
    shared: tuple[tuple[int, IntArray], ...]

    @property
    def owned(self) -> IntArray:
        """Places [k] in `nodes` of the nodes that this rank owns."""
        return np.flatnonzero(self.owner == self.rank)

    @property
    def copies(self) -> IntArray:
        """Places [k] in `nodes` of those of which other ranks have copies, ascending."""
        return np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *(places for _, places in self.shared)]))


def corners_of(blocks: Blocks) -> tuple[IntArray, IntArray]:
    """Return the cell and the node of every corner of a mesh, cell by cell."""
    cells, nodes, first = [], [], 0
    for _, rows in blocks:
        cells.append(np.repeat(np.arange(first, first + len(rows)), rows.shape[1]))
        nodes.append(rows.reshape(-1))
        first += len(rows)
    return np.concatenate(cells), np.concatenate(nodes)


def parts_of(blocks: Blocks, node_count: int, rank: IntArray) -> tuple[Part, ...]:
    """Return the parts of a mesh; blocks: as `Mesh.blocks`, rank [m]: of every cell (`cut.cut_cells`)."""
    cell, node = corners_of(blocks)
    ranks = int(rank.max()) + 1
    copies = np.unique(node * ranks + rank[cell])  # by node, then by rank
    at, having = np.divmod(copies, ranks)
    owner = np.full(node_count, -1, dtype=np.int64)
    owner[at[::-1]] = having[::-1]  # the lowest rank is written last
    found = []
    several = np.bincount(at, minlength=node_count) > 1
    at_cut, having_cut = at[several[at]], having[several[at]]
    for own in range(ranks):
        nodes = at[having == own]
        mine = np.zeros(node_count, dtype=bool)
        mine[at_cut[having_cut == own]] = True
        near = mine[at_cut] & (having_cut != own)
        shared = tuple(
            (int(other), np.searchsorted(nodes, at_cut[near & (having_cut == other)]))
            for other in np.unique(having_cut[near])
        )
        found.append(Part(own, np.flatnonzero(rank == own), nodes, owner[nodes], shared))
    return tuple(found)
