"""The contact of a domain that several ranks share, as one of them has it.

The contact cells are cut like all others. A contact node on a cut has a copy on every rank with a cell at it; its
owner, the lowest of them, solves for it. What the ranks exchange in a static solve are lists of places that follow from
the graph of the whole contact, which every rank has planned:

    forces of the contact cells       summed over the copies, by all of them
    blocks of K_KK                    a row is summed by its owner, which then has all of it
    increments of a colour            from the owner to copies, and to ghosts, on which rows of other owners depend
    what a solve leaves unbalanced    shared out to the receivers of a node by the lowest rank with a cell at both

Contact nodes with mass need none of these: every copy computes its own contact force from what all copies have alike.

With pairs of bodies, or where MPRGP solves, every rank with contact cells has all contact nodes, those without cells of
its own as copies too (`is_copied`). The ranks add the forces of the contact cells and K_KK, and each does the whole
search and solve.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...base.errors import InputError
from ...mesh.geometry import Blocks
from ...scene.contact_models import MasslessContact
from ...scene.friction_models import FrictionLayer
from ...scene.scene import Scene
from ..applied_loads import loaded_nodes
from ..body_plan import BodyPlan, held_nodes
from ..contact_graph import ContactGraph
from ..domain import Domain
from ..node_volumes import averages
from .contact_parts import ContactPart, contact_part, receiver_ranks
from .graph_part import graph_part, ranges

Lists = tuple[tuple[int, np.ndarray], ...]  # for every other rank, ascending, places [n] of a list


def hindrance(scene: Scene, domain: Domain) -> str:
    """Return what keeps the contact of a domain on one rank, or ""."""
    contact = domain.contact
    if contact is None or not len(contact.nodes):
        return "contact nodes that supports hold"
    if domain.obstacles:
        return "obstacles that move freely"
    if isinstance(scene.friction, FrictionLayer):
        return "friction layers"
    if domain.images is not None:
        return "periodic sides"
    if contact.graph is not None and averages(domain):
        return "tetrahedra whose volume changes are averaged at nodes"
    if is_copied(domain) and any(_is_loaded(body) for body in domain.bodies):
        return "loads or driven supports on contact nodes that all ranks have"
    massless = isinstance(scene.contact, MasslessContact) and not is_copied(domain)
    if massless and any(_holds_together(body) for body in domain.bodies):
        return "contact nodes that supports hold"
    return ""


def is_copied(domain: Domain) -> bool:
    """Return whether every rank that shares the contact of a domain has all its nodes."""
    return bool(domain.pairs) or domain.projected


def _is_loaded(plan: BodyPlan) -> bool:
    """Return whether loads or supports that functions of time drive, which the first rank has, act on contact nodes."""
    if plan.contact is None:
        return False
    driven = plan.boundary[plan.support_rows[plan.driven >= 0]]
    acting = np.concatenate([loaded_nodes(plan.body), plan.node_order[driven]])
    return bool(np.isin(plan.node_order[plan.contact.all_nodes], acting).any())


def _holds_together(plan: BodyPlan) -> bool:
    """Return whether supports hold contact nodes of a body so that its static solve stays on one rank.

    Held nodes are on the first rank (`body_part.acting_nodes`), which must have contact cells there.
    """
    if plan.contact is None:
        return False
    if plan.contact.graph is None or not len(plan.contact.nodes):
        return True
    held = held_nodes(plan.contact)
    return bool(len(held)) and not np.isin(plan.rows[plan.contact.graph.cells], held).any()


def mesh_starts(domain: Domain) -> np.ndarray:
    """Return the first node of the mesh of every body among those of all bodies of a domain, and their number."""
    return np.cumsum([0, *(body.body.mesh.node_count for body in domain.bodies)])


def mesh_blocks(domain: Domain) -> Blocks:
    """Return the cells of all bodies of a domain by kind, with the nodes of their meshes numbered one after another."""
    pairs = zip(domain.bodies, mesh_starts(domain), strict=False)
    return tuple((kind, rows + first) for body, first in pairs for kind, rows in body.body.mesh.blocks)


def contact_in_meshes(domain: Domain) -> np.ndarray:
    """Return the contact nodes [k] of a domain among those of the meshes of all its bodies."""
    pairs = zip(domain.bodies, mesh_starts(domain), strict=False)
    found = [body.node_order[body.contact.nodes] + first for body, first in pairs if body.contact is not None]
    return np.concatenate([np.zeros(0, dtype=np.int64), *found])


def contact_set_in_meshes(domain: Domain) -> np.ndarray:
    """Return every node [a] of the contact sets of a domain likewise, also those that supports hold."""
    pairs = zip(domain.bodies, mesh_starts(domain), strict=False)
    found = [body.node_order[body.contact.all_nodes] + first for body, first in pairs if body.contact is not None]
    return np.concatenate([np.zeros(0, dtype=np.int64), *found])


def boundary_in_meshes(domain: Domain) -> np.ndarray:
    """Return the boundary nodes [s] of a domain likewise."""
    nodes = np.empty(len(domain.boundary), dtype=np.int64)
    for body, place, first in zip(domain.bodies, domain.boundary_place, mesh_starts(domain), strict=False):
        nodes[place] = body.node_order[body.boundary] + first
    return nodes


@dataclass(frozen=True, eq=False)
class BodyShare:
    """The contact of one body on one rank.

    nodes [k]: numbers among the contact nodes of its plan, those that this rank owns first, each part ascending; owned
    [k]; cells [c]: numbers of the contact cells of this rank in the graph of the plan.
    """

    nodes: np.ndarray
    owned: np.ndarray
    cells: np.ndarray


@dataclass(frozen=True, eq=False)
class SharedContact:
    """The contact of a domain on one of the ranks that share it.

    nodes, owned [k]: as in `BodyShare`, of all bodies; ghosts [g]: numbers among the contact nodes of the whole domain;
    graph: of these nodes, None without a static solve, for which the rest is; entries [e]: numbers of its entries in
    the whole graph; islands: for every island here its number in the whole domain; ranks: for every island of the whole
    domain, the ranks that have a part of it; colours: for every colour of the whole graph the first and last + 1 of the
    own nodes; copies: nodes of which others have copies; sent, received: nodes and ghosts (behind the nodes) whose
    increments go to others or come from them; rows_sent, rows_received: entries of rows that others own, and of own
    rows to which cells of others contribute; pairs [p, 2]: contact node and receiver, a boundary node of the part, that
    this rank serves; receiver_counts [k]: number of all receivers of a contact node; receivers [r]: boundary nodes of
    the part that receive something from some rank; receivers_shared: those of which others have copies, as places in
    `receivers`; copied: every rank of the contact has all its nodes, see `is_copied`. Of the whole domain: centre [3]
    [m]: see `Domain.contact_centre`; colour_start [c]: first contact node of every colour; starts: first contact node
    of every island, and their number.
    """

    nodes: np.ndarray
    owned: np.ndarray
    ghosts: np.ndarray
    graph: ContactGraph | None
    entries: np.ndarray
    islands: tuple[int, ...]
    ranks: tuple[tuple[int, ...], ...]
    colours: np.ndarray
    copies: Lists
    sent: Lists
    received: Lists
    rows_sent: Lists
    rows_received: Lists
    pairs: np.ndarray
    receiver_counts: np.ndarray
    receivers: np.ndarray
    receivers_shared: Lists
    copied: bool
    centre: np.ndarray
    colour_start: np.ndarray
    starts: tuple[int, ...]


class ContactCut:
    """The contact of a whole domain as its ranks share it.

    domain: the whole; rank [m]: of every cell of its bodies.
    """

    def __init__(self, domain: Domain, rank: np.ndarray) -> None:
        assert domain.contact is not None
        self.domain, self.rank, self.graph = domain, rank.astype(np.int64), domain.contact.graph
        self.blocks, self.nodes = mesh_blocks(domain), contact_in_meshes(domain)
        self.number = np.full(int(mesh_starts(domain)[-1]), -1, dtype=np.int64)
        self.number[self.nodes] = np.arange(len(self.nodes))
        self.rank_of_cells = self._rank_of_contact_cells()
        self.copied, self.ranks = is_copied(domain), self._ranks()  # ranks: with cells at the contact sets
        start, rows = np.zeros(len(self.nodes) + 1, dtype=np.int64), np.zeros(0, dtype=np.int64)
        if self.graph is not None:
            start, rows = domain.residual_receivers
        self.receiver_counts = np.diff(start)
        everyone = boundary_in_meshes(domain)
        self.pairs = np.stack([np.repeat(self.nodes, self.receiver_counts), everyone[rows]], axis=1)
        self.server = receiver_ranks(self.blocks, self.rank, *self.pairs.T)

    def _rank_of_contact_cells(self) -> np.ndarray:
        """Return the rank [c] of every contact cell of the graph of the domain."""
        found, first = [np.zeros(0, dtype=np.int64)], 0
        for body in self.domain.bodies:
            if body.contact is not None and body.contact.graph is not None:
                found.append(self.rank[first + body.cell_order[body.contact.graph.cells]])
            first += body.body.mesh.cell_count
        return np.concatenate(found)

    def _ranks(self) -> tuple[int, ...]:
        everyone, found, start = np.zeros(len(self.number), dtype=bool), set[int](), 0
        everyone[contact_set_in_meshes(self.domain)] = True
        for _, rows in self.blocks:
            found |= set(self.rank[start : start + len(rows)][everyone[rows].any(axis=1)].tolist())
            start += len(rows)
        return tuple(sorted(found))

    def common(self, body: int) -> np.ndarray:
        """Return the nodes [k] of the mesh of a body of which all ranks of the contact have copies."""
        plan = self.domain.bodies[body]
        none = np.zeros(0, dtype=np.int64)
        return plan.node_order[plan.contact.all_nodes] if self.copied and plan.contact is not None else none

    def part(self, own: int) -> ContactPart:
        """Return the contact nodes of one rank in the numbers of the meshes."""
        return contact_part(self.blocks, self.rank, self.nodes, own)

    def body_share(self, body: int, own: int, part: ContactPart) -> BodyShare | None:
        """Return the contact of a body on one rank; None without any; part: what `part` returns for it."""
        starts, cells = self.domain.contact_start, self.cells_of(body)
        mine = cells[self.rank_of_cells[cells] == own]
        if self.copied:
            if own not in self.ranks or self.domain.bodies[body].contact is None:
                return None
            count = int(starts[body + 1] - starts[body])
            return BodyShare(np.arange(count), np.full(count, own == self.ranks[0]), mine - cells[:1])
        if self.graph is not None:
            sources = ranges(self.graph.pair_start, mine)
            here = np.unique(self.graph.pair_nodes[sources])
        else:
            here = np.arange(starts[body], starts[body + 1])
            here = here[self._touched(own)[self.nodes[here]]]
        if not len(here):
            return None
        owned = np.zeros(len(self.number), dtype=bool)
        owned[part.owned] = True
        solved = owned[self.nodes[here]]
        nodes = np.concatenate([here[solved], here[~solved]]) - starts[body]
        return BodyShare(nodes, np.arange(len(nodes)) < solved.sum(), mine - cells[:1])

    def _touched(self, own: int) -> np.ndarray:
        """Return whether a rank has cells at a node [n] of the meshes."""
        found, start = np.zeros(len(self.number), dtype=bool), 0
        for _, rows in self.blocks:
            found[rows[self.rank[start : start + len(rows)] == own]] = True
            start += len(rows)
        return found

    def cells_of(self, body: int) -> np.ndarray:
        """Return the numbers of the contact cells of a body in the graph of the domain."""
        counts = [_cell_count(plan) for plan in self.domain.bodies]
        return np.arange(sum(counts[:body]), sum(counts[: body + 1]))

    def ranks_of(self, body: int) -> tuple[int, ...]:
        """Return the ranks with contact cells of a body, ascending."""
        return tuple(np.unique(self.rank_of_cells[self.cells_of(body)]).tolist())


def _cell_count(plan: BodyPlan) -> int:
    return 0 if plan.contact is None or plan.contact.graph is None else len(plan.contact.graph.cells)


def shared_contact(
    cut: ContactCut,
    own: int,
    part: ContactPart,
    shares: list[BodyShare | None],
    boundary: np.ndarray,
    shared: Lists,
) -> SharedContact:
    """Return the contact of a domain on one rank.

    part, shares: of this rank, what `ContactCut` returns; boundary [s]: boundary nodes of its part in the numbers of
    the meshes; shared: boundary nodes of the part of which others have copies.
    """
    domain, graph = cut.domain, cut.graph
    here = [(body, share) for body, share in enumerate(shares) if share is not None]
    none = np.zeros(0, dtype=np.int64)
    nodes = np.concatenate([none, *(share.nodes + domain.contact_start[body] for body, share in here)])
    owned = np.concatenate([none.astype(bool), *(share.owned for _, share in here)])
    cells = np.concatenate([none, *(share.cells + cut.cells_of(body)[:1] for body, share in here)])
    coming = cut.number[np.concatenate([none, *(own for _, own in part.ghosts)])]
    ghosts = np.setdiff1d(coming, nodes) if graph is not None and not cut.copied else none
    place = np.full(len(cut.nodes), -1, dtype=np.int64)
    place[nodes] = np.arange(len(nodes))
    place[ghosts] = len(nodes) + np.arange(len(ghosts))

    def placed(lists: Lists) -> Lists:
        return tuple((other, place[cut.number[numbers]]) for other, numbers in lists)

    found, entries = None, none
    if graph is not None and len(nodes):
        found, entries = graph_part(graph, nodes, owned | cut.copied, ghosts, cells)
    bodies = [number for number, body in enumerate(domain.bodies) if body.contact is not None]
    islands, ranks = tuple(bodies.index(body) for body, _ in here), tuple(cut.ranks_of(body) for body in bodies)
    if cut.copied:
        ranks = (cut.ranks,) * len(bodies)
    if domain.pairs:  # which join all bodies
        islands, ranks = (0,) if here else (), (cut.ranks,)
    single = graph is None or cut.copied  # nothing is handed over
    sent, received = ((), ()) if single else _rows(cut, own, entries)
    row = np.full(len(cut.number), -1, dtype=np.int64)
    row[boundary] = np.arange(len(boundary))
    mine = cut.pairs[cut.server == own]
    receivers = np.unique(row[cut.pairs[:, 1]])
    receivers = receivers[receivers >= 0]
    return SharedContact(
        nodes,
        owned,
        ghosts,
        found,
        entries,
        islands,
        ranks,
        none.reshape(0, 2) if graph is None or cut.copied else _colours(graph, nodes, owned),
        tuple((other, rows[rows < len(nodes)]) for other, rows in shared if (rows < len(nodes)).any()),
        () if single else placed(part.sent),
        () if single else placed(part.ghosts),
        sent,
        received,
        np.stack([place[cut.number[mine[:, 0]]], row[mine[:, 1]]], axis=1),
        cut.receiver_counts[nodes],
        receivers,
        tuple((other, np.searchsorted(receivers, rows[np.isin(rows, receivers)])) for other, rows in shared),
        cut.copied,
        domain.contact_centre,
        none if graph is None else graph.colour_start,
        tuple(sorted({int(start) for start in domain.contact_start})),
    )


def _colours(graph: ContactGraph, nodes: np.ndarray, owned: np.ndarray) -> np.ndarray:
    """Return for every colour of a graph the first and last + 1 [colours, 2] of the own nodes, (0, 0) without any."""
    colour = np.searchsorted(graph.colour_start, nodes, side="right") - 1
    found = np.zeros((len(graph.colour_start), 2), dtype=np.int64)
    for number in np.unique(colour[owned]):
        places = np.flatnonzero(owned & (colour == number))
        found[number] = places[0], places[-1] + 1
    return found


def _rows(cut: ContactCut, own: int, entries: np.ndarray) -> tuple[Lists, Lists]:
    """Return the entries of a rank in rows of others, and the entries of its own rows to which others contribute.

    entries [e]: numbers of the entries of the rank in the whole graph; both in the order of these numbers, and without
    the diagonal, which all copies sum up.
    """
    graph = cut.graph
    assert graph is not None
    if not len(entries):
        return (), ()
    cell_of_pair = np.repeat(np.arange(len(graph.cells)), np.diff(graph.pair_start))
    sources = graph.entry_pairs
    entry = np.repeat(np.arange(len(graph.column)), np.diff(graph.entry_start))
    rank = cut.rank_of_cells[cell_of_pair[np.where(sources < 0, -1 - sources, sources)]]
    row = np.repeat(np.arange(len(graph.nodes)), np.diff(graph.row_start))
    owner = np.full(len(graph.nodes), np.iinfo(np.int64).max, dtype=np.int64)
    np.minimum.at(owner, row[entry], rank)
    off = np.ones(len(graph.column), dtype=bool)
    off[graph.row_start[:-1]] = False
    ranks = int(cut.rank.max()) + 1
    one, by = np.divmod(np.unique((entry * ranks + rank)[off[entry]]), ranks)
    to = owner[row[one]]
    there = np.full(len(graph.column), -1, dtype=np.int64)
    there[entries] = np.arange(len(entries))

    def listed(chosen: np.ndarray, others: np.ndarray) -> Lists:
        return tuple((int(other), there[one[chosen & (others == other)]]) for other in np.unique(others[chosen]))

    return listed((by == own) & (to != own), to), listed((to == own) & (by != own), by)


def check_receivers(domain: Domain) -> bool:
    """Return whether each contact node has a cell in common with all of its receivers."""
    if domain.contact is None or domain.contact.graph is None:  # nothing is left unbalanced
        return True
    blocks, start = mesh_blocks(domain), domain.residual_receivers[0]
    nodes, everyone = contact_in_meshes(domain), boundary_in_meshes(domain)
    rank = np.zeros(sum(len(rows) for _, rows in blocks), dtype=np.int64)
    try:
        receiver_ranks(blocks, rank, np.repeat(nodes, np.diff(start)), everyone[domain.residual_receivers[1]])
    except InputError:
        return False
    return True
