"""Bound the way that the surfaces of two bodies can come closer to each other in the rows to come.

At rest they need not stay so: what moves in the scene may strike them, and what drives it may begin. So any two bodies
may come together as fast as the fastest of the scene have moved against each other, or against an obstacle, in any row
looked at so far, and an obstacle moves in those to come; twice that, since a heavy body gives a light one up to twice
its speed. Drives (`drives.py`) add to that, up to a share of the wave speeds of both, which is a shock. Within k rows
they come closer by

    way(k) = (s + d) k + a k^2 / 2  or  (s + q) k, the smaller one,

with s of the motion, d and a of the drives, q the limit of these, all per row.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..watched import Run
from .drives import UNBOUNDED, Drives

AHEAD = 2.0  # speed until the next look over the largest one so far
QUICK = 0.1  # share of the wave speed that drives give a body at most: faster is a shock
FARTHER = 2.0  # largest growth of the rows from look to look: a start that accelerates is followed

Positions = Sequence[np.ndarray]
Numbers = np.ndarray | int


class Pace:
    """The fastest motion of a run, and the rows until two bodies can meet.

    rows: the most between two looks; fastest: largest speed [m/s] of two bodies, or of a body and an obstacle, against
    each other in the rows so far.
    """

    def __init__(self, run: Run, rows: int) -> None:
        scene = run.scene
        self._drives = Drives(run, rows, scene.touching)
        self._waves = np.array([body.wave_speed for body in scene.bodies])
        self._obstacles = [one for one in scene.obstacles if scene.touching]
        self._free = [one for one in self._obstacles if one.free]
        carriers = [one for one in run.states if one.plan.contact is not None and len(one.plan.contact.nodes)]
        self._carrier = carriers[0] if self._free and carriers else None
        self._poses = self._present_poses()
        self._step, self.fastest = 0.0, 0.0

    def follow(self, before: Positions, now: Positions, start: float, end: float, step: float) -> None:
        """Follow the bodies from one look to the next.

        before, now: positions [k, 3] [m] of their surfaces at the times start and end [s]; step [s]: the one to come.
        """
        self._step = step
        means, spreads = motions(before, now)
        own = np.linalg.norm(means[:, None] - means, axis=2) + spreads + spreads[:, None]
        way = float(own[~np.eye(len(means), dtype=bool)].max(initial=0.0))
        arm = 0.0
        if self._obstacles:
            arms = [np.linalg.norm(there - one.reference, axis=1).max() for one in self._obstacles for there in now]
            arm = float(max(arms))
            poses = self._present_poses()
            turns = [
                float(np.linalg.norm(point - old) + np.linalg.norm(frame - turned) * arm)
                for (point, frame), (old, turned) in zip(poses, self._poses, strict=True)
            ]
            self._poses = poses
            way = max(way, float((np.linalg.norm(means, axis=1) + spreads).max()) + max(turns, default=0.0))
        if end > start:
            self.fastest = max(self.fastest, way / (end - start))
        self._drives.ask(end, self._step, arm)

    def _present_poses(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """Return centre and axes of the obstacles that move freely."""
        poses = [] if self._carrier is None else [self._carrier.pose(one) for one in self._free]
        return [(np.array(point), np.array(frame)) for point, frame in poses]

    def way(self, first: Numbers, second: Numbers, rows: float) -> np.ndarray:
        """Return how far [m] bodies of these numbers can come together in so many rows."""
        moved, driven, acceleration, limit = self._parts(first, second)
        return np.asarray(rows * (moved + np.minimum(driven + 0.5 * acceleration * rows, limit)))

    def rows(self, distance: np.ndarray, first: Numbers, second: Numbers) -> np.ndarray:
        """Return the rows in which bodies of these numbers can come together by a distance > 0 [m]."""
        return rows_until(distance, *self._parts(first, second))

    def _parts(self, first: Numbers, second: Numbers) -> tuple[float, float, float, np.ndarray]:
        """Return the ways s, d, a, q of the formula above [m]."""
        step, drives = self._step, self._drives
        limit = QUICK * (self._waves[first] + self._waves[second]) * step
        moved = AHEAD * (self.fastest + drives.obstacle) * step
        return moved, AHEAD * drives.fastest * step, AHEAD * drives.strongest * step**2, limit


class NodePace:
    """The fastest motion of the contact nodes of a run against its obstacles, and the rows until they can meet.

    rows: the most between two looks; fastest: largest speed [m/s] in the rows so far.
    """

    def __init__(self, run: Run, rows: int) -> None:
        self._drives = Drives(run, rows, obstacles=False)
        self._wave = max(body.wave_speed for body in run.scene.bodies)
        self._starts = self._drives.some or any(body.displacement is not None for body in run.scene.bodies)
        self._before, self.fastest = 0.0, 0.0

    def follow(self, travel: float, time: float, step: float) -> None:
        """Follow the nodes to a look at a time [s]; travel [m]: their largest motion since the last one; step [s]."""
        if time > self._before:
            self.fastest = max(self.fastest, travel / (time - self._before))
        self._before = time
        self._drives.ask(time, step)

    def most(self, rows: int, rarely: int) -> float:
        """Return the most rows until the next look, after so many: what may accelerate is followed from look to look.

        rarely: the most where nothing drives the bodies, none starts deformed and something moves already.
        """
        return min(rarely, FARTHER * rows) if self._starts or self.fastest == 0.0 else rarely

    def rows(self, distance: float, step: float, obstacle: float) -> float:
        """Return the rows in which a node can move by a distance > 0 [m]; obstacle [m/s]: its speed to come."""
        drives, moved = self._drives, (AHEAD * self.fastest + min(obstacle, UNBOUNDED)) * step
        driven, acceleration = AHEAD * drives.fastest * step, AHEAD * drives.strongest * step**2
        return float(rows_until(np.array(distance), moved, driven, acceleration, 2.0 * QUICK * self._wave * step))


def rows_until(
    distance: np.ndarray, moved: float, driven: float, acceleration: float, limit: np.ndarray | float
) -> np.ndarray:
    """Return the rows in which a way(k) is a distance > 0 [m], see above; then s, d, a, q [m]."""
    speed = moved + driven
    with np.errstate(divide="ignore"):
        by_drives = 2.0 * distance / (speed + np.sqrt(speed**2 + 2.0 * acceleration * distance))
        return np.asarray(np.maximum(by_drives, distance / (moved + limit)))


def motions(before: Positions, now: Positions) -> tuple[np.ndarray, np.ndarray]:
    """Return the mean motion [b, 3] and the largest difference from it [b] [m] of bodies with positions [k, 3]."""
    moves = [there - start for start, there in zip(before, now, strict=True)]
    means = np.array([move.mean(axis=0) for move in moves])
    spreads = [np.linalg.norm(move - mean, axis=1).max() for move, mean in zip(moves, means, strict=True)]
    return means, np.array(spreads)
