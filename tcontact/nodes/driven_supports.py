"""Supports that functions of time drive: the table of their motion for the levels of a launch (METHOD 1)."""

from __future__ import annotations

import numpy as np

from ..base.errors import FunctionError
from ..device import arrays
from ..kernels.lanes import DRIVEN_AXIS
from ..planning.domain import Domain
from ..scene.obstacles.motion import GAUSS_3, WEIGHTS_3
from .boundary_nodes import Supports


class DrivenSupports:
    """The motion of all axes that functions of time drive, a `Timed` term.

    D is the displacement itself, or the integral of the velocity by three Gauss points for each step. A row of
    `_levels` holds time, D [axes] and the mean velocity [axes] over the step that ended there, from the level before
    the present one on.
    """

    def __init__(self, domain: Domain, supports: Supports) -> None:
        self.supports = supports
        self.functions = [support.function() for support in domain.driven]
        self.integrated = [support.kind == "velocity" for support in domain.driven]
        self.axes = sum(function.size for function in self.functions)
        self._first = 2 * len(domain.speeds)
        self._levels = np.zeros((0, 1 + 2 * self.axes))

    def rows_at_once(self, small: bool) -> int:
        """Return the rows of its table if a launch or a block of them takes many, else 1."""
        return self.supports.rows if small else 1

    def begin(self, dt: float) -> None:
        """Find the motion at t = 0; dt [s]: the first step.

        The rate of a displacement there is that of the parabola through its values at 0, dt and 2 dt.
        """
        values = [np.zeros(1), np.zeros(self.axes), np.zeros(self.axes)]
        first = 0
        for function, integrated in zip(self.functions, self.integrated, strict=True):
            here = slice(first, first + function.size)
            first = here.stop
            if integrated:
                values[2][here] = function.at(np.zeros(1))[0]
                continue
            values[1][here] = function.at(np.zeros(1))[0]
            try:
                one, two = function.at(dt * np.arange(1, 3))
                values[2][here] = (4.0 * one - 3.0 * values[1][here] - two) / (2.0 * dt)
            except FunctionError:  # the run stops in its first steps
                pass
        self._levels = np.concatenate(values)[None]

    @property
    def start_speeds(self) -> np.ndarray:
        """Velocities [axes] [m/s] at t = 0, after `begin`."""
        return self._levels[0, 1 + self.axes :]

    def prepare(self, time: float, before: float, after: float, rows: int) -> None:
        """Write the table for the levels from `time` on, see `Timed`. Raises `FunctionError`.

        After the last row the motion goes on for one more step of the same length; if the function fails there, with
        the acceleration of the step before.
        """
        from ..kernels.nodes.driven_supports import ACCELERATION, NEXT_DISPLACEMENT, NEXT_SPEED, SPEED

        step = after or before
        here = int(np.flatnonzero(self._levels[:, 0] == time)[-1])
        self._levels = self._levels[max(0, here - 1) : here + 1]
        past = self._levels[:-1]
        speed = self._levels[-1, 1 + self.axes :]
        try:
            for end in np.cumsum([time, *[step] * rows])[1:] if step > 0.0 else ():
                self._levels = np.concatenate([self._levels, self._next(self._levels[-1], float(end))[None]])
        except FunctionError:
            if after > 0.0:
                raise
        levels = self._levels[len(past) :]
        halves = levels[1:, 1 + self.axes :]
        if len(levels) == 1:  # no step follows, and the function gives none
            halves = (2.0 * speed - past[0, 1 + self.axes :] if len(past) else speed)[None]
            levels = np.repeat(levels, 2, axis=0)
        speeds = np.concatenate([speed[None], halves])
        spans = 0.5 * np.array([before, *[after] * (rows - 1)])[:, None], 0.5 * (after or before)
        table = np.zeros((rows, self.axes, DRIVEN_AXIS))
        total = spans[0] + spans[1]
        acceleration = np.diff(speeds, axis=0) / np.where(total > 0.0, total, 1.0)
        table[:, :, ACCELERATION] = acceleration
        table[:, :, SPEED] = speeds[:-1] + spans[0] * acceleration
        table[:, :, NEXT_SPEED], table[:, :, NEXT_DISPLACEMENT] = halves, levels[1:, 1 : 1 + self.axes]
        arrays.set_values(self.supports.speeds, table, self._first)

    def _next(self, level: np.ndarray, end: float) -> np.ndarray:
        """Return the row of the level at `end` [s] behind another one."""
        result, start = level.copy(), level[0]
        result[0], length, first = end, end - start, 1
        for function, integrated in zip(self.functions, self.integrated, strict=True):
            place = slice(first, first + function.size)
            rate = slice(place.start + self.axes, place.stop + self.axes)
            first = place.stop
            if integrated:
                result[rate] = 0.5 * WEIGHTS_3 @ function.at(start + 0.5 * length * (1.0 + GAUSS_3))
                result[place] = level[place] + length * result[rate]
            else:
                result[place] = function.at(np.array([end]))[0]
                result[rate] = (result[place] - level[place]) / length
        return result

    def checkpoint(self) -> dict[str, np.ndarray]:
        """Return the levels and the recorded values of the functions."""
        calls = [function.checkpoint() for function in self.functions]
        found = {f"{number}.{name}": part for number, one in enumerate(calls) for name, part in one.items()}
        return found | {"levels": self._levels}

    def restore(self, saved: dict[str, np.ndarray]) -> None:
        """Set the state that `checkpoint` returned. Raises `InputError` if a function differs from that of the run."""
        self._levels = saved["levels"]
        for number, function in enumerate(self.functions):
            own = f"{number}."
            function.restore({name[len(own) :]: part for name, part in saved.items() if name.startswith(own)})
