"""Cells in packs of lanes, packs in chunks that own compact force rows: the shape that is fast on CPUs.

A pack holds `width` cells as [corner][lane]. Packs are divided into a fixed number of chunks, so that sums have the
same bits at any thread count. Each chunk adds forces, without atomics, into its own row over the nodes [low, high] it
spans. low and high never fall from chunk to chunk: every chunk between a node's first and last one has a row for it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from .errors import InputError
from .kernels.lanes import CHUNKS, TABLE, WIDTH

__all__ = ["CHUNKS", "TABLE", "WIDTH", "CellPacks", "OwnRows", "append_own_rows", "pack_cells", "slab_order"]

IntArray = NDArray[np.int32]


@dataclass(frozen=True)
class CellPacks:
    """Index arrays of the step kernel.

    connectivity [packs * corners * width] int32: node of (pack, corner, lane); the last pack is filled up by repeating
    the last cell, without weight: the kernel counts to cell_count;
    chunk_table [chunks * TABLE] int32: first pack, end pack, row base, end of its cells (pack * width + lane), 0; row
    of a node in a chunk = base + node;
    node_info [nodes] int32: bits 0-3 first chunk that touches the node, 4-7 last one, 8.. number of the special node
    + 1 (0 = ordinary); first > last for a node without cells. row_count: rows in all (3 force components each).
    """

    connectivity: IntArray
    chunk_table: IntArray
    node_info: IntArray
    width: int
    corners: int
    chunks: int
    cell_count: int
    pack_count: int
    node_count: int
    row_count: int

    @property
    def nbytes(self) -> int:
        """Bytes the kernel keeps for these cells: index arrays and force rows."""
        return self.connectivity.nbytes + self.chunk_table.nbytes + self.node_info.nbytes + 24 * self.row_count

    def with_special(self, nodes: NDArray[np.integer]) -> IntArray:
        """A copy of node_info [node_count] in which nodes[s] is special node s: it hands out its force and stays.

        Raises `InputError` for a node out of range or named twice.
        """
        special = np.asarray(nodes, dtype=np.int64).ravel()
        if special.size and (special.min() < 0 or special.max() >= self.node_count):
            raise InputError("special nodes", (special.min(), special.max()), f"give nodes in 0..{self.node_count - 1}")
        if np.unique(special).size != special.size:
            raise InputError("special nodes", special, "name each node once")
        info = self.node_info & 0xFF
        info[special] |= (np.arange(special.size, dtype=np.int32) + 1) << 8
        return info


def pack_cells(connectivity: NDArray[np.integer], node_count: int, width: int, chunks: int = CHUNKS) -> CellPacks:
    """Pack cells [m, corners] of renumbered nodes (see `slab_order`) for the step kernel.

    width: lanes per pack (`WIDTH`); chunks: at most 16. Any order works, a local one keeps the rows short.
    Raises `InputError` for an empty or out-of-range connectivity, width < 1 or chunks not in 1..16.
    """
    cells = np.asarray(connectivity)
    if cells.ndim != 2 or cells.size == 0:
        raise InputError("connectivity", cells.shape, "give at least one cell, as [cells, corners]")
    if cells.min() < 0 or cells.max() >= node_count:
        raise InputError(
            "connectivity", (int(cells.min()), int(cells.max())), f"node numbers lie in 0..{node_count - 1}"
        )
    if width < 1:
        raise InputError("width", width, "give at least one lane")
    if not 1 <= chunks <= 16:
        raise InputError("chunks", chunks, "use 1 to 16 (4 bits in node_info)")
    count, corners = cells.shape
    packs = -(-count // width)
    padded = np.empty((packs * width, corners), dtype=np.int32)
    padded[:count] = cells
    padded[count:] = cells[-1]

    bounds = [packs * c // chunks for c in range(chunks + 1)]
    first = np.full(node_count, chunks, dtype=np.int32)
    last = np.full(node_count, -1, dtype=np.int32)
    low = np.full(chunks, node_count, dtype=np.int64)
    high = np.full(chunks, -1, dtype=np.int64)
    for c in range(chunks):
        touched = padded[bounds[c] * width : bounds[c + 1] * width]
        if touched.size:
            low[c], high[c] = touched.min(), touched.max()
            last[touched.ravel()] = c
    for c in reversed(range(chunks)):
        first[padded[bounds[c] * width : bounds[c + 1] * width].ravel()] = c
    low = np.minimum.accumulate(low[::-1])[::-1]
    high = np.maximum.accumulate(high)
    span = np.maximum(high - low + 1, 0)
    offset = np.concatenate(([0], np.cumsum(span)))

    table = np.zeros((chunks, TABLE), dtype=np.int32)
    table[:, 0], table[:, 1] = bounds[:-1], bounds[1:]
    table[:, 2] = np.where(span > 0, offset[:-1] - low, 0)
    table[:, 3] = count
    orphan = last < 0
    first[orphan], last[orphan] = 1, 0
    return CellPacks(
        connectivity=np.ascontiguousarray(padded.reshape(packs, width, corners).transpose(0, 2, 1)).ravel(),
        chunk_table=table.ravel(),
        node_info=first | (last << 4),
        width=width,
        corners=corners,
        chunks=chunks,
        cell_count=count,
        pack_count=packs,
        node_count=node_count,
        row_count=int(offset[-1]),
    )


@dataclass(frozen=True)
class OwnRows:
    """Packs appended to those of a body: some of its cells once more, every corner with a row of its own."""

    packs: CellPacks
    first_row: int
    width: int
    corners: int

    def rows(self, cell: IntArray, corner: IntArray) -> IntArray:
        """Row of a corner of the cell with this place in the list."""
        lane = cell % self.width
        return self.first_row + ((cell // self.width) * self.corners + corner) * self.width + lane


def append_own_rows(packs: CellPacks, cells: NDArray[np.integer]) -> OwnRows:
    """Append the listed cells [c, corners] as chunks that own their rows; the chunks before stay as they are."""
    more = pack_cells(cells, packs.node_count, packs.width, packs.chunks)
    table = more.chunk_table.reshape(-1, TABLE).copy()
    lanes = packs.corners * packs.width
    table[:, :2] += packs.pack_count
    table[:, 2] = packs.row_count - packs.pack_count * lanes
    table[:, 3] += packs.pack_count * packs.width
    table[:, 4] = 1
    joined = replace(
        packs,
        connectivity=np.concatenate([packs.connectivity, more.connectivity]),
        chunk_table=np.concatenate([packs.chunk_table, table.ravel()]),
        row_count=packs.row_count + more.pack_count * lanes,
    )
    return OwnRows(joined, packs.row_count, packs.width, packs.corners)


def slab_order(
    nodes: NDArray[np.float64], cells: NDArray[np.integer], normal: NDArray[np.float64] | None = None
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """(node_order, cell_order): new node k is old node node_order[k]; likewise cells.

    Nodes are sorted by slabs along the axis with the most slabs, then by rows along the next one, then by coordinate.
    Slabs are the grid planes where the coordinates form a grid (box meshes, graded or not), else equal shares of the
    nodes about one mean spacing thick. Cells follow their lowest node: neighbours in space stay neighbours in memory.
    nodes [n, 3], cells [m, corners]; normal: of the contact face, whose nodes stay together if numbers of slabs tie.
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
    along = -1 if normal is None else int(np.abs(normal).argmax())
    slow, middle, fast = sorted(range(3), key=lambda axis: (-counts[axis], axis != along, -extent[axis], axis))
    node_order = np.lexsort((points[:, fast], planes[middle], planes[slow]))
    rank = np.empty(count, dtype=np.int64)
    rank[node_order] = np.arange(count)
    renumbered = rank[np.asarray(cells)]
    return node_order, np.lexsort((renumbered.sum(axis=1), renumbered.min(axis=1)))


def grid_planes(coordinate: NDArray[np.float64], tolerance: float) -> NDArray[np.int64]:
    """Number of the plane of each value; values closer than the tolerance to the next lower one share its plane."""
    order = np.argsort(coordinate, kind="stable")
    number = np.empty(len(coordinate), dtype=np.int64)
    number[order] = np.concatenate(([0], np.cumsum(np.diff(coordinate[order]) > tolerance)))
    return number


def _shares(coordinate: NDArray[np.float64], slabs: int) -> NDArray[np.int64]:
    """Slab of each value, with slab limits at quantiles: equal values stay together, refined zones get thin slabs."""
    if slabs < 2:
        return np.zeros(len(coordinate), dtype=np.int64)
    limits = np.quantile(coordinate, np.arange(1, slabs) / slabs)
    return np.searchsorted(np.unique(limits), coordinate, side="right")
