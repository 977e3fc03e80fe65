"""The history of a run: one row per step, derived columns at the end (METHOD 2)."""

from __future__ import annotations

from typing import Any

import numpy as np

from .measured import PLACE, Layout

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
# only with several or moving obstacles: obstacle_force:NAME, obstacle_moment:NAME [rows, 3] on each of them
# only with friction layers: `measured.LAYERS`
# only in scenes with one-point hexes: hourglass, the part of `elastic` [J] that their hourglass stiffness holds
# only with damping: damping_work, dissipated so far [J], part of `energy`; damping_impulse [N s];
# with viscosity: viscous_work, dissipated so far [J], part of `energy`


MOST_ROWS = 10**6  # kept by default: a few hundred bytes each
LARGE = 2**30  # bytes: from here on it is said before the run


class History:
    """Rows of measured values; sums along time run over every step, also when rows are thinned.

    every: rows are kept of every so many steps; most: when there are more, every second one goes and `every` doubles;
    extra: columns that only some scenes have; damping [1/s]: rate of the mass-proportional one; layout: of a row;
    mid_step: forces of a row are those of the step that ended there, not of its level.
    """

    def __init__(
        self,
        every: int,
        extra: tuple[str, ...] = (),
        damping: float = 0.0,
        layout: Layout | None = None,
        mid_step: bool = False,
        most: int = MOST_ROWS,
    ) -> None:
        self.mid_step = mid_step
        self.every, self.most = every, most
        self.extra = extra
        self.steps = 0
        self.damping = damping
        self.layout = layout or Layout()
        width, measured = self.layout.width, self.layout.sizes
        self._integrals = ["contact_force", "support_force", "support_power"]
        if "damping_work" in extra:
            self._integrals += ["kinetic", "momentum"]
        if "viscous_work" in extra:
            self._integrals.append("viscous_power")
        if self.layout.obstacles:
            self._integrals.append("obstacle_power")
        if "friction_before" in measured:
            self._integrals.append("friction_before")
        ends = width + np.cumsum([measured[name] for name in self._integrals])
        # where the running integrals over time stand in a row, after what is measured
        self._place = {name: slice(end - measured[name], end) for name, end in zip(self._integrals, ends, strict=True)}
        self._rows = np.zeros((256, int(ends[-1])))
        self.count = 0
        self._last: np.ndarray | None = None
        self._running = np.zeros(int(ends[-1]) - width)
        self.reference_energy = 0.0  # largest kinetic + elastic so far
        self.largest_work = 0.0
        self._origin: np.ndarray | None = None

    def add(self, rows: np.ndarray) -> None:
        """Add the measured rows [m, width] of the next m steps."""
        count = len(rows)
        places = self.layout.place
        if self._last is None:
            self._origin = rows[0].copy()
            self._last = rows[0]
        table = np.concatenate([self._last[None], rows])
        half = 0.5 * np.diff(table[:, :1], axis=0)
        both = 2.0 * table[1:] if self.mid_step else table[:-1] + table[1:]
        added = np.concatenate([half * both[:, places[name]] for name in self._integrals], axis=1)
        own = {name: place.start - self.layout.width for name, place in self._place.items()}
        if "viscous_power" in own:  # that of the step before, not of the level
            added[:, own["viscous_power"]] = np.diff(table[:, 0]) * table[1:, places["viscous_power"].start]
        if "friction_before" in own:  # work already, in two parts
            after = table[:-1, places["friction_after"].start].copy()
            if self.steps == 0:
                after[0] = 0.0  # the first row stands in for the one before it
            added[:, own["friction_before"]] = after + table[1:, places["friction_before"].start]
        running = np.cumsum(np.concatenate([self._running[None], added]), axis=0)[1:]
        self._running = running[-1]
        self._last = rows[-1].copy()
        assert self._origin is not None
        place = PLACE["load_work"].start
        work = rows[:, place] - self._origin[place] + running[:, 6]
        if "obstacle_power" in own:
            work = work + running[:, own["obstacle_power"]]
        self.reference_energy = float(np.fmax(self.reference_energy, (rows[:, 1] + rows[:, 2]).max()))
        self.largest_work = float(np.fmax(self.largest_work, np.abs(work).max()))
        kept = np.flatnonzero((self.steps + np.arange(count)) % self.every == 0)
        self._store(rows[kept], running[kept])
        self.steps += count

    def forecast(self, steps: float, beside: int) -> str | None:
        """What a user should know before so many steps; beside: bytes kept beside each row."""
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
        """Drop every second row if there are more than wanted, and keep as few from now on; whether it did."""
        if self.count <= self.most:
            return False
        kept = self._rows[: self.count : 2]
        self._rows[: len(kept)] = kept.copy()
        self.count, self.every = len(kept), 2 * self.every
        return True

    def budget(self) -> float:
        """Energy the run may hold: what it started with and what was put into it [J]."""
        assert self._origin is not None
        return float(self._origin[1] + self._origin[2] + self._origin[3]) + self.largest_work

    def rubbed(self) -> float:
        """Work of friction so far [J]."""
        place = self._place.get("friction_before")
        return 0.0 if place is None else float(self._running[place.start - self.layout.width])

    def _store(self, rows: np.ndarray, running: np.ndarray) -> None:
        end = self.count + len(rows)
        if end > len(self._rows):
            self._rows = np.concatenate([self._rows, np.zeros((max(end, len(self._rows)), self._rows.shape[1]))])
        self._rows[self.count : end, : self.layout.width] = rows
        self._rows[self.count : end, self.layout.width :] = running
        self.count = end

    def finish(self) -> None:
        """Keep the last row even when rows are thinned."""
        if self._last is not None and (self.steps - 1) % self.every != 0:
            self._store(self._last[None], self._running[None])

    def checkpoint(self) -> dict[str, Any]:
        """The rows and the running sums."""
        parts = {} if self._last is None else {"last": self._last, "origin": np.asarray(self._origin)}
        sums = np.array([self.reference_energy, self.largest_work])
        return parts | {
            "rows": self._rows[: self.count],
            "running": self._running,
            "sums": sums,
            "steps": self.steps,
            "every": self.every,
        }

    def restore(self, saved: dict[str, Any]) -> None:
        """Go on from there."""
        self._rows, self._running, self.steps = saved["rows"], saved["running"], saved["steps"]
        self.every = saved["every"]
        self.count = len(self._rows)
        self.reference_energy, self.largest_work = map(float, saved["sums"])
        self._last, self._origin = saved.get("last"), saved.get("origin")

    def columns(self) -> dict[str, np.ndarray]:
        """The public history: name -> array [rows] or [rows, 3]."""
        rows = self._rows[: self.count]
        result: dict[str, np.ndarray] = {}
        for name, place in self.layout.place.items():
            column = rows[:, place]
            result[name] = (column if self.layout.sizes[name] == 3 else column[:, 0]).copy()
        work = result.pop("load_work")
        result.pop("support_power")
        for name in ("jacobian_min", "viscous_power", "viscous_rate"):
            result.pop(name)
        integral = {name: rows[:, place] for name, place in self._place.items()}
        result["impulse"] = integral["contact_force"].copy()
        result["support_impulse"] = integral["support_force"].copy()
        origin = self._origin[PLACE["load_work"]][0] if self._origin is not None else 0.0
        result["external_work"] = work - origin + integral["support_power"][:, 0]
        result["friction_work"] = np.zeros(len(rows))
        if "obstacle_power" in integral:
            result["external_work"] = result["external_work"] + integral["obstacle_power"][:, 0]
        if "friction_before" in integral:
            result["friction_work"] = integral["friction_before"][:, 0].copy()
        result["energy"] = result["kinetic"] + result["elastic"] + result["contact"] - result["external_work"]
        result["energy"] = result["energy"] + result["friction_work"]
        if "damping_work" in self.extra:  # power rate v.Mv, force -rate M v
            result["damping_work"] = 2.0 * self.damping * integral["kinetic"][:, 0]
            result["damping_impulse"] = -self.damping * integral["momentum"]
            result["energy"] = result["energy"] + result["damping_work"]
        if "viscous_work" in self.extra:
            result["viscous_work"] = integral["viscous_power"][:, 0].copy()
            result["energy"] = result["energy"] + result["viscous_work"]
        scale = self.reference_energy
        with np.errstate(invalid="ignore"):  # a run that blew up
            change = np.abs(result["energy"] - result["energy"][0]) if len(rows) else np.zeros(0)
        result["energy_error"] = change / scale if scale > 0.0 else change
        return {name: result[name] for name in (*COLUMNS, *self.extra)}
