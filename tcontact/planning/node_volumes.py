"""Lists of the cells whose volume change is averaged at nodes, as kernels/volume_places.py describes them.

A node that supports hold in all three components has no volume: with one, bonded faces would lock. Blocks all of whose
nodes are held have no volume nodes; each of their cells averages over itself alone.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..kernels import volume_places as places
from ..kernels.lanes import LANE, SEGMENT, WIDTH
from ..mesh.geometry import cell_volumes
from ..mesh.late_rows import Rows
from ..scene.body import Body
from ..scene.cell_blocks import AVERAGED
from .domain import CellBlock, Domain
from .packing import CellPacks


@dataclass(frozen=True)
class NodeVolumes:
    """Volume nodes of cells [m, 4] of a block.

    nodes [m, 4]: the node of each corner, that of the master for an image, or -1 where it is no volume node; shares
    [m]: w_e, 1 over the number of these, or 0 without any; volumes [m]: of the cells at rest.
    """

    nodes: np.ndarray
    shares: np.ndarray
    volumes: np.ndarray

    def totals(self, count: int) -> np.ndarray:
        """Return V_a [count] of every node; 0 where it is no volume node."""
        there = self.nodes >= 0
        part = np.broadcast_to((self.shares * self.volumes)[:, None], self.nodes.shape)
        return np.bincount(self.nodes[there], part[there], count)


def node_volumes(reference: np.ndarray, cells: np.ndarray, held: np.ndarray, master: np.ndarray | None) -> NodeVolumes:
    """Return the volume nodes of cells [m, 4]; held [n]: nodes held in all components; master [n]: of images."""
    named = cells if master is None else master[cells]
    nodes = np.where(held[named], -1, named)
    count = (nodes >= 0).sum(axis=1)
    shares = np.where(count > 0, 1.0 / np.maximum(count, 1), 0.0)
    return NodeVolumes(nodes, shares, cell_volumes(reference, cells, "tet4"))


def held_nodes(body: Body) -> np.ndarray:
    """Return which nodes [n] supports hold or drive in all three components, or rigid parts carry."""
    return np.asarray(np.isfinite(body.prescribed).all(axis=1) | body.tied)


def averages(domain: Domain) -> bool:
    """Return whether cells of a domain have volume changes that are averaged at nodes."""
    return any(block.own.own.formulation == AVERAGED for block in domain.blocks)


def held_in(domain: Domain) -> np.ndarray:
    """Return `held_nodes` [n] of all nodes of a domain; the part of a rank has them from the whole one."""
    if domain.held is not None:
        return domain.held
    return np.concatenate([held_nodes(body.body)[body.node_order] for body in domain.bodies])


def node_shifts(domain: Domain) -> tuple[dict[int, int], int]:
    """Return the number of a volume node less that of its node, of every block that is averaged, and how many exist."""
    shifts, total = {}, 0
    for number, block in enumerate(domain.blocks):
        if block.own.own.formulation == AVERAGED:
            low = int(block.cells.min())
            shifts[number] = total - low
            total += int(block.cells.max()) - low + 1
    return shifts, total


def body_volumes(body: Body, cells: Rows, place: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """Return the number of the volume node of every corner [m, 4], -1 without, and lambda/V_a of each [numbers].

    cells [m, corners]: nodes, numbered by place [n], block after block. None if nothing is averaged.
    """
    if not any(block.formulation == AVERAGED for block in body.blocks):
        return None
    order = np.argsort(place)
    master = None if body.images is None else place[body.images.master[order]]
    corners, factors, first = np.full(cells.shape, -1), [], 0
    for number, block in enumerate(body.blocks):
        last = first + len(block.cells)
        total = np.zeros(len(order))
        if block.formulation == AVERAGED:
            own = node_volumes(body.mesh.nodes[order], cells[first:last], held_nodes(body)[order], master)
            corners[first:last] = np.where(own.nodes < 0, -1, own.nodes + number * len(order))
            total = own.totals(len(order))
        factors.append(np.where(total > 0.0, block.material.parameters[0] / np.where(total > 0.0, total, 1.0), 0.0))
        first = last
    return corners, np.concatenate(factors)


def volume_arrays(domain: Domain, packs: CellPacks) -> tuple[np.ndarray, np.ndarray] | None:
    """Return `volume_lists` and `volumes` of a domain; None without cells that are averaged."""
    if not averages(domain):
        return None
    blocks = {number: block for number, block in enumerate(domain.blocks) if block.own.own.formulation == AVERAGED}
    held, master = held_in(domain), None if domain.images is None else domain.images.master
    lanes = _first_lanes(domain)
    shares, (own_shifts, total) = np.zeros(packs.lanes), node_shifts(domain)
    shifts = dict.fromkeys(range(len(domain.blocks)), 0) | own_shifts
    numbers, in_ring, inverses, around, ring = [], [], [], [], []
    for number, block in blocks.items():
        own = node_volumes(domain.reference, block.cells, held, master)
        lane = _lanes(domain, lanes, number, block)
        shares[lane] = own.shares
        node, starts, cells = _around(domain, block, own)
        close = np.isin(node, block.contact_cells)
        numbers.append(node + shifts[number])
        in_ring.append(close)
        inverses.append(1.0 / own.totals(len(domain.reference))[_masters(domain, node)])
        around += np.split(lane[cells], starts[1:-1])[: len(node)]  # without nodes `split` returns one empty list
        ordinary = block.count - len(block.contact)
        outer = np.unique(cells[np.repeat(close, np.diff(starts))])
        outer = outer[outer < ordinary]
        linear = np.full(len(outer), int(block.material.linear))
        ring.append(np.column_stack([lane[outer], linear, block.cells[outer]]))
    order = np.argsort(~np.concatenate(in_ring), kind="stable")
    lists = [around[i] for i in order]
    listed = np.concatenate(lists) if lists else np.zeros(0, dtype=np.int64)
    segments = packs.segments.reshape(-1, SEGMENT)[:, LANE]
    owner = {first: number % len(domain.blocks) for number, first in lanes.items()}
    touching = [number for number, block in enumerate(domain.blocks) if len(block.contact)]
    parts = {
        places.SHIFTS: np.array([shifts[owner[int(first)]] for first in segments]),
        places.NUMBERS: np.concatenate(numbers)[order],
        places.STARTS: _with_starts(np.array([len(one) for one in lists], dtype=np.int64), listed),
        places.RING: np.concatenate(ring).reshape(-1),
        places.BLOCKS: np.array([(shifts[i], lanes[i + len(domain.blocks)]) for i in touching]).reshape(-1),
    }
    contact_lists, spreads, slopes = _of_contact(domain)
    parts |= contact_lists
    numbers_of = {
        places.SHARES: shares,
        places.CHANGES: np.zeros(total),
        places.INVERSES: np.concatenate(inverses)[order],
        places.SPREADS: np.zeros(spreads),
        places.SLOPES: slopes.reshape(-1),
    }
    head = np.zeros(places.HEAD, dtype=np.int64)
    head[places.COUNT] = len(order)
    head[places.RING_COUNT] = int(np.concatenate(in_ring).sum())
    head[places.RING_CELLS] = len(np.concatenate(ring))
    values = np.concatenate([np.zeros(packs.lanes), *numbers_of.values()])
    _place(head, numbers_of, packs.lanes)
    _place(head, parts, places.HEAD)
    return np.concatenate([head, *parts.values()]).astype(np.int32), values


def _place(head: np.ndarray, parts: dict[int, np.ndarray], first: int) -> None:
    """Note in the head where each part begins, one after another from `first` on; starts of lists count from there."""
    for name, part in parts.items():
        head[name] = first
        if name in (places.STARTS, places.TERMS, places.PRODUCTS):
            part[: part[0]] += first
        first += len(part)


def _of_contact(domain: Domain) -> tuple[dict[int, np.ndarray], int, np.ndarray]:
    """Return the lists of the contact nodes, the numbers that their spreads take, and the slopes [members, SLOPE]."""
    if domain.contact is None or domain.contact.graph is None:
        return {}, 0, np.zeros((0, places.SLOPE))
    graph = domain.contact.graph
    lists = {
        places.MEMBERS: graph.member_start,
        places.TERMS: _with_starts(np.diff(graph.term_start), graph.terms),
        places.PRODUCTS: _with_starts(2 * np.diff(graph.product_start), graph.products.reshape(-1)),
    }
    slopes = np.zeros((len(graph.member_factors), places.SLOPE))
    slopes[:, -1] = graph.member_factors
    return lists, 3 * places.CORNERS * len(graph.cells), slopes


def _with_starts(counts: np.ndarray, entries: np.ndarray) -> np.ndarray:
    """Return the starts [n + 1] of lists within this array, then the lists; the first start is the count of starts."""
    starts = np.concatenate([[0], np.cumsum(counts)]) + len(counts) + 1
    return np.concatenate([starts, entries]).astype(np.int64)


def _first_lanes(domain: Domain) -> dict[int, int]:
    """Return the first lane of the ordinary cells of every block, then of its contact cells; of those that have any."""
    counts = [block.count - len(block.contact) for block in domain.blocks]
    counts += [len(block.contact) for block in domain.blocks]
    padded = [-(-count // WIDTH) * WIDTH for count in counts]
    starts = np.concatenate([[0], np.cumsum(padded)])
    return {number: int(starts[number]) for number, count in enumerate(counts) if count}


def _lanes(domain: Domain, lanes: dict[int, int], number: int, block: CellBlock) -> np.ndarray:
    """Return the lane [m] of every cell of a block."""
    ordinary = block.count - len(block.contact)
    first = np.arange(ordinary) + lanes.get(number, 0)
    return np.concatenate([first, np.arange(len(block.contact)) + lanes.get(number + len(domain.blocks), 0)])


def _masters(domain: Domain, nodes: np.ndarray) -> np.ndarray:
    return nodes if domain.images is None else domain.images.master[nodes]


def _around(domain: Domain, block: CellBlock, own: NodeVolumes) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the volume nodes of a block and its images, starts [n + 1], and the cells round each, ascending."""
    cell, corner = np.nonzero(own.nodes >= 0)
    named = own.nodes[cell, corner]
    order = np.argsort(named, kind="stable")
    cell, named = cell[order], named[order]
    node = np.unique(block.cells)
    master = _masters(domain, node)
    first = np.searchsorted(named, master)
    count = np.searchsorted(named, master, side="right") - first
    there = count > 0
    node, first, count = node[there], first[there], count[there]
    starts = np.concatenate([[0], np.cumsum(count)])
    places_in = np.repeat(first - starts[:-1], count) + np.arange(starts[-1])
    return node, starts, cell[places_in]
