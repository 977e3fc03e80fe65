"""Measured rows: named quantities of a step, from the raw rows of the domains."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from typing import Any

import numpy as np

from ..kernels.columns import COLUMNS, INFINITE, NAN, PROBED, UNREACHED, Column, cell_groups, group_columns
from ..scene.scene import Scene
from .domain import Domain
from .rigid import names_of

COMBINE: dict[str, Callable[..., np.ndarray]] = {
    "sum": np.sum,
    "min": np.min,
    "max": np.max,
    "fmin": np.fmin.reduce,
    "one": np.fmin.reduce,  # one domain has a number, the others have NaN
    "first": lambda values, axis: values[0],
}


class Layout:
    """The places of the columns of a scene in its rows.

    terms: terms of the scene with columns of their own; obstacles, pairs: names of those whose loads are measured;
    probes: columns of its probes;
    rigid: names of the rigid bodies with columns of their own, by group;
    place: slice of each column by name, first the measured ones, then from `width` to `end` the integrals over time;
    shown: columns of the history in their order.
    """

    def __init__(
        self,
        terms: Collection[str] = (),
        obstacles: tuple[str, ...] = (),
        pairs: tuple[str, ...] = (),
        probes: tuple[Column, ...] = (),
        rigid: Mapping[str, tuple[str, ...]] | None = None,
    ) -> None:
        self.terms, self.obstacles, self.pairs = frozenset(terms), obstacles, pairs
        self.named: dict[str, tuple[str, ...]] = {"obstacle": obstacles, "free": (), "part": (), "pair": pairs}
        self.named |= rigid or {}
        mine = [column for column in COLUMNS if not column.term or column.term in self.terms]
        mine += probes
        self.shown = [column for column in self._named(mine) if column.shown]
        self.measured = list(self._named([column for column in mine if column.groups]))
        names = {column.name for column in self.measured}
        self.integrals = [column for column in mine if column.integral_of in names]
        self.place: dict[str, slice] = {}
        self.end = 0
        for column in (*self.measured, *self.integrals):
            self.place[column.name] = slice(self.end, self.end + column.size)
            self.end += column.size
        self.width = sum(column.size for column in self.measured)
        self.empty = np.array([[column.absent for column in self.measured for _ in range(column.size)]])
        gaps = [column.name for column in self.measured if column.absent == INFINITE]
        self.gaps = self.numbers(gaps)
        summed = [column.name for column in self.measured if column.combine in ("sum", "first")]
        self.summed = self.numbers(summed)

    def _named(self, columns: list[Column]) -> Iterator[Column]:
        """Yield the columns; those of an obstacle, rigid body or pair come together, once for each of them."""
        named = self.named
        each = {group: [column for column in columns if group in column.groups] for group in named}
        for column in columns:
            group = next((group for group in named if group in column.groups), None)
            if group is None:
                yield column
            elif column is each[group][0]:
                for name in named[group]:
                    yield from (part._replace(name=f"{part.name}:{name}") for part in each[group])

    def numbers(self, names: Iterable[str]) -> np.ndarray:
        """Return the places of all numbers of these columns, leaving out columns that the scene does not have."""
        places = [self.place[name] for name in names if name in self.place]
        return np.array([number for place in places for number in range(place.start, place.stop)], dtype=int)

    def stored(self, row: np.ndarray) -> Any:
        """Return the stored energy [J] at a row [end], or at each of several [end, m]."""
        return sum(row[self.place[column.name].start] for column in self.measured if column.energy == "stored")


def probe_columns(scene: Scene) -> tuple[Column, ...]:
    """Return the columns of the probes of a scene; only the domain of its body has a number for each."""
    found = []
    for index, body in enumerate(scene.bodies):
        for probe in body.probes:
            name, facts = scene.probe_column(index, probe), probe.facts
            text = f"mean {probe.quantity} of {probe.set!r} of {scene.label(index)}"
            found.append(Column(name, facts.unit, text, facts.size, ("sensors",), PROBED, "one", NAN))
    return tuple(found)


def raw_groups(scene: Scene, domain: Domain) -> tuple[str, ...]:
    """Return the groups of columns in the raw rows of a domain, in their order (kernels/step/raw_rows.py)."""
    groups = ["nodes", *cell_groups(domain.dissipates, domain.plastic)]
    if domain.small or len(domain.boundary) or domain.contact is not None or domain.rigid:
        groups += ["boundary", "support"]
    if domain.contact is not None:
        groups += ["contact", "gaps"]
        if len(domain.contact.nodes):
            groups += ["friction"] if scene.friction is not None else []
            groups += ["loads", *["obstacle"] * len(scene.obstacles)] if scene.tracked else []
    groups += ["applied"] if domain.loaded else []
    groups += ["springs"] if domain.springs else []
    if domain.rigid:
        groups += ["rigid", *(group for group, names in names_of(domain.rigid).items() for _ in names)]
    groups += ["pair"] * len(domain.pairs)  # last: pair_loads.py counts from the end
    return tuple(groups)


class RawRows:
    """Converts raw rows of a domain to measured rows.

    groups: groups of columns of the raw rows, in their order; pairs: names of the pairs of the domain; rigid: those of
    its rigid bodies by group.
    """

    def __init__(
        self,
        groups: tuple[str, ...],
        layout: Layout,
        pairs: Iterable[str] = (),
        rigid: Mapping[str, Iterable[str]] | None = None,
    ) -> None:
        self.layout = layout
        self._loads: dict[str, range] = {}
        # place in a measured row -> place in a raw row; the same where a second group, and a third, add to that place
        layers: list[dict[int, int]] = [{}, {}, {}]
        names, start = {"obstacle": iter(layout.obstacles), "pair": iter(pairs)}, 0
        names |= {group: iter(known) for group, known in (rigid or {}).items()}
        for group in groups:
            name = f":{next(names[group])}" if group in names else ""
            for column in group_columns(group):
                here, start = range(start, start + column.size), start + column.size
                if column.name == "mass_displacement":
                    self._moved = here
                if column.name in ("gravity", "half_step"):
                    self._loads[column.name] = here
                for place, raw in zip(layout.numbers([column.name + name]), here, strict=False):
                    next(layer for layer in layers if place not in layer)[place] = raw
        parts = [np.array([*layer.items()], int).reshape(-1, 2).T for layer in layers if layer]
        self._first, self._further = parts[0], parts[1:]

    def measured(self, raw: np.ndarray, times: np.ndarray, gravity: np.ndarray, mass: float = 0.0) -> np.ndarray:
        """Convert raw rows to measured rows [n, width] at the times [s] with the gravity [m/s^2].

        mass [kg]: of the domain, for a gravity that is a function of time and whose work is an integral over time.
        """
        rows = np.repeat(self.layout.empty, len(raw), axis=0)
        rows[:, self.layout.place["time"].start] = times
        rows[:, self._first[0]] = raw[:, self._first[1]]
        for places, added in self._further:
            rows[:, places] += raw[:, added]
        gaps = rows[:, self.layout.gaps]
        rows[:, self.layout.gaps] = np.where(gaps >= UNREACHED, INFINITE, gaps)
        weight = sum(raw[:, i] * g for i, g in zip(self._moved, gravity, strict=True))  # the same bits for any n
        rows[:, self.layout.place["load_work"].start] += weight
        if "gravity_force" in self.layout.place:
            now, half, place = raw[:, self._loads["gravity"]], raw[:, self._loads["half_step"]], self.layout.place
            rows[:, place["gravity_force"]] = mass * now
            rows[:, place["gravity_kick"]] = 0.5 * mass * half**2 * (now**2).sum(axis=1, keepdims=True)
            rows[:, place["gravity_power"].start] = (now * rows[:, place["momentum"]]).sum(axis=1)
            rows[:, place["load_work"]] = 0.0
        return rows


def combined(rows: list[np.ndarray], layout: Layout, parts: bool = False) -> np.ndarray:
    """Combine the rows [m, width] of all domains, each column by its rule in the table of columns.

    parts: the rows are those of ranks, which have parts of the numbers that one domain has.
    """
    if len(rows) == 1:
        return rows[0]
    total = np.sum(rows, axis=0)
    for column in layout.measured:
        if column.combine != "sum" and not (parts and column.combine == "one"):
            place = layout.place[column.name]
            total[:, place] = COMBINE[column.combine]([row[:, place] for row in rows], axis=0)
    return total
