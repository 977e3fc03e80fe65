"""Lists with which a GPU steps a domain: the parts of its cells and the corners of every node."""

from __future__ import annotations

import numpy as np

from ..kernels import lanes
from .domain import Domain
from .packing import WIDTH, CellPacks


def device_threads(packs: CellPacks, nodes: int) -> int:
    """Return the threads of each loop: the power of two that has a thread for every cell and node, within limits."""
    wanted = max(packs.lanes, nodes, lanes.FEWEST_THREADS)
    return min(1 << (wanted - 1).bit_length(), lanes.MOST_THREADS)


def parts_of(packs: CellPacks, domain: Domain) -> np.ndarray:
    """Return the parts of the cells by kind, see `DeviceLists`; packs: of one chunk, which has a segment for each part.

    A kind without cells does not exist.
    """
    count = len(domain.kinds)
    segments = packs.segments.reshape(-1, lanes.SEGMENT)
    firsts: list[int] = []
    parts: list[list[int]] = []
    for kind in range(count):
        firsts.append(len(parts))
        lane = 0
        for chunk in range(packs.all_chunks):
            table = packs.chunk_table[chunk * (count + 3) :]
            for segment in segments[table[kind] : table[kind + 1]]:
                assert segment[lanes.FIRST_PACK] == 0
                end = lane + int(segment[lanes.END_PACK]) * WIDTH
                places = segment[[lanes.CONNECTIVITY, lanes.MATERIAL, lanes.MEMORY, lanes.SHAPE]]
                parts.append([lane, end, segment[lanes.END_CELL], *places])
                lane = end
    return np.array([*firsts, len(parts), *np.ravel(parts)], dtype=np.int32)


def corner_places(packs: CellPacks, domain: Domain) -> np.ndarray:
    """Return the places of the corners of every node in `connectivity`: start of each [n + 1], then the places.

    The corners of a node stand in ascending order; those of the lanes that fill up a pack are left out.
    """
    real = []
    at = 0
    counts = [block.count - len(block.contact) for block in domain.blocks]
    corners = [block.own.cells.shape[1] for block in domain.blocks]
    for count, width in zip(counts + [len(block.contact) for block in domain.blocks], corners + corners, strict=True):
        size = -(-count // WIDTH) * WIDTH
        lane = np.arange(size).reshape(-1, 1, WIDTH) < count
        real.append(at + np.flatnonzero(np.broadcast_to(lane, (size // WIDTH, width, WIDTH))))
        at += size * width
    places = np.concatenate(real)
    nodes = packs.connectivity[places]
    order = np.argsort(nodes, kind="stable")
    starts = np.searchsorted(nodes[order], np.arange(len(domain.reference) + 1)) + len(domain.reference) + 1
    return np.concatenate([starts, places[order]]).astype(np.int32)
