"""Pack cells into lanes, and packs into chunks with force rows of their own: the layout that is fast on CPUs.

A pack holds `width` cells of one block (an element with a law and its constants) as [corner][lane]. The packs of all
blocks are divided into chunks, as many on one thread as on eight, so that sums have the same bits there; more threads
have as many chunks as threads, and other rounding errors. Each chunk adds forces, without atomics, into its own row
over the nodes [low, high] it spans. low and high never fall from chunk to chunk: every chunk between a node's first and
last one has a row for it. Contact cells stand last, in as many further chunks; each of their corners has a row of its
own, which the static solve and the node sum read.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..base.errors import InputError
from ..base.memory import aligned
from ..kernels.lanes import CHUNK_BITS, CHUNKS, COUNTING, MATERIALS, MAXIMUM_CHUNKS, WIDTH
from .chunk_rows import rows_of_chunks, shared_out

__all__ = ["CHUNKS", "WIDTH", "Block", "CellPacks", "pack_blocks", "pack_cells"]

IntArray = NDArray[np.int32]
MAXIMUM_STORED = 1 << 30  # as many places has an array that whole vectors are read from (kernels/language/vectors.py)
MAXIMUM_BOUNDARY = 1 << 31 - 2 * CHUNK_BITS  # boundary nodes of a domain are fewer: their bits in node_info


@dataclass(frozen=True)
class Block:
    """Cells of one element and one law with its constants.

    cells [m, corners]: nodes, the contact cells last; width: lanes of a pack; kind: number of the element and law among
    those that the kernel is compiled for; material: place of its constants in `params`; contact: number of contact
    cells; memory: numbers of state of all quadrature points of a cell; shape: stored numbers of its shape.
    """

    cells: NDArray[np.integer]
    width: int
    kind: int = 0
    material: int = MATERIALS
    contact: int = 0
    memory: int = 0
    shape: int = 0


@dataclass(frozen=True)
class CellPacks:
    """Index arrays of the force pass.

    connectivity int32: node of (pack, corner, lane), block after block, then the contact cells of all blocks; the last
    pack of a block is filled up with its last cell, without weight; if there are contact cells, 0, 1, ... COUNTING - 1;
    chunk_table [chunks * (kinds + 3)], segments int32: see kernels/cells/cell_phase.py, lanes.py;
    node_info [nodes] int32: first and last chunk with a cell of the node, boundary node + 1 (0 = ordinary), in bits as
    in lanes.py; first > last for a node of contact cells alone.
    row_count: number of rows (3 force components each); lanes: lanes of all packs; corner_rows: rows of corners;
    corners: row of every corner of the contact cells, block by block; memory: numbers of state of all quadrature
    points; memory_places [2 blocks + 1]: where those of the ordinary cells of each block begin, then those of its
    contact cells; shapes: numbers behind the positions of the nodes, for the stored shapes of all cells;
    shape_places: as memory_places, from the first position on.
    """

    connectivity: IntArray
    chunk_table: IntArray
    segments: IntArray
    node_info: IntArray
    chunks: int
    row_count: int
    lanes: int
    first_contact_lane: int
    corner_rows: int
    corners: NDArray[np.int64]
    memory: int
    memory_places: NDArray[np.int64]
    shapes: int
    shape_places: NDArray[np.int64]

    @property
    def nbytes(self) -> int:
        """Bytes of these cells: index arrays, force rows and stored shapes."""
        arrays = (self.connectivity, self.chunk_table, self.segments, self.node_info)
        return sum(array.nbytes for array in arrays) + 24 * self.row_count + 8 * self.shapes

    @property
    def first_corner_row(self) -> int:
        """First row of the corners of contact cells."""
        return self.row_count - self.corner_rows

    @property
    def all_chunks(self) -> int:
        """Number of chunks: those of the ordinary cells and, if there are any, of the contact cells."""
        return self.chunks * (2 if len(self.corners) else 1)

    def with_boundary(self, nodes: NDArray[np.integer]) -> IntArray:
        """Return a copy of node_info [node_count] with nodes[s] as boundary node s: the pass sums its force only.

        Raises `InputError` for a node out of range or named twice.
        """
        boundary = np.asarray(nodes, dtype=np.int64).ravel()
        if boundary.size and (boundary.min() < 0 or boundary.max() >= len(self.node_info)):
            limits = (boundary.min(), boundary.max())
            raise InputError("boundary nodes", limits, f"give nodes in 0..{len(self.node_info) - 1}")
        if np.unique(boundary).size != boundary.size:
            raise InputError("boundary nodes", boundary, "name each node once")
        if boundary.size >= MAXIMUM_BOUNDARY:
            remedy = f"give bodies that step together fewer than {MAXIMUM_BOUNDARY} of them: a coarser mesh there"
            raise InputError("boundary nodes", boundary.size, remedy)
        info = self.node_info.copy()
        info[boundary] |= (np.arange(boundary.size, dtype=np.int32) + 1) << 2 * CHUNK_BITS
        return info


def chunks_for(threads: int) -> int:
    """Return the number of chunks for so many threads: one for each thread, but at least `CHUNKS`."""
    return min(MAXIMUM_CHUNKS, max(CHUNKS, threads))


def pack_cells(
    connectivity: NDArray[np.integer], node_count: int, width: int, chunks: int = CHUNKS, contact: int = 0
) -> CellPacks:
    """Pack the cells [m, corners] of one block, the last `contact` of which are contact cells; see `pack_blocks`."""
    return pack_blocks([Block(np.asarray(connectivity), width, contact=contact)], node_count, 1, chunks)


def pack_blocks(blocks: Sequence[Block], node_count: int, kinds: int, chunks: int = CHUNKS) -> CellPacks:
    """Pack blocks of cells of renumbered nodes (see `node_order.slab_order`) for the force pass.

    kinds: number of elements with a law that the kernel is compiled for; chunks: at most 31. Any order of the cells
    works; a local one keeps the rows short. Raises `InputError` for an empty or out-of-range connectivity, width < 1 or
    chunks not in 1..31.
    """
    for block in blocks:
        _check(block, node_count)
    if not 1 <= chunks <= MAXIMUM_CHUNKS:
        raise InputError("chunks", chunks, f"use 1 to {MAXIMUM_CHUNKS} ({CHUNK_BITS} bits in node_info)")
    counts = [len(block.cells) - block.contact for block in blocks] + [block.contact for block in blocks]
    forms = [
        (-(-count // block.width), block.cells.shape[1], block.width)
        for count, block in zip(counts, [*blocks, *blocks], strict=True)
    ]
    places = np.concatenate([[0], np.cumsum([np.prod(shape, dtype=np.int64) for shape in forms])])
    lanes = np.concatenate([[0], np.cumsum([packs * width for packs, _, width in forms])])
    counting = COUNTING if any(block.contact for block in blocks) else 0
    connectivity = aligned(places[-1] + counting, np.int32)
    connectivity[places[-1] :] = np.arange(counting)
    parts = [connectivity[places[i] : places[i + 1]].reshape(shape) for i, shape in enumerate(forms)]
    for number, block in enumerate(blocks):
        _fill(parts[number], block.cells[: counts[number]])
        _fill(parts[len(blocks) + number], block.cells[counts[number] :])
    ordinary, contact_parts = parts[: len(blocks)], parts[len(blocks) :]
    both = list(zip(forms, [*blocks, *blocks], strict=True))
    memory = _places([packs * width * block.memory for (packs, _, width), block in both])
    shapes = _places([packs * width * block.shape for (packs, _, width), block in both])
    shape_places = shapes + -(-3 * node_count // WIDTH) * WIDTH
    if shapes[-1] and shape_places[-1] > MAXIMUM_STORED:
        remedy = (
            f"bodies that step together have at most {MAXIMUM_STORED} numbers for positions and shapes: coarsen them"
        )
        raise InputError("cells", int(shape_places[-1]), remedy)

    spans = shared_out(ordinary, chunks)
    rows = rows_of_chunks(ordinary, spans, node_count)
    own = rows.size - int(places[len(blocks)])  # row of place 0, for contact cells
    starts = _Starts(places, lanes, memory, shape_places)
    parts_of = [(spans, 0, rows.bases)]
    if counting:
        parts_of.append((shared_out(contact_parts, chunks), len(blocks), np.zeros(chunks, dtype=np.int64)))
    table, segments = _tables(blocks, kinds, starts, parts_of, own)
    corners = [
        own + places[len(blocks) + number] + _corner_places(block.contact, block.width, block.cells.shape[1])
        for number, (block, part) in enumerate(zip(blocks, contact_parts, strict=True))
    ]
    return CellPacks(
        connectivity=connectivity,
        chunk_table=table,
        segments=segments,
        node_info=rows.first | (rows.last << CHUNK_BITS),
        chunks=chunks,
        row_count=int(rows.size + places[-1] - places[len(blocks)]),
        lanes=int(lanes[-1]),
        first_contact_lane=int(lanes[len(blocks)]),
        corner_rows=int(places[-1] - places[len(blocks)]),
        corners=np.concatenate(corners),
        memory=int(memory[-1]),
        memory_places=memory,
        shapes=int(shape_places[-1]) - 3 * node_count if shapes[-1] else 0,
        shape_places=shape_places,
    )


class _Starts(NamedTuple):
    """Where every block begins, first its ordinary cells, then its contact cells [2 blocks + 1].

    connectivity: its corners; lanes; memory: state of its points; shapes: stored shapes of its cells.
    """

    connectivity: NDArray[np.int64]
    lanes: NDArray[np.int64]
    memory: NDArray[np.int64]
    shapes: NDArray[np.int64]


def _tables(
    blocks: Sequence[Block],
    kinds: int,
    starts: _Starts,
    parts: list[tuple[list[list[tuple[int, int]]], int, NDArray[np.int64]]],
    own: int,
) -> tuple[IntArray, IntArray]:
    """Return chunk table and segments, see `CellPacks`; kinds: as in `pack_blocks`; own: row of place 0.

    parts: of ordinary cells, then of contact cells, if there are any: packs of every block in every chunk, number of
    the first of these blocks in `starts`, and the row of node 0 in every chunk.
    """
    table: list[int] = []
    segments: list[tuple[int, ...]] = []
    for owns, (ranges, shift, row_bases) in enumerate(parts):
        for chunk, row_base in enumerate(row_bases):
            for kind in range(kinds):
                table.append(len(segments))
                for number, block in enumerate(blocks):
                    start, end = ranges[chunk][number]
                    if block.kind == kind and end > start:
                        cells = block.contact if owns else len(block.cells) - block.contact
                        where = (
                            starts.connectivity[number + shift],
                            block.material,
                            own,
                            starts.lanes[number + shift],
                            starts.memory[number + shift],
                            starts.shapes[number + shift] if block.shape else 0,
                        )
                        segments.append((start, end, cells, *where))
            table += [len(segments), int(row_base), owns]
    return np.array(table, dtype=np.int32), np.array(segments, dtype=np.int32).ravel()


def _places(sizes: list[int]) -> NDArray[np.int64]:
    """Return where each of several parts begins that stand one after the other, and their end."""
    return np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)


def _check(block: Block, node_count: int) -> None:
    cells = block.cells
    if cells.ndim != 2 or cells.size == 0:
        raise InputError("connectivity", cells.shape, "give at least one cell, as [cells, corners]")
    if cells.min() < 0 or cells.max() >= node_count:
        limits = (int(cells.min()), int(cells.max()))
        raise InputError("connectivity", limits, f"node numbers lie in 0..{node_count - 1}")
    if block.width < 1:
        raise InputError("width", block.width, "give at least one lane")


def _fill(packs: IntArray, cells: NDArray[np.integer]) -> None:
    """Put the cells [m, corners] into packs [packs, corners, lanes], filled up with the last one."""
    width = packs.shape[2]
    whole = len(cells) // width
    packs[:whole] = cells[: whole * width].reshape(whole, width, cells.shape[1]).transpose(0, 2, 1)
    if whole < len(packs):
        packs[whole] = cells[-1][:, None]
        packs[whole, :, : len(cells) - whole * width] = cells[whole * width :].T


def _corner_places(count: int, width: int, corners: int) -> NDArray[np.int64]:
    """Return the places [count * corners] of the corners of a block in its connectivity, cell by cell."""
    cell, corner = np.divmod(np.arange(count * corners), corners)
    return ((cell // width) * corners + corner) * width + cell % width
