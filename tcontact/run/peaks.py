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
        self._largest = np.zeros(1 + len(self.names))

    def add(self, energy: np.ndarray, column: Callable[[str], np.ndarray]) -> None:
        """Add the energies [m] of the next steps; column: returns a column [m, 3] of these steps by its name."""
        self._start = float(energy[0]) if self._start is None else self._start
        with np.errstate(invalid="ignore", over="ignore"):  # a run that blows up
            sizes = [np.linalg.norm(column(name), axis=1).max() for name in self.names]
            self._largest = np.maximum(self._largest, [np.abs(energy - self._start).max(), *sizes])

    def columns(self, scale: float) -> dict[str, float]:
        """Return the largest energy error and the largest forces [N] by their columns; scale [J]: of the error."""
        change, *forces = self._largest.tolist()
        return {"energy_error": change / scale if scale > 0.0 else change} | dict(zip(self.names, forces, strict=True))

    def checkpoint(self) -> np.ndarray:
        """Return the energy of the first row and the largest values so far."""
        return np.array([np.nan if self._start is None else self._start, *self._largest])

    def restore(self, saved: np.ndarray) -> None:
        """Set the state that `checkpoint` returned."""
        self._start, self._largest = (None if np.isnan(saved[0]) else float(saved[0])), np.array(saved[1:])
