"""The contact nodes of every part: which it solves, whose increments it needs, who shares out what a solve leaves.

The row of a contact node in K_KK (METHOD 2) couples it with the contact nodes of the cells round it. Its owner, the
lowest rank with a cell at it, has the whole row and solves it. Other contact nodes of its rows and of its cells are
owned by other ranks, which send their increments after each colour.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...base.errors import InputError
from ...mesh.geometry import Blocks, IntArray
from .parts import corners_of


@dataclass(frozen=True, eq=False)
class ContactPart:
    """The contact nodes of one rank, by their numbers in the whole mesh.

    rank; owned [k]: nodes whose rows it solves, ascending; ghosts: for every rank from which it receives increments,
    ascending, the nodes [g] that this rank owns; sent: for every rank to which it sends, the nodes [g] that it owns.
    """

    rank: int
    owned: IntArray
    ghosts: tuple[tuple[int, IntArray], ...]
    sent: tuple[tuple[int, IntArray], ...]


def _pairs_in_cells(blocks: Blocks, left: np.ndarray, right: np.ndarray) -> tuple[IntArray, IntArray, IntArray]:
    """Return the cell and the nodes of all pairs of a marked node `left` [n] and one `right` [n] in a cell."""
    cells, firsts, seconds, start = [], [], [], 0
    for _, rows in blocks:
        near = np.flatnonzero(left[rows].any(axis=1))
        local = rows[near]
        cell, first, second = np.nonzero(left[local][:, :, None] & right[local][:, None, :])
        cells.append(near[cell] + start)
        firsts.append(local[cell, first])
        seconds.append(local[cell, second])
        start += len(rows)
    return np.concatenate(cells), np.concatenate(firsts), np.concatenate(seconds)


def contact_part(blocks: Blocks, rank: IntArray, contact_nodes: IntArray, own: int) -> ContactPart:
    """Return the contact nodes of one rank.

    blocks: as `Mesh.blocks`; rank [m]: of every cell; contact_nodes [k]: all contact nodes; own: number of the rank.
    """
    count = 1 + max(int(rows.max()) for _, rows in blocks)
    marked = np.zeros(count, dtype=bool)
    marked[contact_nodes] = True
    cell, row, column = _pairs_in_cells(blocks, marked, marked)
    owner = np.full(count, np.iinfo(np.int64).max, dtype=np.int64)
    np.minimum.at(owner, row, rank[cell])
    needed = np.concatenate([owner[row], rank[cell]]) * count + np.concatenate([column, column])
    needs, of = np.divmod(np.unique(needed), count)  # a rank and a node it needs
    others = owner[of] != needs
    needs, of = needs[others], of[others]

    def listed(rows: IntArray, others: IntArray) -> tuple[tuple[int, IntArray], ...]:
        return tuple((int(other), of[rows & (others == other)]) for other in np.unique(others[rows]))

    owned = np.unique(contact_nodes)
    return ContactPart(
        own, owned[owner[owned] == own], listed(needs == own, owner[of]), listed(owner[of] == own, needs)
    )


def receiver_ranks(blocks: Blocks, rank: IntArray, contact: IntArray, receiver: IntArray) -> IntArray:
    """Return the rank that hands the residual of a contact node to a receiver, for every pair [p] of them.

    It is the lowest rank with a cell that has both, so that every share is added once. rank [m]: of every cell.
    Raises `InputError` for a pair without a common cell: no rank has both nodes.
    """
    count = 1 + int(corners_of(blocks)[1].max())
    left, right = np.zeros(count, dtype=bool), np.zeros(count, dtype=bool)
    left[contact], right[receiver] = True, True
    cell, first, second = _pairs_in_cells(blocks, left, right)
    order = np.lexsort((rank[cell], first * count + second))
    keys, place = np.unique((first * count + second)[order], return_index=True)
    wanted = contact * count + receiver
    found = np.minimum(np.searchsorted(keys, wanted), max(len(keys) - 1, 0))
    if len(wanted) and (not len(keys) or (keys[found] != wanted).any()):
        remedy = "a contact node shares no cell with a node that has mass; refine the mesh there or run on one rank"
        raise InputError("Scene.contact", "MasslessContact", remedy)
    return np.asarray(rank[cell[order[place[found]]]]) if len(wanted) else np.zeros(0, dtype=np.int64)
