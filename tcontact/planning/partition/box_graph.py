"""The graph of the hexahedra of boxes, which share a face with the next one along each axis: it needs no list of them.

METIS cuts blocks of 2 x 2 x 2 cells, with the number of cells of each and of faces between them as weights, so that its
copies of the graph take an eighth of what the cells would.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np

from ...mesh.geometry import IntArray
from .cell_graph import CellGraph

SIDE = 2  # cells of a block along each axis
FINE = 100_000  # cells up to which METIS cuts the cells themselves


class BoxGraph:
    """As `CellGraph`, of boxes with so many hexahedra along x, y and z, numbered box after box.

    chosen [c]: those in it, ascending, None: all of them.
    """

    def __init__(self, boxes: Sequence[tuple[int, int, int]], chosen: IntArray | None = None) -> None:
        self.boxes, self.chosen = boxes, chosen
        self._starts = np.cumsum([0, *(int(np.prod(counts)) for counts in boxes)])

    def _of_box(self, number: int, cells: IntArray) -> IntArray:
        """Return those of some cells, ascending, that a box has, numbered as its own."""
        first, last = self._starts[number : number + 2]
        return cells[slice(*np.searchsorted(cells, (first, last)))] - first

    def within(self, chosen: IntArray) -> BoxGraph:
        """Return the graph of some cells, ascending, in their order."""
        return BoxGraph(self.boxes, chosen if self.chosen is None else self.chosen[chosen])

    def near_of(self, cells: IntArray) -> IntArray:
        """Return the neighbours of some cells, ascending, of the whole boxes, ascending."""
        found = [cells[:0]]
        for number, counts in enumerate(self.boxes):
            own = self._of_box(number, cells)
            for axis, along in enumerate(np.unravel_index(own, counts[::-1])):
                step = int(np.prod(counts[: 2 - axis]))  # of the numbers along z, y, x
                near = [own[along > 0] - step, own[along < counts[2 - axis] - 1] + step]
                found += [one + self._starts[number] for one in near]
        return np.unique(np.concatenate(found))

    def cut(self, parts: int) -> IntArray:
        """Return the part [cells] of every cell: parts of nearly equal size, few neighbours between them."""
        total = int(self._starts[-1]) if self.chosen is None else len(self.chosen)
        if parts == 1:
            return np.zeros(total, dtype=np.int64)
        if total <= FINE:
            whole = CellGraph.joined([CellGraph.of_box(counts) for counts in self.boxes])
            return (whole if self.chosen is None else whole.within(self.chosen)).cut(parts)
        graphs, cells_of, blocks = zip(*map(self._blocks, range(len(self.boxes))), strict=True)
        found = CellGraph.joined(graphs).cut(parts, np.concatenate(cells_of))
        starts = np.cumsum([0, *map(len, cells_of)], dtype=np.int32)
        block = np.concatenate([own + first for own, first in zip(blocks, starts, strict=False)])
        return found[block if self.chosen is None else block[self.chosen]]

    def _blocks(self, box: int) -> tuple[CellGraph, IntArray, IntArray]:
        """Return the graph of the blocks of a box that have cells, the number of these, and the block of every cell.

        Blocks of cells that are not in the graph have the number of some other block.
        """
        shape = self.boxes[box][::-1]
        inside = np.ones(int(np.prod(shape)), dtype=bool)
        if self.chosen is not None:
            inside[:] = False
            inside[self._of_box(box, self.chosen)] = True
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
