"""Chunks of packs of cells, and the force rows that each of them has for the nodes that it spans (packing.py)."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

IntArray = NDArray[np.int32]


def shared_out(parts: list[IntArray], chunks: int) -> list[list[tuple[int, int]]]:
    """Divide the packs into chunks: first and end pack of every block [blocks] in every chunk [chunks].

    Packs of all blocks are taken in the order of their lowest nodes, keeping the order within a block; every chunk gets
    about as many corners.
    """
    lowest = [np.maximum.accumulate(part.min(axis=(1, 2), initial=2**31 - 1)) for part in parts]
    owner = np.repeat(np.arange(len(parts)), [len(part) for part in parts])
    order = np.argsort(np.concatenate(lowest), kind="stable")
    owner = owner[order]
    work = np.concatenate([[0], np.cumsum(np.array([part.shape[1] for part in parts], dtype=np.int64)[owner])])
    bounds = np.searchsorted(work * chunks, work[-1] * np.arange(chunks + 1), side="right") - 1
    before = np.stack([np.concatenate([[0], np.cumsum(owner == number)])[bounds] for number in range(len(parts))])
    return [[(int(row[0]), int(row[1])) for row in zip(start, end, strict=True)] for start, end in pairwise(before.T)]


class ChunkRows(NamedTuple):
    """Force rows of the nodes in the chunks.

    first, last [nodes]: first and last chunk with a cell of a node, 1 and 0 without any; bases [chunks]: row of node 0
    in every chunk, had it one; size: number of rows.
    """

    first: IntArray
    last: IntArray
    bases: NDArray[np.int64]
    size: int


def rows_of_chunks(parts: list[IntArray], spans: list[list[tuple[int, int]]], node_count: int) -> ChunkRows:
    """Return the force rows of chunks whose packs `shared_out` gave; parts: nodes [packs, corners, lanes] of blocks.

    The lowest and the highest node of a chunk never fall from one to the next.
    """
    chunks = len(spans)
    first = np.full(node_count, chunks, dtype=np.int32)
    last = np.full(node_count, -1, dtype=np.int32)
    low = np.full(chunks, node_count, dtype=np.int64)
    high = np.full(chunks, -1, dtype=np.int64)
    for chunk in range(chunks):
        for part, (start, end) in zip(parts, spans[chunk], strict=True):
            nodes = part[start:end]
            if nodes.size:
                low[chunk], high[chunk] = min(low[chunk], nodes.min()), max(high[chunk], nodes.max())
                last[nodes.ravel()] = chunk
    for chunk in reversed(range(chunks)):
        for part, (start, end) in zip(parts, spans[chunk], strict=True):
            first[part[start:end].ravel()] = chunk
    low = np.minimum.accumulate(low[::-1])[::-1]
    high = np.maximum.accumulate(high)
    span = np.maximum(high - low + 1, 0)
    offset = np.concatenate(([0], np.cumsum(span)))
    bases = np.where(span > 0, offset[:-1] - low, 0)
    orphan = last < 0
    first[orphan], last[orphan] = 1, 0
    return ChunkRows(first, last, bases, int(offset[-1]))
