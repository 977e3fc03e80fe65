"""Islands of contact nodes that ranks share: where the numbers stand that they exchange in the static solve."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..device.exchange import Exchange, Handover
from ..device.team import Team
from ..kernels.lanes import SWEEP_LANES
from ..planning.domain import Domain
from ..planning.partition.shared_contact import Lists, SharedContact
from .massless_contact import MasslessContactTerm


@dataclass(frozen=True, eq=False)
class SharedIsland:
    """An island on this rank, and what it exchanges.

    number: of the island here; team: the ranks that have a part of it, None for this one alone; colours [c]: first and
    last + 1 pack of each colour of the whole island; own [2]: first and last + 1 node that this rank solves;
    ghosts: where their increments stand; forces, diagonals: sums over copies; rows: sums of rows at their owners;
    increments: of each colour, all of them, active rows and friction: from owners to copies.
    """

    number: int
    team: Team | None
    colours: Sequence[tuple[int, int]]
    own: tuple[int, int]
    ghosts: np.ndarray
    forces: Exchange
    diagonals: Exchange
    rows: Handover
    increments: Sequence[Handover]
    everyone: Handover
    active: Handover
    friction: Handover | None


class ExchangePlaces:
    """Where the numbers stand that the ranks exchange for the contact of a domain; room: nodes of `System.right`."""

    def __init__(self, team: Team, domain: Domain, contact: MasslessContactTerm, room: int) -> None:
        self.team, self.domain, self.contact, self.room = team, domain, contact, room
        self.shared: SharedContact = domain.shared
        everyone = np.concatenate([self.shared.nodes, self.shared.ghosts])
        self.colour = np.searchsorted(self.shared.colour_start, everyone, side="right") - 1

    def island(self, number: int, team: Team | None) -> SharedIsland:
        """Return an island of this rank; team: as in `SharedIsland`."""
        shared, contact, block = self.shared, self.contact, self.contact.block
        nodes = contact.islands[number].nodes
        firsts = shared.starts
        begin = int(np.searchsorted(firsts, shared.nodes[nodes.start], side="right")) - 1
        whole = firsts[begin], firsts[begin + 1]  # its contact nodes in the whole domain
        inside = np.concatenate([shared.nodes, shared.ghosts])
        inside = (inside >= whole[0]) & (inside < whole[1])
        colours = [c for c, first in enumerate(shared.colour_start) if whole[0] <= first < whole[1]]
        packs = np.array([self._packs(*shared.colours[colour]) for colour in colours]).reshape(-1, 2)
        of_row = inside[: len(shared.nodes)]
        entries = np.repeat(of_row, np.diff(shared.graph.row_start)) if shared.graph is not None else of_row
        sent, received = ([(o, p[inside[p]]) for o, p in lists] for lists in (shared.sent, shared.received))
        copies = [(other, rows[of_row[rows]]) for other, rows in shared.copies]
        copies = [(other, rows) for other, rows in copies if len(rows)]
        rows = [[(o, e[entries[e]]) for o, e in lists] for lists in (shared.rows_sent, shared.rows_received)]
        k = len(shared.nodes)
        own_copies = [(other, nodes_of[nodes_of < k]) for other, nodes_of in received]
        return SharedIsland(
            number,
            team,
            [(int(first), int(last)) for first, last in packs],
            (nodes.start, nodes.start + int(shared.owned[nodes].sum())),
            k + np.flatnonzero(inside[k:]),
            self.team.exchange(copies, 4),
            self.team.exchange(copies, block * block),
            self.team.handover(*(self._blocks(lists) for lists in rows)),
            [self._increments(sent, received, colour) for colour in colours],
            self._increments(sent, received, None),
            self.team.handover(_flat(self._held(sent), 1), _flat(own_copies, 1)),
            self._friction(self._held(sent), own_copies),
        )

    def _packs(self, begin: int, end: int) -> tuple[int, int]:
        """Return first and last + 1 pack of the nodes begin .. end, which are of one colour."""
        starts = self.contact.order.pack_start
        return (0, 0) if begin == end else (int(np.searchsorted(starts, begin)), int(np.searchsorted(starts, end)))

    def _increments(self, sent: Sequence, received: Sequence, colour: int | None) -> Handover:
        """Return what hands over the increments of a colour, None: of all of them."""
        steps = self.room * np.arange(self.contact.block)

        def places(lists: Sequence) -> list[tuple[int, np.ndarray]]:
            chosen = [(o, p if colour is None else p[self.colour[p] == colour]) for o, p in lists]
            return [(other, nodes[:, None] + steps) for other, nodes in chosen]

        return self.team.handover(places(sent), places(received))

    def _blocks(self, lists: Sequence) -> list[tuple[int, np.ndarray]]:
        """Return the places of blocks of K_KK in `System.values`."""
        size = SWEEP_LANES * np.arange(self.contact.block**2)
        places = self.contact.order.entry_place
        return [(other, places[entries][:, None] + size) for other, entries in lists]

    def _held(self, sent: Sequence) -> list[tuple[int, np.ndarray]]:
        """Return the nodes that others have copies of, of those whose increments they get."""
        copies = {other: set(rows.tolist()) for other, rows in self.shared.copies}
        return [(o, p[[n in copies.get(o, set()) for n in p.tolist()]]) for o, p in sent]

    def _friction(self, sent: Sequence, received: Sequence) -> Handover | None:
        """Return what hands over the friction in the rows of nodes, None without friction in the static solve."""
        options = self.contact.options
        if not options.static_friction:
            return None
        at, slots = options.row_places, self.contact.slots
        columns = np.array([at.pressing, *(at.traction + np.arange(3))])
        numbers = (at.width * np.arange(slots)[:, None] + columns).reshape(-1)

        def places(lists: Sequence) -> list[tuple[int, np.ndarray]]:
            return [(other, nodes[:, None] * (slots * at.width) + numbers) for other, nodes in lists]

        return self.team.handover(places(sent), places(received))


def _flat(lists: Sequence, width: int) -> Lists:
    return tuple((other, nodes.reshape(-1, width)) for other, nodes in lists)
