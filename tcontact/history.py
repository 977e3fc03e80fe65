"""The history of a run: one row per step, derived columns at the end (DESIGN 1, METHOD 2)."""

from __future__ import annotations

import numpy as np

VECTORS = ("contact_force", "impulse", "support_force", "support_impulse", "momentum", "angular_momentum")
COLUMNS = (
    "time",
    "kinetic",
    "elastic",
    "contact",
    "friction_work",
    "external_work",
    "energy",
    "energy_error",
    *VECTORS,
    "gap_min",
    "contact_nodes",
    "sweeps",
    "static_residual",
)
# only in scenes with one-point hexes: hourglass, the part of `elastic` [J] that their hourglass stiffness holds
# what a step measures, in this order; the vectors take three places
MEASURED = {
    "time": 1,
    "kinetic": 1,
    "elastic": 1,
    "contact": 1,
    "load_work": 1,
    "support_power": 1,
    "contact_force": 3,
    "support_force": 3,
    "momentum": 3,
    "angular_momentum": 3,
    "gap_min": 1,
    "contact_nodes": 1,
    "sweeps": 1,
    "static_residual": 1,
    "jacobian_min": 1,
    "hourglass": 1,
}
_ends = np.cumsum(list(MEASURED.values()))
PLACE = {name: slice(end - size, end) for (name, size), end in zip(MEASURED.items(), _ends, strict=True)}
WIDTH = int(_ends[-1])


class History:
    """Rows of measured values; sums along time run over every step, also when rows are thinned.

    extra: columns that only some scenes have, of those measured.
    """

    def __init__(self, every: int, extra: tuple[str, ...] = ()) -> None:
        self.every = every
        self.extra = extra
        self.steps = 0
        self._rows = np.zeros((256, WIDTH + 7))  # measured, then impulse (3), support impulse (3), support work
        self.count = 0
        self._last: np.ndarray | None = None
        self._running = np.zeros(7)
        self.reference_energy = 0.0  # largest kinetic + elastic so far
        self.largest_work = 0.0
        self._origin: np.ndarray | None = None

    def add(self, row: np.ndarray) -> None:
        """Add the measured row of the next step."""
        if self._last is None:
            self._origin = row.copy()
        else:
            half = 0.5 * (row[0] - self._last[0])
            force, support = PLACE["contact_force"], PLACE["support_force"]
            power = PLACE["support_power"]
            self._running[:3] += half * (self._last[force] + row[force])
            self._running[3:6] += half * (self._last[support] + row[support])
            self._running[6] += half * (self._last[power] + row[power])[0]
        self._last = row
        work = self.work(row)
        self.reference_energy = max(self.reference_energy, float(row[1] + row[2]))
        self.largest_work = max(self.largest_work, abs(work))
        if self.steps % self.every == 0:
            self._store(row)
        self.steps += 1

    def work(self, row: np.ndarray) -> float:
        """External work since the start [J]."""
        assert self._origin is not None
        place = PLACE["load_work"]
        return float(row[place][0] - self._origin[place][0] + self._running[6])

    def budget(self) -> float:
        """Energy the run may hold: what it started with and what was put into it [J]."""
        assert self._origin is not None
        return float(self._origin[1] + self._origin[2] + self._origin[3]) + self.largest_work

    def _store(self, row: np.ndarray) -> None:
        if self.count == len(self._rows):
            self._rows = np.concatenate([self._rows, np.zeros_like(self._rows)])
        self._rows[self.count, :WIDTH] = row
        self._rows[self.count, WIDTH:] = self._running
        self.count += 1

    def finish(self) -> None:
        """Keep the last row even when rows are thinned."""
        if self._last is not None and (self.steps - 1) % self.every != 0:
            self._store(self._last)

    def columns(self) -> dict[str, np.ndarray]:
        """The public history: name -> array [rows] or [rows, 3]."""
        rows = self._rows[: self.count]
        result: dict[str, np.ndarray] = {}
        for name, place in PLACE.items():
            column = rows[:, place]
            result[name] = (column if MEASURED[name] == 3 else column[:, 0]).copy()
        work = result.pop("load_work")
        result.pop("support_power")
        result.pop("jacobian_min")
        result["impulse"] = rows[:, WIDTH : WIDTH + 3].copy()
        result["support_impulse"] = rows[:, WIDTH + 3 : WIDTH + 6].copy()
        origin = self._origin[PLACE["load_work"]][0] if self._origin is not None else 0.0
        result["external_work"] = work - origin + rows[:, WIDTH + 6]
        result["friction_work"] = np.zeros(len(rows))
        result["energy"] = result["kinetic"] + result["elastic"] + result["contact"] - result["external_work"]
        scale = self.reference_energy
        with np.errstate(invalid="ignore"):  # a run that blew up
            change = np.abs(result["energy"] - result["energy"][0]) if len(rows) else np.zeros(0)
        result["energy_error"] = change / scale if scale > 0.0 else change
        return {name: result[name] for name in (*COLUMNS, *self.extra)}
