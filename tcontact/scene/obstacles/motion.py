"""Compute the pose of an obstacle at time t: o(t) = o(0) + int v dt, R' = [w] R, axes in the world R e_i(0).

Constant rates in closed form (Rodrigues). Functions of time are integrated once per interval between the times asked
for: v by three Gauss points (order 6), w by the fourth-order Magnus series with two Gauss points,
R <- exp([h (w1 + w2)/2 + sqrt(3) h^2/12 w2 x w1]) R (Iserles, Munthe-Kaas, Norsett, Zanna 2000).
"""

from __future__ import annotations

from collections import deque
from typing import Any, NamedTuple

import numpy as np

from ..time_functions import TimeFunction
from .base import Obstacle

GAUSS_3, WEIGHTS_3 = np.polynomial.legendre.leggauss(3)
GAUSS_2 = np.polynomial.legendre.leggauss(2)[0]

KEPT = 4096  # latest places kept


class Place(NamedTuple):
    """Displacement [3] and rotation [3, 3] at a time."""

    time: float
    moved: np.ndarray
    turn: np.ndarray


class Motion:
    """The prescribed motion of an obstacle from t = 0.

    step: longest interval [s] over which a function of time is integrated at once, None for the interval between two
    requested times. A run requests times in order, so each function is integrated once; an earlier time starts from the
    last of the `KEPT` latest places before it, or from t = 0 with intervals as long as the longest one so far.
    """

    def __init__(self, obstacle: Obstacle, step: float | None = None) -> None:
        self.obstacle, self.step = obstacle, step
        self.velocity = Rate(obstacle, "velocity")
        self.spin = Rate(obstacle, "angular_velocity")
        self._longest = 0.0
        self._places: deque[Place] = deque(maxlen=KEPT)

    def poses(self, times: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return the poses of the obstacle at times [m] [s].

        Reference points [m, 3] [m], frames [m, 3, 3] (local axes in rows), velocities of these points [m, 3] [m/s] and
        spins [m, 3] [rad/s].

        Raises `FunctionError` naming the obstacle and the time where a function does not return three finite numbers.
        """
        times = np.atleast_1d(np.asarray(times, dtype=np.float64))
        velocities, spins = self.velocity.at(times), self.spin.at(times)
        if self.varies:
            moved, turns = (np.array(part) for part in zip(*map(self._advance, times), strict=True))
        if not self.velocity.varies:
            moved = times[:, None] * velocities
        if not self.spin.varies:
            turns = rotations(times[:, None] * spins)
        frames = self.obstacle.frame @ np.swapaxes(turns, 1, 2)
        return self.obstacle.reference + moved, frames, velocities, spins

    @property
    def varies(self) -> bool:
        """Return whether the motion is a function of time."""
        return self.velocity.varies or self.spin.varies

    def checkpoint(self) -> dict[str, np.ndarray]:
        """Return the latest places, the longest interval and the recorded values of the functions."""
        rows = [np.concatenate([[place.time], place.moved, place.turn.ravel()]) for place in self._places]
        found = {"places": np.array(rows).reshape(-1, 13), "longest": np.array([self._longest])}
        for part, rate in (("velocity", self.velocity), ("spin", self.spin)):
            found |= {f"{part}.{name}": array for name, array in rate.record.checkpoint().items()}
        return found

    def restore(self, saved: dict[str, np.ndarray]) -> None:
        """Set the state that `checkpoint` returned. Raises `InputError` if a function differs from that of the run."""
        self._longest = float(saved["longest"][0])
        for part, rate in (("velocity", self.velocity), ("spin", self.spin)):
            rate.restore({name: saved[f"{part}.{name}"] for name in ("calls", "counters")})
        rows = [Place(float(row[0]), row[1:4].copy(), row[4:].reshape(3, 3).copy()) for row in saved["places"]]
        self._places = deque(rows, maxlen=KEPT)

    def _advance(self, time: float) -> tuple[np.ndarray, np.ndarray]:
        """Return displacement [3] and rotation [3, 3] at a time, integrated from the last place before it."""
        back = bool(self._places)
        while self._places and self._places[-1].time > time:
            self._places.pop()
        anew = back and not self._places
        place = self._places[-1] if self._places else Place(0.0, np.zeros(3), np.eye(3))
        if time != place.time:
            length = time - place.time
            longest = self.step or (self._longest if anew else abs(length)) or abs(length)
            for end in np.linspace(place.time, time, max(1, int(np.ceil(abs(length) / longest - 1e-9))) + 1)[1:]:
                place = self._over(place, float(end))
                self._longest = max(self._longest, min(longest, abs(length)))
        if not self._places or place.time > self._places[-1].time:
            self._places.append(place)
        return place.moved, place.turn

    def _over(self, place: Place, end: float) -> Place:
        """Return the place at the end of an interval."""
        start, moved, turn = place
        length = end - start
        if self.velocity.varies:
            rates = self.velocity.at(start + 0.5 * length * (1.0 + GAUSS_3))
            moved = moved + 0.5 * length * (WEIGHTS_3 @ rates)
        if self.spin.varies:
            first, second = self.spin.at(start + 0.5 * length * (1.0 + GAUSS_2))
            vector = 0.5 * length * (first + second) + np.sqrt(3.0) / 12.0 * length**2 * np.cross(second, first)
            turn = rotations(vector[None])[0] @ turn
        return Place(end, moved, turn)


class Rate(TimeFunction):
    """The velocity or the spin of an obstacle: a constant, or a function of time."""

    def __init__(self, obstacle: Obstacle, field: str) -> None:
        kind = type(obstacle).__name__
        name = f"{kind}.{field}" if obstacle.name is None else f"{kind}.{field} of {obstacle.name!r}"
        super().__init__(name, getattr(obstacle, field), 3)


def rotations(vectors: np.ndarray) -> np.ndarray:
    """Return rotation matrices [m, 3, 3] of rotation vectors [m, 3] [rad]: exp of cross products (Rodrigues)."""
    angle = np.linalg.norm(vectors, axis=1)[:, None, None]
    cross = np.zeros((len(vectors), 3, 3))
    cross[:, [2, 0, 1], [1, 2, 0]] = vectors
    cross[:, [1, 2, 0], [2, 0, 1]] = -vectors
    # sin a / a and (1 - cos a) / a^2, both without loss at small angles
    return np.eye(3) + np.sinc(angle / np.pi) * cross + 0.5 * np.sinc(0.5 * angle / np.pi) ** 2 * (cross @ cross)
