"""Displacement, velocity and acceleration of nodes at the rows of the history, for probes.

    v^n = v^- + (v^+ - v^-) h^-/(h^- + h^+),   a^n = (v^+ - v^-)/((h^- + h^+)/2)

with the steps h^- and h^+ that end and start at level n and the velocities v^- and v^+ in them, which components with
mass have; those without have the differences of displacements (u^n - u^{n-1})/h^-, (u^{n+1} - u^n)/h^+. Of a constant
step it is v^n = (v^- + v^+)/2, a^n = (v^+ - v^-)/h. At the start v^- is the start velocity and h^- = 0. At the end,
where no step follows, components without mass keep their last acceleration.
"""

from __future__ import annotations

from typing import Any

import numpy as np


class Motion:
    """The motion of some nodes; massless [k, 3, 3]: projectors on their components without mass, None: all have mass.

    velocity [k, 3] [m/s]: at the start.
    """

    def __init__(self, massless: np.ndarray | None, velocity: np.ndarray) -> None:
        self._massless = massless if massless is not None and massless.any() else None
        self._start = velocity
        self._last = np.zeros_like(velocity)  # displacement, or velocity of an implicit scheme, of the last row
        self._late = np.zeros_like(velocity)  # acceleration of the last row without mass

    def explicit(self, u: np.ndarray, v: np.ndarray, before: float, after: float) -> dict[str, np.ndarray]:
        """Return the quantities [m, k, 3] of m rows from u, v [m + 1, k, 3] at their starts and after the last one.

        v: of components with mass; before, after [s]: the steps that end and start at row 0; further rows have `after`
        on both sides.
        """
        count = len(u) - 1
        ends = np.full(count, after)
        ends[0] = before
        first, second = v[:-1].copy(), v[1:].copy()
        total = (ends + after)[:, None, None]
        massless = None
        if self._massless is not None:
            steps = np.diff(np.concatenate([self._last[None], u]), axis=0)
            rates = steps / np.where(np.append(ends, after) > 0.0, np.append(ends, after), np.inf)[:, None, None]
            if before == 0.0:
                rates[0] = self._start
            if after == 0.0:
                rates[-1] = rates[-2]
            rates = np.einsum("kij,mkj->mki", self._massless, rates)
            first += rates[:-1]
            second += rates[1:]
            massless = 2.0 * np.diff(rates, axis=0)
        change = second - first
        share = (ends / np.where(total[:, 0, 0] > 0.0, total[:, 0, 0], 1.0))[:, None, None]
        scale = np.where(total > 0.0, total, np.inf)
        acceleration = 2.0 * change / scale
        if massless is not None:
            if after == 0.0:
                acceleration[-1] += self._late
            else:
                self._late = massless[-1] / scale[-1]
            self._last = u[count - 1].copy()
        return {"displacement": u[:-1], "velocity": first + share * change, "acceleration": acceleration}

    def implicit(self, u: np.ndarray, velocity: np.ndarray, before: float) -> dict[str, np.ndarray]:
        """Return the quantities [1, k, 3] of a level; before [s]: the step that ended there, 0 at the start.

        The acceleration is the change of the velocity in that step, as the forces of the row are those of that step.
        """
        acceleration = (velocity - self._last) / before if before > 0.0 else np.zeros_like(velocity)
        self._last = velocity[0].copy()
        return {"displacement": u, "velocity": velocity, "acceleration": acceleration}

    def kept(self) -> dict[str, Any]:
        """Return what it keeps from row to row."""
        return {"last": self._last, "late": self._late}

    def put(self, saved: dict[str, Any]) -> None:
        """Set what `kept` returned."""
        self._last, self._late = np.array(saved["last"]), np.array(saved["late"])
