"""Numbering of nodes and cells that keeps neighbours together in memory, and its inverse."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ..kernels.lanes import WIDTH
from ..mesh.elements import ELEMENTS, HEX_CORNERS
from ..mesh.geometry import chunks_of, grid_planes
from ..mesh.late_rows import LateRows, Rows

Integer = TypeVar("Integer", bound=np.integer)


def slab_order(
    nodes: NDArray[np.float64], cells: NDArray[np.integer], normal: NDArray[np.float64] | None = None
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return (node_order, cell_order) that keep neighbours together: new node k is old node node_order[k].

    Nodes are sorted by slabs along the axis with the most slabs, then by rows along the next one, then by coordinate.
    Slabs are the grid planes where the coordinates form a grid (box meshes, graded or not), else equal shares of the
    nodes about one mean spacing thick. Cells are sorted by their lowest node.
    nodes [n, 3], cells [m, corners]; normal: normal of the contact face, whose nodes stay together if axes have equally
    many slabs.
    """
    points = np.asarray(nodes, dtype=np.float64)
    count = len(points)
    extent = np.ptp(points, axis=0)
    size = float(extent.max())
    if size == 0.0:
        return np.arange(count), np.arange(len(cells))
    planes = [grid_planes(points[:, axis], 1e-6 * size) for axis in range(3)]
    counts = [int(plane.max()) + 1 for plane in planes]
    if np.prod(np.array(counts, dtype=float)) > 2.0 * count:
        thick = np.maximum(extent, 1e-3 * size)
        spacing = (np.prod(thick) / count) ** (1.0 / 3.0)
        planes = [_shares(points[:, axis], round(extent[axis] / spacing)) for axis in range(3)]
        counts = [int(plane.max()) + 1 for plane in planes]
    slow, middle, fast = _slow_to_fast(counts, extent, normal)
    node_order = np.lexsort((points[:, fast], planes[middle], planes[slow]))
    rank = inverse(node_order)
    lowest, total = np.empty(len(cells), dtype=np.int32), np.empty(len(cells), dtype=np.int64)
    for part in chunks_of(len(cells)):
        numbers = rank.take(cells[part])
        lowest[part], total[part] = numbers.min(axis=1), numbers.sum(axis=1)
    return node_order, np.lexsort((total, lowest))


def grid_order(
    lines: Sequence[NDArray[np.float64]], kind: str, normal: NDArray[np.float64] | None = None
) -> tuple[NDArray[np.int64], NDArray[np.int64]] | None:
    """Return `slab_order` of a box of cells of a kind without sorting its nodes [n] and cells [m].

    lines: coordinates [nx + 1], [ny + 1], [nz + 1] [m] along x, y and z; normal [3]: as in `slab_order`. All cells that
    a hexahedron is cut into have its first node, which is their lowest one. None where planes are so close that
    `slab_order` takes some of them for one.
    """
    extent = np.array([np.ptp(line) for line in lines])
    if any(grid_planes(line, 1e-6 * float(extent.max()))[-1] != len(line) - 1 for line in lines):
        return None
    counts = np.array([len(line) for line in lines])
    axes = _slow_to_fast(counts.tolist(), extent, normal)
    orders = [
        np.arange(shape.prod()).reshape(shape[::-1]).transpose([2 - axis for axis in axes]).reshape(-1)
        for shape in (counts, counts - 1)
    ]
    steps = np.empty(3, dtype=np.int64)  # of the new numbers along x, y and z
    steps[list(axes)] = counts[axes[1]] * counts[axes[2]], counts[axes[2]], 1
    numbers = (HEX_CORNERS > 0.0) @ steps
    cells = np.array(ELEMENTS[kind].in_box)
    turn = np.argsort(numbers[cells].sum(axis=1), kind="stable")
    return orders[0], orders[1] if len(cells) == 1 else (orders[1][:, None] * len(cells) + turn).reshape(-1)


def _slow_to_fast(
    counts: Sequence[int], extent: NDArray[np.float64], normal: NDArray[np.float64] | None
) -> tuple[int, int, int]:
    """Return the axes, that with the most slabs first; counts: slabs, extent [3] [m]: length along x, y and z."""
    along = -1 if normal is None else int(np.abs(normal).argmax())
    slow, middle, fast = sorted(range(3), key=lambda axis: (-counts[axis], axis != along, -extent[axis], axis))
    return slow, middle, fast


def inverse(order: NDArray[Integer]) -> NDArray[Integer]:
    """Return the places [n] of the numbers of a permutation [n]."""
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    return place


def renumbered(place: NDArray[np.integer], cells: Rows, order: NDArray[np.integer] | None = None) -> NDArray[np.int32]:
    """Return the cells [m, corners] with nodes by their places [n], those of `order` in that order, in 32 bits."""
    result = np.empty((len(cells if order is None else order), cells.shape[1]), dtype=np.int32)
    for part in chunks_of(len(result)):
        result[part] = place.take(cells[part] if order is None else cells.take(order[part], axis=0))
    return result


def renumbered_late(place: NDArray[np.integer], cells: Rows, order: NDArray[np.integer]) -> Rows:
    """Return `renumbered`, which stays late for cells that are."""
    if not isinstance(cells, LateRows):
        return renumbered(place, cells, order)
    short = place.astype(np.int32)
    return LateRows(lambda numbers: short.take(cells.take(order[numbers])), cells.shape, np.int32)


def lowest_nodes(
    place: NDArray[np.integer], cells: Rows, order: NDArray[np.integer], corners: int
) -> NDArray[np.int32]:
    """Return the lowest node [k] of the cells of `order` [k] with so many corners, nodes by their places [n]."""
    result = np.empty(len(order), dtype=np.int32)
    for part in chunks_of(len(order)):
        result[part] = place.take(cells[order[part], :corners]).min(axis=1)
    return result


def lanes_apart(lowest: NDArray[np.integer]) -> NDArray[np.int64]:
    """Return an order of cells, sorted by their lowest nodes [m], that keeps equal nodes of a pack apart.

    Cells with the same lowest node, such as those that a hexahedron is cut into, are taken in turns with those of the
    WIDTH - 1 next lowest nodes: additions to one force row, which wait for each other, stand further apart.
    """
    first = np.flatnonzero(np.diff(lowest, prepend=-1))  # of each group of cells with one lowest node
    sizes = np.diff(first, append=len(lowest))
    group = np.repeat(np.arange(len(first)), sizes)
    turn = np.arange(len(lowest)) - np.repeat(first, sizes)
    return np.lexsort((group, turn, group // WIDTH))


def _shares(coordinate: NDArray[np.float64], slabs: int) -> NDArray[np.int64]:
    """Return the slab of each value, with limits at quantiles: equal values share one, refined zones have thin ones."""
    if slabs < 2:
        return np.zeros(len(coordinate), dtype=np.int64)
    limits = np.quantile(coordinate, np.arange(1, slabs) / slabs)
    return np.searchsorted(np.unique(limits), coordinate, side="right")
