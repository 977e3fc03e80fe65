"""The graph of the hexahedra of a box, which share a face with the next one along each axis: it needs no list of them.

METIS cuts blocks of 2 x 2 x 2 cells, with the number of cells of each and of faces between them as weights, so that its
copies of the graph take an eighth of what the cells would.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from ...mesh.geometry import IntArray
from .cell_graph import CellGraph

SIDE = 2  # cells of a block along each axis
FINE = 100_000  # cells up to which METIS cuts the cells themselves


class BoxGraph:
    """As `CellGraph`, of a box with so many hexahedra along x, y and z; chosen [c]: those in it, None: all of them."""

    def __init__(self, counts: tuple[int, int, int], chosen: IntArray | None = None) -> None:
        self.counts, self.chosen = counts, chosen

    def within(self, chosen: IntArray) -> BoxGraph:
        """Return the graph of some cells, ascending, in their order."""
        return BoxGraph(self.counts, chosen if self.chosen is None else self.chosen[chosen])

    def near_of(self, cells: IntArray) -> IntArray:
        """Return the neighbours of some cells of the whole box, ascending."""
        place, found = np.unravel_index(cells, self.counts[::-1]), [cells[:0]]
        for axis, along in enumerate(place):
            step = int(np.prod(self.counts[: 2 - axis]))  # of the numbers along z, y, x
            found += [cells[along > 0] - step, cells[along < self.counts[2 - axis] - 1] + step]
        return np.unique(np.concatenate(found))

    def cut(self, parts: int) -> IntArray:
        """Return the part [cells] of every cell: parts of nearly equal size, few neighbours between them."""
        total = int(np.prod(self.counts)) if self.chosen is None else len(self.chosen)
        if parts == 1:
            return np.zeros(total, dtype=np.int64)
        if total <= FINE:
            whole = CellGraph.of_box(self.counts)
            return (whole if self.chosen is None else whole.within(self.chosen)).cut(parts)
        graph, cells_of, block = self._blocks()
        found = graph.cut(parts, cells_of)
        return found[block if self.chosen is None else block[self.chosen]]

    def _blocks(self) -> tuple[CellGraph, IntArray, IntArray]:
        """Return the graph of the blocks that have cells, the number of these, and the block of every cell of the box.

        Blocks of cells that are not in the graph have the number of some other block.
        """
        shape = self.counts[::-1]
        inside = np.ones(int(np.prod(shape)), dtype=bool)
        if self.chosen is not None:
            inside[:] = False
            inside[self.chosen] = True
        room = tuple(-(-count // SIDE) * SIDE for count in shape)
        cells = np.zeros(room, dtype=bool)
        cells[tuple(slice(count) for count in shape)] = inside.reshape(shape)
        of_block = _sums(cells)
        there = of_block.reshape(-1) > 0
        number = np.cumsum(there) - 1  # of the blocks that have cells
        left, right, faces = [], [], []
        blocks = number.reshape(of_block.shape)
        for axis in range(3):
            last, first = (_at(axis, slice(start, None, SIDE)) for start in (SIDE - 1, 0))
            both = np.moveaxis(cells[last], axis, 0)[:-1] & np.moveaxis(cells[first], axis, 0)[1:]
            shared = _sums(both, (1, 2))
            near = shared > 0
            along = np.moveaxis(blocks, axis, 0)
            left.append(along[:-1][near])
            right.append(along[1:][near])
            faces.append(shared[near])
        pairs = np.concatenate(left), np.concatenate(right), np.concatenate(faces)
        graph = CellGraph.from_weighted_pairs(*pairs, int(there.sum()))
        corners = np.ix_(*(np.arange(count) // SIDE for count in shape))
        return graph, of_block.reshape(-1)[there], blocks[corners].reshape(-1).astype(np.int32)


def _at(axis: int, part: slice) -> tuple[slice, ...]:
    """Return the places of a part along one of three axes, and everything along the others."""
    return tuple(part if one == axis else slice(None) for one in range(3))


def _sums(values: np.ndarray, axes: tuple[int, ...] = (0, 1, 2)) -> IntArray:
    """Return the sums of values over blocks of SIDE along some of three axes."""
    total = np.zeros(tuple(n // SIDE if axis in axes else n for axis, n in enumerate(values.shape)), dtype=np.int64)
    for starts in product(range(SIDE), repeat=len(axes)):
        offset = dict(zip(axes, starts, strict=True))
        total += values[tuple(slice(offset[axis], None, SIDE) if axis in axes else slice(None) for axis in range(3))]
    return total
