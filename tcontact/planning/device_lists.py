"""Lists with which a GPU steps a domain: the parts of its cells and the corners of every node."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..kernels import lanes
from ..kernels.load_places import ENTRIES, ENTRY, FACE, FACES, HEAD, NODE, NODES
from .contact_graph import ContactGraph
from .domain import Domain
from .islands import Island
from .packing import WIDTH, CellPacks


def device_threads(packs: CellPacks, nodes: int) -> int:
    """Return the threads of each loop: the power of two that has a thread for every cell and node, within limits."""
    return _power_of_two(max(packs.lanes, nodes, lanes.FEWEST_THREADS))


def surface_threads(packs: CellPacks) -> int:
    """Return the threads of a loop over the contact cells of a kind, within the same limits."""
    return _power_of_two(max(packs.lanes - packs.first_contact_lane, lanes.FEWEST_THREADS))


def threads_of(items: int) -> int:
    """Return the threads of a loop over so many items, within the same limits."""
    return _power_of_two(max(items, lanes.FEWEST_THREADS))


def _power_of_two(wanted: int) -> int:
    return min(1 << (wanted - 1).bit_length(), lanes.MOST_THREADS)


def parts_of(packs: CellPacks, domain: Domain, contact: bool = False) -> np.ndarray:
    """Return the parts of the cells by kind, see `DeviceLists`; packs: of one chunk, which has a segment for each part.

    A kind without cells does not exist; contact: of the contact cells alone, without which a kind has no parts.
    """
    count = len(domain.kinds)
    segments = packs.segments.reshape(-1, lanes.SEGMENT)
    firsts: list[int] = []
    parts: list[list[int]] = []
    for kind in range(count):
        firsts.append(len(parts))
        lane = 0
        for chunk in range(packs.chunks if contact else 0, packs.all_chunks):
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


def surface_corners(node_corners: np.ndarray, nodes: np.ndarray, lowest: int = 0) -> np.ndarray:
    """Return those of `corner_places` of some nodes [k]: start of each [k + 1], then the places, from `lowest` on."""
    first, end = node_corners[nodes].astype(np.int64), node_corners[nodes + 1].astype(np.int64)
    counts = end - first
    own = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    places, owner = node_corners[np.repeat(first, counts) + own], np.repeat(np.arange(len(nodes)), counts)
    kept = places >= lowest
    starts = len(nodes) + 1 + np.cumsum(np.bincount(owner[kept] + 1, minlength=len(nodes) + 1))
    return np.concatenate([starts, places[kept]]).astype(np.int32)


def residual_donors(start: np.ndarray, receivers: np.ndarray, count: int) -> np.ndarray:
    """Transpose the list of residual receivers of the contact nodes, start [k + 1] and places of boundary nodes.

    Returns for each of `count` boundary nodes the start of its contact nodes [count + 1], then these, ascending.
    """
    owner = np.repeat(np.arange(len(start) - 1), np.diff(start))
    order = np.argsort(receivers, kind="stable")
    starts = count + 1 + np.searchsorted(receivers[order], np.arange(count + 1))
    return np.concatenate([starts, owner[order]]).astype(np.int32)


def load_sources(data: np.ndarray) -> np.ndarray:
    """Return what acts on each loaded node: start of each [nodes + 1], then entries and corners of faces, ascending.

    data: of the loads (kernels/load_places.py); a corner has the number of entries + 4 face + corner.
    """
    nodes, entries, faces = (int(data[place]) for place in (NODES, ENTRIES, FACES))
    first = HEAD + NODE * nodes
    of_entries = data[first : first + ENTRY * entries].reshape(entries, ENTRY)[:, 0]
    first += ENTRY * entries
    of_corners = data[first : first + FACE * faces].reshape(faces, FACE)[:, 4:8]
    owner = np.concatenate([of_entries, of_corners.reshape(-1)]).astype(np.int64)
    starts = nodes + 1 + np.cumsum(np.bincount(owner + 1, minlength=nodes + 1))
    return np.concatenate([starts, np.argsort(owner, kind="stable")]).astype(np.int32)


def colour_lists(graph: ContactGraph, islands: Sequence[Island], pack_start: np.ndarray) -> np.ndarray:
    """Return the first colour of each island [islands + 1], then the first pack of each colour [colours + 1].

    pack_start [packs + 1]: first contact node of each pack, see `SweepOrder`.
    """
    ends = [*(island.nodes.start for island in islands), len(graph.nodes)]
    firsts = np.append(graph.colour_start, len(graph.nodes))
    return np.concatenate([np.searchsorted(firsts, ends), np.searchsorted(pack_start, firsts)]).astype(np.int32)
