"""Cut a mesh into parts of equal work, the cells of the contact face first.

A step lasts as long as the largest number of cells of a rank plus the largest contact work of a rank, because the
static solve keeps the contact ranks in lock step. With c contact cells of extra work w among m cells and P ranks, the
fewest contact ranks whose contact work fits into the mean work of a rank are

    q = c (1 + w) / ((m + w c)/P), rounded up, at least 1 and at most P.

The contact cells are cut into q equal patches, every patch takes layers of cells behind it until its rank has the mean
work, and the remaining cells are cut into P - q parts. METIS (Karypis and Kumar 1998) cuts patches and remaining cells.

Ranks that share a contact exchange the increments of its nodes after each colour of a sweep, which costs as much as
some thousand nodes: `contact_ranks` chooses the number of ranks with the shortest step.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ...base.errors import InputError
from ...mesh.geometry import Blocks, IntArray, cells_at
from .box_graph import BoxGraph
from .cell_graph import CellGraph

EXTRA_WORK = {"none": 0.0, "normal": 4.0, "full": 7.0}  # of a contact cell beside its own pass, in passes of a cell
# of a shared contact, measured with 2 ranks on 2 cores: exchanges of a step, nearly all of them one for every colour of
# a sweep; seconds of an exchange with its launch, and of the pass of a cell
EXCHANGES = {"none": 0, "normal": 50, "full": 85}
EXCHANGE, CELL = 60e-6, 110e-9
FEWEST_SHARED = 4000  # contact nodes; fewer ones stay together, unless they leave no cells for the other ranks


def contact_ranks(cells: int, contact: int, nodes: int, ranks: int, removal: str, others: int) -> int:
    """Return the number of ranks that share a contact: the one with the shortest step, 1 in case of doubt.

    cells: number of all cells; contact: of those with contact nodes; nodes: of the contact nodes; removal: "normal" or
    "full", "none" without a static solve; others: number of cells that other ranks could have if the first one had the
    whole contact.
    """
    work = EXTRA_WORK[removal]
    mean, largest = (cells + work * contact) / ranks, (1.0 + work) * contact
    most = int(np.clip(np.ceil(largest / mean - 1e-9), 1, min(ranks, contact)))
    fits = others >= ranks - 1
    if fits and nodes < FEWEST_SHARED and EXCHANGES[removal]:
        return 1
    times = [
        CELL * max(mean, largest / q) + (EXCHANGE * EXCHANGES[removal] if q > 1 else 0.0) for q in range(1, most + 1)
    ]
    if not fits:
        times[0] = np.inf
    return 1 + int(np.argmin(times))


def cut_cells(
    blocks: Blocks,
    node_count: int,
    ranks: int,
    contact_nodes: Sequence[int] | IntArray = (),
    extra: float = 0.0,
    patches: int | None = None,
    together: IntArray | None = None,
) -> IntArray:
    """Return the rank [m] of every cell.

    blocks: kinds of cells with their nodes, as `Mesh.blocks`; ranks: number of parts; contact_nodes: nodes that the
    static solve moves; extra: work of a cell there beside its own pass (`EXTRA_WORK`); patches: number of ranks that
    share the contact cells, None: as above; together: cells [c] that the first rank has.
    Raises `InputError` if there are too few cells for the ranks, `ImportError` without pymetis.
    """
    count = sum(len(cells) for _, cells in blocks)
    _check_room(count, ranks, together, "touch loads, springs or driven supports")
    if ranks == 1:
        return np.zeros(count, dtype=np.int64)
    graph = CellGraph.of(blocks, node_count)
    contact = _contact_cells(blocks, node_count, contact_nodes)
    mean = (count + extra * len(contact)) / ranks
    if patches is None:
        patches = int(np.clip(np.ceil(len(contact) * (1.0 + extra) / mean - 1e-9), 1, ranks)) if len(contact) else 0
    patches = min(patches, len(contact))
    rank = np.full(count, -1, dtype=np.int64)
    if patches:
        rank[contact] = graph.within(contact).cut(patches)
        if together is not None and len(together):
            patches = _lead(rank, together, patches)
        weight = np.ones(count)
        weight[contact] += extra
        _grow(graph, rank, weight, patches, mean if patches < ranks else np.inf)
    rest = np.flatnonzero(rank < 0)
    if len(rest) and patches < ranks:
        rank[rest] = patches + graph.within(rest).cut(ranks - patches)
    rank[rank < 0] = patches - 1  # pieces of a mesh that no patch touches
    return _without_empty(rank, ranks, together)


def cut_beside(
    make: Callable[[], CellGraph | BoxGraph], count: int, ranks: int, together: IntArray, extra: float = 0.0
) -> IntArray:
    """Return the rank [m] of every cell; the first rank has all cells `together` [c], and layers of cells behind them.

    make: makes the graph of the cells, where one is needed; count: number of cells; extra: work of the first rank
    beside its cells, in passes of a cell. Raises `InputError` if too few cells are left for the other ranks,
    `ImportError` without pymetis.
    """
    _check_room(count, ranks, together, "touch contact faces, periodic sides, supports, loads, springs or rigid parts")
    if ranks == 1:
        return np.zeros(count, dtype=np.int64)
    if not len(together):
        return _without_empty(make().cut(ranks), ranks)
    rank, weight = np.full(count, -1, dtype=np.int64), np.ones(count)
    rank[together] = 0
    weight[together] += extra / len(together)
    graph = make()
    _grow(graph, rank, weight, 1, min((count + extra) / ranks, count - (ranks - 1) + extra))
    del weight
    rest = np.flatnonzero(rank < 0)
    graph = graph.within(rest)
    rank[rest] = 1 + _without_empty(graph.cut(ranks - 1), ranks - 1)
    return rank


def _check_room(count: int, ranks: int, together: IntArray | None, why: str) -> None:
    """Raise `InputError` unless there is a cell for every rank beside those `together`; why: what keeps these so."""
    if not 1 <= ranks <= count:
        raise InputError("ranks", ranks, f"the mesh has {count} cell{'s' * (count != 1)}; {_at_most(count)}")
    others = count if together is None else count - len(together)
    if others < ranks - 1:
        text = f"{count - others} of {count} cells {why}, and stay on the first rank"
        raise InputError("ranks", ranks, f"{text}; {_at_most(others + 1)}, or refine the mesh")


def _at_most(ranks: int) -> str:
    """Return the remedy for more ranks than these."""
    return "run it without mpiexec" if ranks == 1 else f"start 1 to {ranks} ranks"


def _lead(rank: IntArray, together: IntArray, patches: int) -> int:
    """Give the first rank the patch that has most of the cells `together` [c], and these cells, in place.

    Returns the number of patches that still have cells, which are numbered anew.
    """
    inside = rank[together][rank[together] >= 0]
    best = int(np.bincount(inside, minlength=patches).argmax())
    first, other = np.flatnonzero(rank == 0), np.flatnonzero(rank == best)
    rank[first], rank[other] = best, 0
    rank[together] = 0
    left = np.unique(rank[rank >= 0])
    rank[rank >= 0] = np.searchsorted(left, rank[rank >= 0])
    return len(left)


def _contact_cells(blocks: Blocks, node_count: int, contact_nodes: Sequence[int] | IntArray) -> IntArray:
    marked = np.zeros(node_count, dtype=bool)
    marked[np.asarray(contact_nodes, dtype=np.int64)] = True
    found, first = [], 0
    for _, cells in blocks:
        found.append(cells_at(marked, cells) + first)
        first += len(cells)
    return np.concatenate(found)


def _grow(graph: CellGraph | BoxGraph, rank: IntArray, weight: np.ndarray, patches: int, limit: float) -> None:
    """Give the patches layers of cells behind them, in place, until each has the work `limit` or no neighbours."""
    work = np.bincount(rank[rank >= 0], weights=weight[rank >= 0], minlength=patches)
    edge = [np.flatnonzero(rank == patch) for patch in range(patches)]
    growing = [patch for patch in range(patches) if work[patch] + 1.0 <= limit]
    while growing:
        patch = min(growing, key=lambda one: (work[one], one))
        layer = graph.near_of(edge[patch])
        layer = layer[rank[layer] < 0]
        room = int(min(len(layer), limit - work[patch]))
        edge[patch] = layer[:room]
        rank[edge[patch]] = patch
        work[patch] += weight[edge[patch]].sum()
        if room == 0 or room < len(layer):
            growing.remove(patch)


def _without_empty(rank: IntArray, ranks: int, together: IntArray | None = None) -> IntArray:
    """Give every rank at least one cell, taken from the part with the most of those that need not stay `together`."""
    free = np.ones(len(rank), dtype=bool)
    if together is not None:
        free[together] = False
    size, spare = np.bincount(rank, minlength=ranks), np.bincount(rank[free], minlength=ranks)
    for empty in np.flatnonzero(size == 0):
        largest = int(np.where(size > 1, spare, 0).argmax())
        rank[np.flatnonzero(free & (rank == largest))[-1]] = empty
        for counts in (size, spare):
            counts[largest], counts[empty] = counts[largest] - 1, 1
    return rank
