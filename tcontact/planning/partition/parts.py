"""The nodes of every part of a cut mesh, and what the parts share.

A node on a cut has a copy in every part with a cell at it. Its owner is the lowest rank with a copy: sums over nodes
(energy, momentum) count it there. Forces of copies are added in the order of the ranks by every copy, which then have
equal bits.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...mesh.geometry import Blocks, IntArray, cells_at


@dataclass(frozen=True, eq=False)
class Part:
    """What one rank has of a mesh; nodes and cells by their numbers in the whole mesh, ascending.

    rank; cells [m]; nodes [n]; owner [n]: the rank that owns each node; shared: for every rank with copies of its
    nodes, ascending, the places [k] in `nodes` of these, in the order that both ranks have.
    """

    rank: int
    cells: NDArray[np.integer]
    nodes: IntArray
    owner: NDArray[np.integer]
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


def part_of_rank(
    blocks: Iterable[tuple[str, IntArray]],
    node_count: int,
    rank: IntArray,
    own: int,
    common: IntArray | None = None,
    among: Sequence[int] = (),
) -> Part:
    """Return what one rank has of a mesh.

    blocks: as `Mesh.cell_portions`; rank [m]: of every cell (`cut.cut_cells`); own: number of the rank; common [k]:
    nodes of which all the ranks `among` have copies, with cells there or without.
    """
    mine = np.zeros(node_count, dtype=bool)
    common = np.zeros(0, dtype=np.int64) if common is None else common
    if own in among:
        mine[common] = True
    for rows, ranks in _with_ranks(blocks, rank):
        mine[rows[ranks == own]] = True
    nodes, count, copies = np.flatnonzero(mine), max([int(rank.max()), *among]) + 1, []
    for rows, ranks in _with_ranks(blocks, rank):
        near = cells_at(mine, rows)
        near = near[ranks[near] != own]
        at, other = rows[near], np.broadcast_to(ranks[near, None], (len(near), rows.shape[1]))
        copies.append((at * count + other)[mine[at]])
    copies += [common[mine[common]] * count + other for other in among if other != own]
    at, others = np.divmod(np.unique(np.concatenate(copies)), count)  # copies by node, then by rank
    places = np.searchsorted(nodes, at)
    owner = np.full(len(nodes), own, dtype=np.int32)
    np.minimum.at(owner, places, others.astype(np.int32))
    shared = tuple((int(other), places[others == other]) for other in np.unique(others))
    return Part(own, np.flatnonzero(rank == own).astype(np.int32), nodes.astype(np.int32), owner, shared)


def _with_ranks(blocks: Iterable[tuple[str, IntArray]], rank: IntArray) -> Iterator[tuple[IntArray, IntArray]]:
    """Yield the cells [k, corners] of every portion with their ranks [k]."""
    first = 0
    for _, rows in blocks:
        yield rows, rank[first : first + len(rows)]
        first += len(rows)


def parts_of(blocks: Blocks, node_count: int, rank: IntArray) -> tuple[Part, ...]:
    """Return the parts of all ranks, see `part_of_rank`."""
    return tuple(part_of_rank(blocks, node_count, rank, own) for own in range(int(rank.max()) + 1))
