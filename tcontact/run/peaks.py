"""The largest values of all steps of a run: of the rows that the history keeps, and of those that it drops."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..planning.measured import Layout
from ..results.acting_force import OBSTACLE, PAIR


class Peaks:
    """The largest change of the energy since the first row, and the largest length of each contact force.

    names: columns of these forces: of all bodies, of each obstacle that has one, of each pair.
    """

    def __init__(self, layout: Layout) -> None:
        self.names = [name for name in layout.place if name == "contact_force" or name.startswith((OBSTACLE, PAIR))]
        self._start: float | None = None
        self.change = self.when = 0.0  # of the largest change of the energy: signed [J], and its time [s]
        self._largest = np.zeros(len(self.names))

    def add(self, energy: np.ndarray, column: Callable[[str], np.ndarray]) -> None:
        """Add the energies [m] of the next steps; column: returns a column [m] or [m, 3] of these steps by its name."""
        self._start = float(energy[0]) if self._start is None else self._start
        with np.errstate(invalid="ignore", over="ignore"):  # a run that blows up
            sizes = [np.linalg.norm(column(name), axis=1).max() for name in self.names]
            self._largest = np.maximum(self._largest, sizes)
            changes = energy - self._start
            row = int(np.abs(changes).argmax())  # the first that is no number, if there is one
            if not abs(changes[row]) <= abs(self.change) and not np.isnan(self.change):
                self.change, self.when = float(changes[row]), float(column("time")[row])

    def columns(self, scale: float) -> dict[str, float]:
        """Return the largest energy error and the largest forces [N] by their columns; scale [J]: of the error."""
        error = abs(self.change) / scale if scale > 0.0 else abs(self.change)
        return {"energy_error": error} | dict(zip(self.names, self._largest.tolist(), strict=True))

    def checkpoint(self) -> np.ndarray:
        """Return the energy of the first row and the largest values so far."""
        return np.array([np.nan if self._start is None else self._start, self.change, self.when, *self._largest])

    def restore(self, saved: np.ndarray) -> None:
        """Set the state that `checkpoint` returned."""
        numbers, self._largest = np.split(saved, [len(saved) - len(self.names)])
        start, self.change = numbers[:2].tolist()
        self.when = float(numbers[2]) if len(numbers) > 2 else 0.0  # earlier versions kept no time
        self._start = None if np.isnan(start) else start
