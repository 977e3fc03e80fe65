"""The stiffness of the contact nodes as index arrays: contact cells, the graph of the nodes, its colouring.

They are built once per body with numpy; the kernels only read them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from ..kernels.volume_places import CORNERS
from ..mesh.geometry import cells_at
from ..mesh.late_rows import Rows


@dataclass(frozen=True)
class ContactGraph:
    """Graph of the contact nodes 0..k-1, numbered colour by colour; an entry is a block (row, column) of K_KK.

    nodes [k]: node ids; colour_start [colours]: first node of each colour; cells [c]: cells with contact nodes;
    pair_start [c+1], pair_corners [p, 2], pair_nodes [p, 2]: pairs of contact corners of each cell, the lower one
    first, and their nodes; row_start [k+1], column [e]: block rows of K_KK, the diagonal entry first; entry_start
    [e+1], entry_pairs: the pairs whose blocks add up to an entry, -1 - p for the transpose of pair p.
    Of volume changes averaged at nodes (kernels/volume_places.py): member_start [k+1], member_factors [q]: members of
    each contact node; term_start [q+1], terms: their corners, 4 * contact cell + corner; product_start [e+1], products
    [.., 2]: of two members.
    """

    nodes: np.ndarray
    colour_start: np.ndarray
    cells: np.ndarray
    pair_start: np.ndarray
    pair_corners: np.ndarray
    pair_nodes: np.ndarray
    row_start: np.ndarray
    column: np.ndarray
    entry_start: np.ndarray
    entry_pairs: np.ndarray
    member_start: np.ndarray
    member_factors: np.ndarray
    term_start: np.ndarray
    terms: np.ndarray
    product_start: np.ndarray
    products: np.ndarray

    @property
    def colours(self) -> int:
        """Number of colours."""
        return len(self.colour_start)

    @property
    def corners_together(self) -> int:
        """The largest number of contact nodes of one cell, or round one volume node."""
        own = self.pair_corners[:, 0] == self.pair_corners[:, 1]
        cells = int(np.add.reduceat(own, self.pair_start[:-1]).max())
        return max(cells, int(np.bincount(self.products[:, 0], minlength=1).max()))


def contact_graph(
    cells: Rows,
    nodes: np.ndarray,
    node_count: int,
    repeated: np.ndarray | None = None,
    volumes: tuple[np.ndarray, np.ndarray] | None = None,
) -> ContactGraph:
    """Build the graph of the contact nodes [k] of a body with cells [m, corners].

    repeated [m, corners]: places that repeat a corner and do not count; None: there are none. volumes: number of the
    volume node of each corner [m, corners], -1 without, and factor of each [numbers]; None: nothing is averaged.
    """
    slot = np.full(node_count, -1)
    slot[nodes] = np.arange(len(nodes))
    contact_cells = cells_at(slot >= 0, cells)
    averaged, factors = np.full((1, 1), -1), np.zeros(0)
    if volumes is not None:
        averaged, factors = volumes[0][contact_cells], volumes[1]
    before = slot[cells[contact_cells]]
    colour = _colours([*before.tolist(), *_together(before, averaged)], len(nodes))
    order = np.lexsort((nodes, colour))
    nodes = nodes[order]
    slot[nodes] = np.arange(len(nodes))
    local = slot[cells[contact_cells]]  # [c, corners]
    if repeated is not None:
        local[repeated[contact_cells]] = -1
    width = cells.shape[1]

    first, second = np.triu_indices(width)
    cell, pair = np.nonzero((local[:, first] >= 0) & (local[:, second] >= 0))
    corners = np.stack([first[pair], second[pair]], axis=1)
    numbers = np.stack([local[cell, corners[:, 0]], local[cell, corners[:, 1]]], axis=1)
    two = np.flatnonzero(corners[:, 0] != corners[:, 1])  # their blocks stand in K_KK twice
    ends = np.concatenate([numbers, numbers[two, ::-1]])
    source = np.concatenate([np.arange(len(numbers)), -1 - two])
    owner, number, member, terms = _members(local, averaged)
    products = _products(number)
    ends = np.concatenate([ends, owner[products]])
    key = ends[:, 0] * (len(nodes) + 1) + np.where(ends[:, 0] == ends[:, 1], 0, ends[:, 1] + 1)
    unique, entry = np.unique(key, return_inverse=True)
    row, shifted = np.divmod(unique, len(nodes) + 1)
    entry, product = np.split(entry.reshape(-1), [len(source)])
    return ContactGraph(
        nodes=nodes,
        colour_start=_starts(colour, int(colour.max(initial=0)) + 1)[:-1],
        cells=contact_cells,
        pair_start=_starts(cell, len(contact_cells)),
        pair_corners=corners,
        pair_nodes=numbers,
        row_start=_starts(row, len(nodes)),
        column=np.where(shifted == 0, row, shifted - 1),
        entry_start=_starts(entry, len(unique)),
        entry_pairs=source[np.argsort(entry, kind="stable")],
        member_start=_starts(owner, len(nodes)),
        member_factors=factors[number],
        term_start=_starts(member, len(owner)),
        terms=terms,
        product_start=_starts(product, len(unique)),
        products=products[np.argsort(product, kind="stable")],
    )


def joined(graphs: Sequence[ContactGraph], first_nodes: Sequence[int]) -> ContactGraph:
    """Join graphs that do not couple into one, one after another; each is an island of it.

    first_nodes: first node of each graph in the common numbering; cells keep their numbers.
    """
    total: dict[str, list[np.ndarray]] = {field.name: [] for field in fields(ContactGraph)}
    nodes = pairs = entries = sources = cells = members = terms = products = 0
    for graph, first in zip(graphs, first_nodes, strict=True):
        shifts = {"nodes": first, "colour_start": nodes, "pair_nodes": nodes, "column": nodes}
        shifts |= {"pair_start": pairs, "row_start": entries, "entry_start": sources}
        shifts |= {"member_start": members, "products": members, "term_start": terms, "product_start": products}
        shifts["terms"] = CORNERS * cells
        for name, parts in total.items():
            parts.append(getattr(graph, name) + shifts.get(name, 0))
        total["entry_pairs"][-1] += np.where(graph.entry_pairs < 0, -pairs, pairs)
        nodes, pairs = nodes + len(graph.nodes), pairs + len(graph.pair_nodes)
        entries, sources = entries + len(graph.column), sources + len(graph.entry_pairs)
        cells, members = cells + len(graph.cells), members + len(graph.member_factors)
        terms, products = terms + len(graph.terms), products + len(graph.products)
    # where one ends the next one begins
    for name in ("pair_start", "row_start", "entry_start", "member_start", "term_start", "product_start"):
        total[name] = [part[:-1] for part in total[name][:-1]] + total[name][-1:]
    return ContactGraph(**{name: np.concatenate(parts) for name, parts in total.items()})


def residual_receivers(
    cells: np.ndarray, reference: np.ndarray, boundary: np.ndarray, count: int
) -> tuple[np.ndarray, np.ndarray]:
    """Find the boundary nodes that take the force that the static solve leaves at a contact node, in equal shares.

    Returns start [k+1] and rows of the boundary list. The first `count` boundary nodes are the contact nodes; the
    receivers of one are the other boundary nodes in its cells (they carry its mass), or the nearest one without any.
    """
    row = np.full(len(reference), -1)
    row[boundary[:count]] = np.arange(count)
    near = cells_at(row >= 0, cells)
    row[boundary] = np.arange(len(boundary))
    local = row[cells[near]]
    first, second = np.meshgrid(np.arange(cells.shape[1]), np.arange(cells.shape[1]), indexing="ij")
    pairs = np.stack([local[:, first.ravel()].ravel(), local[:, second.ravel()].ravel()], axis=1)
    pairs = np.unique(pairs[(pairs[:, 0] >= 0) & (pairs[:, 0] < count) & (pairs[:, 1] >= count)], axis=0)
    alone = np.setdiff1d(np.arange(count), pairs[:, 0])
    if len(alone) and len(boundary) > count:
        others = reference[boundary[count:]]
        nearest = [np.linalg.norm(others - reference[boundary[k]], axis=1).argmin() + count for k in alone]
        pairs = np.concatenate([pairs, np.stack([alone, nearest], axis=1)])
        pairs = pairs[np.argsort(pairs[:, 0], kind="stable")]
    return _starts(pairs[:, 0], count), pairs[:, 1]


def _starts(owner: np.ndarray, count: int) -> np.ndarray:
    return np.concatenate([[0], np.cumsum(np.bincount(owner, minlength=count))])


def _members(local: np.ndarray, averaged: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return the contact node and the volume node of every member, and the members [t] and terms [t] in their order.

    local [c, corners]: contact node of a corner, averaged: its volume node; -1 without.
    """
    cell, corner, other = np.nonzero((local[:, :, None] >= 0) & (averaged[:, None, :] >= 0))
    limit = int(averaged.max(initial=0)) + 1
    key = local[cell, corner] * limit + averaged[cell, other]
    unique, member = np.unique(key, return_inverse=True)
    owner, number = np.divmod(unique, limit)
    order = np.argsort(member, kind="stable")
    return owner, number, member[order], (CORNERS * cell + corner)[order]


def _products(number: np.ndarray) -> np.ndarray:
    """Return all ordered pairs of members [.., 2] with the same volume node."""
    order = np.argsort(number, kind="stable")
    _, first, inverse, size = np.unique(number[order], return_index=True, return_inverse=True, return_counts=True)
    first, size = first[inverse.reshape(-1)], size[inverse.reshape(-1)]  # of the volume node of each member
    left = np.repeat(np.arange(len(order)), size)
    before = np.concatenate([[0], np.cumsum(size)])[:-1]
    right = np.repeat(first - before, size) + np.arange(len(left))
    return np.stack([order[left], order[right]], axis=1)


def _together(local: np.ndarray, averaged: np.ndarray) -> list[list[int]]:
    """Return the contact nodes of the cells round each volume node."""
    owner, number, _, _ = _members(local, averaged)
    order = np.argsort(number, kind="stable")
    ends = np.flatnonzero(np.diff(number[order])) + 1
    return [part.tolist() for part in np.split(owner[order], ends)]


def _colours(together: list[list[int]], count: int) -> np.ndarray:
    """Colour greedily the graph whose edges join the contact nodes of each list; -1 is no node."""
    neighbours: list[set[int]] = [set() for _ in range(count)]
    for row in together:
        members = [node for node in row if node >= 0]
        for node in members:
            neighbours[node].update(members)
    colour = np.full(count, -1)
    for node in range(count):
        used = {colour[other] for other in neighbours[node] if other != node}
        colour[node] = next(number for number in range(len(used) + 1) if number not in used)
    return colour
