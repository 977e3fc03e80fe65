"""The state of a contact that ranks share, for a run that goes on with another number of ranks.

Values of contact nodes, rows of K_KK and numbers of islands are known by their places in the contact of the whole
domain: those of the owners in the run before go to all ranks that now have the node. The rest of the solve is written
in every step before it is read.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..contact.massless_contact import MasslessContactTerm
from ..device import arrays
from ..kernels.lanes import SWEEP_LANES
from ..planning.domain import Domain
from ..planning.partition.domain_part import DomainPart
from ..planning.partition.shared_contact import is_copied
from ..planning.sweep_order import sweep_order
from .checkpoint import store
from .loop import Run
from .rank_cut import Cut

OF_CONTACT = re.compile(r"domains\.(\d+)\.contact\.")
OF_OBSTACLES = re.compile(r"domains\.\d+\.contact\.obstacles\.")


@dataclass(frozen=True)
class Held:
    """The contact that a rank has of a domain.

    nodes [k], entries [e], islands: numbers in the whole domain of its contact nodes, of the entries of their rows of
    K_KK, of their islands; owned [k]; places [e]: of the entries in `System.values`, -1 on the diagonal.
    """

    nodes: np.ndarray
    owned: np.ndarray
    entries: np.ndarray
    islands: Sequence[int]
    places: np.ndarray


Form = Callable[[np.ndarray, np.ndarray, Held, Held], None]  # result, data of a checkpoint; of both ranks


def held(whole: Domain, part: DomainPart | None) -> Held | None:
    """Return the contact of a part of a domain, None: of all of it; None if it has no contact."""
    domain = whole if part is None else part.domain
    if domain.contact is None:
        return None
    places = np.zeros(0, dtype=np.int64)
    if domain.contact.graph is not None:
        places = sweep_order(domain.contact.graph, domain.contact.block).entry_place
    shared = None if part is None else part.domain.shared
    if shared is not None:
        return Held(shared.nodes, shared.owned, shared.entries, shared.islands, places)
    count = len(domain.contact.nodes)
    islands = range(sum(body.contact is not None for body in domain.bodies))
    return Held(np.arange(count), np.ones(count, dtype=bool), np.arange(len(places)), islands, places)


def is_shared(cut: Cut, part: DomainPart | None) -> bool:
    """Return whether ranks share a contact, in the run before or in this one."""
    parts = [*cut.parts[:1], *([] if part is None else [part])]
    return any(one.domain.shared is not None for one in parts)


def of_contact(
    run: Run, cuts: Sequence[Cut], stored: Sequence[store.Stored], parts: Sequence[DomainPart] | None
) -> dict[str, np.ndarray]:
    """Return by path the arrays of the contact of this rank in domains whose contact ranks share."""
    found: dict[str, np.ndarray] = {}
    for number, (state, cut) in enumerate(zip(run.domains, cuts, strict=True)):
        part = None if parts is None else parts[number]
        if not is_shared(cut, part) or state.contact is None or is_copied(cut.domain):
            continue
        own = held(cut.domain, part)
        assert own is not None
        before = [held(cut.domain, cut.parts[rank] if cut.parts else None) for rank in range(len(stored))]
        for path, array, form in _arrays(state.contact, f"domains.{number}.contact"):
            result = np.array(arrays.get(array))
            for old, one in zip(before, stored, strict=True):
                if old is not None and path in one.found:
                    form(result, one.found[path], own, old)
            found[path] = result
    return found


class Nodal:
    """Values [k, width] of the contact nodes from place `first` of an array on."""

    def __init__(self, width: int, first: int = 0) -> None:
        self.width, self.first = width, first

    def __call__(self, result: np.ndarray, data: np.ndarray, own: Held, old: Held) -> None:
        """Put the values of the nodes that the rank of a checkpoint owns into `result`."""
        mine, theirs = _both(own.nodes, old.nodes[old.owned], np.flatnonzero(old.owned))
        first = self.first
        into, out = (
            values.reshape(-1)[first : first + self.width * count].reshape(-1, self.width)
            for values, count in ((result, len(own.nodes)), (data, len(old.nodes)))
        )
        into[mine] = out[theirs]


class ByComponent:
    """Values [components, room] of the contact nodes."""

    def __init__(self, components: int) -> None:
        self.components = components

    def __call__(self, result: np.ndarray, data: np.ndarray, own: Held, old: Held) -> None:
        """Put the values of the nodes that the rank of a checkpoint owns into `result`."""
        mine, theirs = _both(own.nodes, old.nodes[old.owned], np.flatnonzero(old.owned))
        result.reshape(self.components, -1)[:, mine] = data.reshape(self.components, -1)[:, theirs]


class OfEntries:
    """Blocks of K_KK off the diagonal."""

    def __init__(self, size: int) -> None:
        self.steps = SWEEP_LANES * np.arange(size)

    def __call__(self, result: np.ndarray, data: np.ndarray, own: Held, old: Held) -> None:
        """Put the blocks of the rows that the rank of a checkpoint owns into `result`."""
        whole = np.isin(np.arange(len(old.entries)), _rows_of_owners(old)) & (old.places >= 0)
        numbers = np.flatnonzero(whole)
        mine, theirs = _both(own.entries, old.entries[numbers], numbers)
        result[own.places[mine][:, None] + self.steps] = data[old.places[theirs][:, None] + self.steps]


class OfIslands:
    """Numbers [islands, width]."""

    def __init__(self, width: int) -> None:
        self.width = width

    def __call__(self, result: np.ndarray, data: np.ndarray, own: Held, old: Held) -> None:
        """Put the numbers of the islands that both have into `result`."""
        for here, island in enumerate(own.islands):
            if island in old.islands:
                there = list(old.islands).index(island)
                result.reshape(-1, self.width)[here] = data.reshape(-1, self.width)[there]


def _both(mine: np.ndarray, theirs: np.ndarray, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the places of common numbers in `mine`, and in an array where `theirs` stand at `places`."""
    _, left, right = np.intersect1d(mine, theirs, assume_unique=True, return_indices=True)
    return left, places[right]


def _rows_of_owners(one: Held) -> np.ndarray:
    """Return the entries that stand in rows which the rank owns: those of a row follow their diagonal entry."""
    row = np.cumsum(one.places < 0) - 1
    return np.flatnonzero(one.owned[row])


def _arrays(contact: Any, path: str) -> Iterator[tuple[str, arrays.Array, Form]]:
    """Yield path, array and form of the state of a contact."""
    slots = contact.slots
    count = len(arrays.get(contact.candidates)) // slots
    yield f"{path}.candidates", contact.candidates, Nodal(slots)
    yield f"{path}.contact_force", contact.contact_force, Nodal(3)
    if isinstance(contact, MasslessContactTerm):
        solve, block = contact.static_solve, contact.block
        size = block * block
        yield f"{path}.active", contact.active, Nodal(1)
        yield f"{path}.displacement_before", contact.displacement_before, Nodal(block)
        yield f"{path}.static_solve.stats", solve.stats, OfIslands(solve.names.STATS)
        yield f"{path}.static_solve.system.inverse", solve.system["inverse"], ByComponent(size)
        yield f"{path}.static_solve.system.stiffness", solve.system["stiffness"], ByComponent(1)
        yield f"{path}.static_solve.system.values", solve.system["values"], OfEntries(size)
    rows = f"{path}.rows.values"
    if contact.friction is not None:
        rows = f"{path}.friction.rows.values"
        names = contact.friction.names
        form = FrictionData(names.FIRST, names.NODE, contact.friction.record_width)
        yield f"{path}.friction.data", contact.friction.data, form
    yield rows, contact.rows.values, Nodal(len(contact.rows.values) // max(1, count))


class FrictionData:
    """Numbers of friction (contact/friction.py): `first` that all ranks have alike, `width` of every contact node.

    Between these and the record at the end, `record` numbers of every node, stand the areas of the nodes and the laws
    of coefficients that vary, which a new run has from its scene.
    """

    def __init__(self, first: int, width: int, record: int) -> None:
        self.first, self.nodal, self.record = first, Nodal(width, first), record

    def __call__(self, result: np.ndarray, data: np.ndarray, own: Held, old: Held) -> None:
        """Put them into `result`."""
        result[: self.first] = data[: self.first]
        self.nodal(result, data, own, old)
        if self.record:
            mine, theirs = (
                values[len(values) - self.record * len(one.nodes) :] for values, one in ((result, own), (data, old))
            )
            Nodal(self.record)(mine, theirs, own, old)
