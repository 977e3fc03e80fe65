"""The graph of the cells of a mesh that share a face, and its cut by METIS (Karypis and Kumar 1998)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...mesh.geometry import Blocks, IntArray, cell_face_keys, chunks_of
from ...mesh.mesh import Mesh

UNBALANCE = 10  # thousandths by which METIS may miss equal parts
SHARES = 16  # of the faces, sorted one after the other to need less memory; a power of two
AT_ONCE = 1 << 16  # cells in a portion


class CellGraph:
    """Cells that share a face: the neighbours of cell c are near[start[c] : start[c + 1]], ascending.

    weights: of each of these neighbours, such as the faces between blocks of cells; None: alike.
    """

    def __init__(self, start: IntArray, near: np.ndarray, weights: IntArray | None = None) -> None:
        self.start, self.near, self.weights = start, near, weights

    @classmethod
    def of(cls, blocks: Blocks, node_count: int) -> CellGraph:
        """Make the graph of the cells of a mesh."""
        keys = np.concatenate([cell_face_keys(cells, kind, node_count) for kind, cells in blocks])
        owners, first = [], 0
        for kind, cells in blocks:
            faces = len(cell_face_keys(cells[:1], kind, node_count))
            owners.append(np.repeat(np.arange(first, first + len(cells), dtype=np.int32), faces))
            first += len(cells)
        owner, left, right = np.concatenate(owners), [], []
        shares = (keys >> np.uint64(64 - SHARES.bit_length() + 1)).astype(np.uint8)
        for share in range(SHARES):
            faces_of_share = np.flatnonzero(shares == share)
            own = keys[faces_of_share]
            order = np.argsort(own, kind="stable")
            own, cell = own[order], owner[faces_of_share[order]]
            twice = np.flatnonzero(own[1:] == own[:-1])
            left.append(cell[twice])
            right.append(cell[twice + 1])
        del keys, owner, shares
        return cls.from_pairs(np.concatenate(left), np.concatenate(right), first)

    @classmethod
    def of_meshes(cls, meshes: Sequence[Mesh]) -> CellGraph:
        """Make the graph of the cells of several meshes, numbered one after the other."""
        blocks, first = [], 0
        for mesh in meshes:
            blocks += [(kind, rows + first if first else rows) for kind, rows in mesh.blocks]
            first += mesh.node_count
        return cls.of(blocks, first)

    @classmethod
    def of_box(cls, counts: tuple[int, int, int]) -> CellGraph:
        """Make the graph of the hexahedra of a box with so many of them along x, y and z."""
        steps = np.array([counts[0] * counts[1], counts[0], 1])
        steps, total = np.concatenate([-steps, steps[::-1]]), int(np.prod(counts))
        sizes, near, last = np.zeros(total + 1, dtype=np.int64), np.empty(6 * total, dtype=np.int32), 0
        for part in chunks_of(total, AT_ONCE):
            cell = np.arange(part.start, part.stop)
            place = np.stack(np.unravel_index(cell, counts[::-1]), axis=1)  # along z, y, x
            there = np.concatenate([place > 0, (place < np.array(counts[::-1]) - 1)[:, ::-1]], axis=1)
            own = (cell[:, None] + steps)[there]
            near[last : last + len(own)] = own
            last += len(own)
            sizes[part.start + 1 : part.stop + 1] = there.sum(axis=1)
        return cls(np.cumsum(sizes), near[:last])

    @classmethod
    def from_pairs(cls, left: IntArray, right: IntArray, count: int) -> CellGraph:
        """Make the graph of `count` cells from pairs of neighbours, each given once."""
        pairs = np.concatenate([left, right]).astype(np.int64) * count
        pairs += np.concatenate([right, left])
        pairs.sort()
        start = np.searchsorted(pairs, np.arange(count + 1) * count)
        return cls(start, (pairs % count).astype(np.int32))

    @classmethod
    def from_weighted_pairs(cls, left: IntArray, right: IntArray, weights: IntArray, count: int) -> CellGraph:
        """Make the graph of `count` cells, or blocks of them, from pairs of neighbours and their weights."""
        one, other = np.concatenate([left, right]), np.concatenate([right, left])
        order = np.lexsort((other, one))
        start = np.searchsorted(one[order], np.arange(count + 1))
        return cls(start, other[order].astype(np.int32), np.concatenate([weights, weights])[order])

    @classmethod
    def joined(cls, graphs: Sequence[CellGraph]) -> CellGraph:
        """Make the graph of the cells of several graphs, numbered one after the other."""
        if len(graphs) == 1:
            return graphs[0]
        cells = np.cumsum([0, *(len(one.start) - 1 for one in graphs)], dtype=np.int32)
        pairs = np.cumsum([0, *(len(one.near) for one in graphs)])
        start = [one.start[1:] + first for one, first in zip(graphs, pairs, strict=False)]
        near = [one.near + first for one, first in zip(graphs, cells, strict=False)]
        weights = [one.weights for one in graphs if one.weights is not None]
        return cls(np.concatenate([[0], *start]), np.concatenate(near), np.concatenate(weights) if weights else None)

    def within(self, chosen: IntArray) -> CellGraph:
        """Return the graph of some cells, ascending, in their order."""
        place = np.full(len(self.start) - 1, -1, dtype=np.int32)
        place[chosen] = np.arange(len(chosen))
        start, found, last = np.zeros(len(chosen) + 1, dtype=np.int64), np.empty(len(self.near), dtype=np.int32), 0
        for part in chunks_of(len(place), AT_ONCE):
            first, end = self.start[part.start], self.start[part.stop]
            near, rows = (
                place[self.near[first:end]],
                np.repeat(place[part], np.diff(self.start[part.start : part.stop + 1])),
            )
            inside = (rows >= 0) & (near >= 0)
            near, rows = near[inside], rows[inside]
            found[last : last + len(near)] = near
            last += len(near)
            if len(rows):
                start[rows[0] + 1 : rows[-1] + 2] += np.bincount(rows - rows[0])
        return CellGraph(np.cumsum(start), found[:last])

    def near_of(self, cells: IntArray) -> IntArray:
        """Return the neighbours of some cells, ascending."""
        lengths = self.start[cells + 1] - self.start[cells]
        shift = np.repeat(self.start[cells] - np.concatenate([[0], np.cumsum(lengths)[:-1]]), lengths)
        return np.unique(self.near[np.arange(int(lengths.sum())) + shift])

    def cut(self, parts: int, sizes: IntArray | None = None) -> IntArray:
        """Return the part [cells] of every cell: equal parts, few neighbours between them.

        sizes [cells]: of the cells, None: all alike.
        """
        if parts == 1:
            return np.zeros(len(self.start) - 1, dtype=np.int64)
        import pymetis

        options = pymetis.Options(ufactor=UNBALANCE, seed=1)
        graph = pymetis.CSRAdjacency(self.start.astype(np.int32), self.near.astype(np.int32, copy=False))
        of_cells, of_faces = (None if one is None else one.astype(np.int32) for one in (sizes, self.weights))
        found = pymetis.part_graph(parts, graph, options=options, recursive=True, vweights=of_cells, eweights=of_faces)[
            1
        ]
        return np.asarray(found, dtype=np.int64)
