"""The history of a run: one row per step, derived columns at the end (METHOD 2). kernels/columns.py has the table."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..planning.measured import Layout
from .peaks import Peaks

MOST_ROWS = 10**6  # rows kept by default, a few hundred bytes each
LARGE = 2**30  # memory of the history above which a message precedes the run [bytes]

COLUMNS = tuple(column.name for column in Layout().shown)  # columns of every history


class History:
    """Rows of measured values and their integrals over time, which run over every step, also when rows are thinned.

    every: number of steps per row; most: largest number of rows beside the last one, which is always kept; beyond it
    every second one is dropped and `every` doubles; layout: columns of a row; factors: factors of integrals, by their
    columns; mid_step: forces of a row are those of the step that ended there, not of its level.
    """

    def __init__(
        self,
        every: int,
        layout: Layout | None = None,
        factors: Mapping[str, float] | None = None,
        mid_step: bool = False,
        most: int = MOST_ROWS,
    ) -> None:
        self.every, self.most, self.mid_step = every, most, mid_step
        self.layout, self.factors = layout or Layout(), dict(factors or {})
        self._rules = []  # places of the integrands over time, and of their integrals
        for rule in dict.fromkeys(column.rule for column in self.layout.integrals):
            columns = [column for column in self.layout.integrals if column.rule == rule]
            places = [self.layout.numbers([getattr(c, part) for c in columns]) for part in ("integral_of", "name")]
            self._rules.append((rule, *places))
        kicks = [column for column in self.layout.integrals if column.rule == "kicks"]
        self._after = self.layout.numbers([column.integral_of.replace("before", "after") for column in kicks])
        self.steps = 0
        self._rows = np.zeros((256, self.layout.end))
        self.count = 0
        self._last: np.ndarray | None = None
        self.reference_energy = 0.0  # largest kinetic + elastic energy so far
        self.largest_work = 0.0
        self._origin: np.ndarray | None = None
        self._peaks = Peaks(self.layout)

    def add(self, rows: np.ndarray) -> None:
        """Add the measured rows [m, width] of the next m steps."""
        count, width = len(rows), self.layout.width
        if self._last is None:
            self._last = self._origin = np.concatenate([rows[0], np.zeros(self.layout.end - width)])
        table = np.empty((count + 1, self.layout.end))
        table[0], table[1:, :width] = self._last, rows
        for rule, measured, integrals in self._rules:
            table[1:, integrals] = self._added(rule, table, measured)
        table[:, width:] = np.cumsum(table[:, width:], axis=0)
        rows, self._last = table[1:], table[-1].copy()
        largest = (self._column("kinetic", rows) + self._column("elastic", rows)).max()
        self.reference_energy = float(np.fmax(self.reference_energy, largest))
        # a load that begins shows in the kinetic energy half a step before its work
        work = np.abs(self._external_work(rows)) + self._column("applied_kick", rows)
        work += self._column("gravity_kick", rows)
        self.largest_work = float(np.fmax(self.largest_work, work.max()))
        if self.every > 1:
            self._measure(rows)
        self._store(rows[(self.steps + np.arange(count)) % self.every == 0])
        self.steps += count

    def _measure(self, rows: np.ndarray) -> None:
        """Let complete rows count for the largest values; `peaks` does so with those that are kept."""
        self._peaks.add(self._energy(rows), lambda name: self._column(name, rows))

    def _energy(self, rows: np.ndarray) -> np.ndarray:
        """Return the column `energy` [m] of complete rows [J]."""
        with np.errstate(invalid="ignore", over="ignore"):  # a run that blows up
            energy = np.asarray(self.layout.stored(rows.T) - self._external_work(rows))
            for column in self.layout.shown:
                if column.energy == "dissipated":
                    energy = energy + self._column(column.name, rows)
        return energy

    def _added(self, rule: str, table: np.ndarray, places: np.ndarray) -> np.ndarray:
        """Return the increments of the integrals in every step; table: the rows at its start and its end."""
        old, new, step = table[:-1, places], table[1:, places], np.diff(table[:, self.layout.place["time"]], axis=0)
        if rule == "kicks":  # work already, in two parts
            after = table[:-1, self._after].copy()
            if self.steps == 0:
                after[0] = 0.0  # the first row replaces the one before it
            return after + new
        if rule == "sum":  # of the step that ended there
            return new
        if rule == "step":  # force of the step before, not of the level
            return step * new
        return 0.5 * step * (2.0 * new if self.mid_step else old + new)

    def _column(self, name: str, rows: np.ndarray) -> np.ndarray:
        """Return a column [m] or [m, 3] of complete rows; 0 if the scene does not have it."""
        place = self.layout.place.get(name)
        if place is None:
            return np.zeros(len(rows))
        values = rows[:, place] if place.stop - place.start > 1 else rows[:, place.start]
        return self.factors[name] * values if name in self.factors else values.copy()

    def _external_work(self, rows: np.ndarray) -> np.ndarray:
        """Return the work [m] of loads, supports and moving obstacles since the first row [J]."""
        if self._origin is None:
            return np.zeros(len(rows))
        work = self._column("load_work", rows) - self._origin[self.layout.place["load_work"]]
        parts = ("support_work", "obstacle_work", "applied_work", "gravity_work")
        return sum((self._column(name, rows) for name in parts), work)

    def forecast(self, steps: float, beside: int) -> str | None:
        """Return messages about the memory of so many steps; beside: bytes kept besides each row."""
        rows, every = steps / self.every, self.every
        while rows > self.most:
            rows, every = 0.5 * rows, 2 * every
        said = []
        if every > self.every:
            said.append(f"the history will keep every {every}th of about {steps:.2g} rows (history_rows={self.most})")
        size = rows * (8 * self._rows.shape[1] + beside)
        if size > LARGE:
            said.append(
                f"history and pressures will take {size / LARGE:.2g} GiB of memory (a larger history_every helps)"
            )
        return "; ".join(said) or None

    def thin(self) -> bool:
        """Drop every second row, now and later, if there are too many; return whether it did."""
        if self.count <= self.most:
            return False
        self._measure(self._rows[: self.count])
        kept = self._rows[: self.count : 2]
        self._rows[: len(kept)] = kept.copy()
        self.count, self.every = len(kept), 2 * self.every
        return True

    def budget(self) -> float:
        """Return the energy of the start and the work done on the bodies so far [J], a bound of the energy."""
        assert self._origin is not None
        return float(self.layout.stored(self._origin)) + self.largest_work

    def friction_work(self) -> float:
        """Return the work of friction so far [J]."""
        return 0.0 if self._last is None else float(self._column("friction_work", self._last[None])[0])

    def _store(self, rows: np.ndarray) -> None:
        end = self.count + len(rows)
        if end > len(self._rows):
            self._rows = np.concatenate([self._rows, np.zeros((max(end, len(self._rows)), self._rows.shape[1]))])
        self._rows[self.count : end] = rows
        self.count = end

    def finish(self) -> None:
        """Add the last row even if rows are thinned."""
        if self._last is not None and (self.steps - 1) % self.every != 0:
            self._store(self._last[None])

    def checkpoint(self) -> dict[str, Any]:
        """Return the rows, their columns and the running sums."""
        parts = {} if self._last is None else {"last": self._last, "origin": np.asarray(self._origin)}
        sums = np.array([self.reference_energy, self.largest_work])
        return parts | {
            "rows": self._rows[: self.count],
            "names": list(self.layout.place),
            "sums": sums,
            "steps": self.steps,
            "every": self.every,
            "peaks": self._peaks.checkpoint(),
        }

    def restore(self, saved: dict[str, Any]) -> None:
        """Set the state that `checkpoint` returned. Raises `KeyError` for rows with other columns."""
        if list(saved["names"]) != list(self.layout.place):
            raise KeyError("columns")
        self._rows, self.steps = saved["rows"], saved["steps"]
        self.every = saved["every"]
        self.count = len(self._rows)
        self.reference_energy, self.largest_work = map(float, saved["sums"])
        self._last, self._origin = saved.get("last"), saved.get("origin")
        if "peaks" in saved:  # those of earlier versions have none
            self._peaks.restore(saved["peaks"])

    def peaks(self) -> dict[str, float]:
        """Return `Result.peaks`."""
        if self.count:
            self._measure(self._rows[: self.count])
        return self._peaks.columns(self.reference_energy)

    def worst(self) -> tuple[float, float]:
        """Return the largest energy error of all steps, with the sign of the change, and its time [s]."""
        error = self.peaks()["energy_error"]
        return float(np.copysign(error, self._peaks.change)), self._peaks.when

    def columns(self) -> dict[str, np.ndarray]:
        """Return the public history: name -> array [rows] or [rows, 3]."""
        rows = self._rows[: self.count]
        result = {column.name: self._column(column.name, rows) for column in self.layout.shown}
        result["external_work"] = self._external_work(rows)
        result["energy"] = self._energy(rows)
        scale = self.reference_energy
        with np.errstate(invalid="ignore"):  # a run that blew up
            change = np.abs(result["energy"] - result["energy"][0]) if len(rows) else np.zeros(0)
        result["energy_error"] = change / scale if scale > 0.0 else change
        return result
