"""Loads of a domain that functions of time drive, or forces of the user's own: their numbers for every time level."""

from __future__ import annotations

import numpy as np

from ..base.errors import FunctionError
from ..device import arrays
from ..kernels.lanes import MAXIMUM_ROWS
from ..kernels.load_places import HEAD, NODE, PLACE_BEFORE, SUMS_AT
from ..planning.applied_loads import PackedLoads
from ..planning.domain import Domain
from ..scene.time_functions import TimeFunction


class AppliedLoads:
    """The rows of kernels/load_places.py in the array `load` of the boundary nodes, which hold all other state.

    gravity: its function of time; sums: place of their sums among those of a step. A row is that of the level which a
    step ends at; the kernel applies it when the nodes have moved there, and own forces are asked for just then. If one
    fails, it keeps its value, and `prepare` raises before anything moves from that level on.
    """

    def __init__(
        self, domain: Domain, packed: PackedLoads, load: arrays.Array, gravity: TimeFunction, sums: int
    ) -> None:
        self._load, self._first = load, 3 * len(domain.boundary)
        self._at, self.width, self._rows = self._first + packed.table, packed.width, packed.rows
        self.functions, self._own = list(packed.functions), packed.own
        if domain.pulled:
            self.functions.append((gravity, 0))
        self._next = np.zeros(self.width)
        self._prepared: tuple[float, ...] = ()
        self._failed, self._reason, self._told = -1, "", False  # own force that failed, why, and whether it was raised
        self._reference = domain.reference
        boundary = np.full(len(domain.reference), -1)
        boundary[domain.boundary] = np.arange(len(domain.boundary))
        nodes = packed.data[HEAD : HEAD + NODE * int(packed.data[1])].reshape(-1, NODE)[:, 0]
        number = np.full(len(domain.boundary), -1)
        number[nodes.astype(int)] = np.arange(len(nodes))
        self._numbers = [number[boundary[own.nodes]] for own in self._own]
        arrays.set_values(load, np.array([float(sums)]), self._first + SUMS_AT)

    @property
    def varies(self) -> bool:
        """Return whether its numbers depend on time."""
        return self._rows > 1 or bool(self._own)

    def rows_at_once(self, small: bool) -> int:
        """Return the largest number of rows of a launch; small: a launch, or a block of them, takes many steps."""
        if self._rows > 1:
            return self._rows - 1 if small else 1
        return 1 if self._own else MAXIMUM_ROWS

    def start(self, u: arrays.Array, velocity: np.ndarray) -> None:
        """Set the row of t = 0; velocity [n, 3]: at the start. Raises `FunctionError`."""
        self._next = self._values(np.zeros(1))[0]
        for own in self._own:
            positions = self._positions(u, own.nodes)
            self._put(own.place, own.load.own_force(positions, velocity[own.nodes].copy(), 0.0))
        arrays.set_values(self._load, self._next, self._at)

    def prepare(self, time: float, before: float, after: float, rows: int) -> None:
        """Compute the rows of levels time + after, ..., see `Timed`."""
        if self._failed >= 0 and (after > 0.0 or not self._told):
            load, self._told = self._own[self._failed].load, True
            raise FunctionError(f"Load.force on {load.set!r}", load.value, self._reason)
        wanted = (time, after, float(rows))
        if after <= 0.0 or wanted == self._prepared:
            return
        table = self._values(np.cumsum([time, *[after] * rows])[1:])
        if self._own:
            own = [(own.place, self._next[own.place : own.place + 3 * len(own.nodes)].copy()) for own in self._own]
            self._next = table[0]
            for place, values in own:
                self._put(place, values)
        else:
            arrays.set_values(self._load, table, self._at + self.width)
        self._prepared = wanted

    def ask(self, u: arrays.Array, time: float, step: float) -> None:
        """Compute the own forces at the level `time`, to which the nodes have moved in a step [s]."""
        data = arrays.get(self._load)
        places = data[self._first + HEAD :]
        for index, (own, numbers) in enumerate(zip(self._own, self._numbers, strict=True)):
            before = np.stack([places[NODE * numbers + PLACE_BEFORE + axis] for axis in range(3)], axis=1)
            positions = self._positions(u, own.nodes)
            velocities = (positions - self._reference[own.nodes] - before) / step
            try:
                self._put(own.place, own.load.own_force(positions, velocities, time))
            except FunctionError as error:
                self._failed, self._reason, self._told = index, error.remedy, False
        arrays.set_values(self._load, self._next, self._at)

    def _positions(self, u: arrays.Array, nodes: np.ndarray) -> np.ndarray:
        return np.asarray(self._reference[nodes] + np.array(arrays.get(u)).reshape(-1, 3)[nodes])

    def _put(self, place: int, values: np.ndarray) -> None:
        self._next[place : place + values.size] = values.reshape(-1)

    def _values(self, times: np.ndarray) -> np.ndarray:
        """Return rows [m, width] at the times [s], 0 for own forces. Raises `FunctionError`."""
        table = np.zeros((len(times), self.width))
        for function, place in self.functions:
            table[:, place : place + function.size] = function.at(times)
        return table
