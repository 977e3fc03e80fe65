"""Records of the obstacles for the kernels: their positions, for every step of a launch while they move."""

from __future__ import annotations

import numpy as np

from ..base.errors import FunctionError
from ..device import arrays
from ..scene.obstacles import Obstacle
from ..scene.obstacles.motion import Motion
from ..scene.scene import Scene


class Obstacles:
    """Records as in kernels/contact/obstacles.py, relative to `centre` [3] [m], a point among the contact nodes.

    rows_at_once: largest number of rows of a launch. `move` places moving obstacles before every launch.
    """

    def __init__(self, scene: Scene, centre: np.ndarray, rows_at_once: int) -> None:
        from ..kernels.contact import obstacles as names

        self.names = names
        self.obstacles = scene.obstacles
        self.centre = centre
        self.moving = scene.moving
        self.free = any(obstacle.free for obstacle in scene.obstacles)
        self.posed = any(obstacle.moves and not obstacle.free for obstacle in scene.obstacles)
        self.tracked = scene.tracked
        self.shapes = tuple(sorted({obstacle.shape for obstacle in scene.obstacles}))
        grids = [obstacle.grid for obstacle in scene.obstacles]
        ends = np.cumsum([0 if grid is None else grid.size for grid in grids])
        sampled = np.concatenate([np.zeros(0), *(grid.ravel() for grid in grids if grid is not None)])
        self._start = np.zeros((len(grids), names.RECORD))
        rows = (rows_at_once + 1) * self._start.size if self.posed else 0
        for record, obstacle, grid, end in zip(self._start, scene.obstacles, grids, ends, strict=True):
            record[names.SHAPE] = names.CODES[obstacle.shape]
            parameters = list(obstacle.parameters)
            if grid is not None:
                parameters.append(rows + end - grid.size)  # where its samples begin
            record[names.PARAMETERS : names.PARAMETERS + len(parameters)] = parameters
            record[names.POINT : names.FRAME] = self._point(obstacle) - centre
            record[names.FRAME : names.PARAMETERS] = obstacle.frame.ravel()
            if obstacle.free:  # the kernel moves it
                for place, rate in ((0, obstacle.velocity), (3, obstacle.angular_velocity)):
                    for first in (names.VELOCITY + place, names.MEAN_VELOCITY + place):
                        record[first : first + 3] = 0.0 if rate is None else rate
        self.records = arrays.put(self._start)
        self.motion = arrays.put(np.concatenate([np.zeros(rows), sampled]))
        self._motions: list | None = None
        self._answers: dict[float, np.ndarray] = {}  # records by time [s] of the rows that `ask` has prepared
        if self.posed:
            self._motions = [None if obstacle.free else Motion(obstacle) for obstacle in self.obstacles]
            arrays.set_values(self.records, self._poses(np.zeros(1)))

    def _point(self, obstacle: Obstacle) -> np.ndarray:
        """Return the reference point; of a plane at rest the point nearest to the centre, where gaps round least."""
        if obstacle.shape != "plane" or self.tracked:
            return np.asarray(obstacle.reference)
        normal = obstacle.frame[2]
        away = self.centre - obstacle.reference
        return np.asarray(self.centre - (away @ normal) * normal)

    def move(self, times: np.ndarray) -> None:
        """Place moving obstacles at the levels `times` [s], the present one first."""
        if self.posed:
            records = self._answers.pop(float(times[0]), None)
            arrays.set_values(self.motion, self._poses(times) if records is None else records)

    @property
    def asks(self) -> bool:
        """Return whether functions of time move some of them."""
        return self._motions is not None and any(motion and motion.varies for motion in self._motions)

    def ask(self, time: float, step: float, rows: int) -> int:
        """Evaluate functions of time for rows from `time` [s] on before a body moves; return how many succeed.

        Raises `FunctionError` if they fail within the first row.
        """
        if not self.asks:
            return rows
        self._answers = {}
        for number, start in enumerate(np.cumsum([time, *[step] * (rows - 1)]).tolist()):
            try:
                self._answers[start] = self._poses(start + step * np.arange(2))
            except FunctionError:
                if number == 0:
                    raise
                return number
        return rows

    def _poses(self, times: np.ndarray) -> np.ndarray:
        names = self.names
        rows = np.tile(self._start, (len(times), 1, 1))
        assert self._motions is not None
        steps = np.diff(times)[:, None]
        for number, motion in enumerate(self._motions):
            if motion is None:
                continue
            points, frames, velocities, spins = motion.poses(times)
            record = rows[:, number]
            record[:, names.POINT : names.FRAME] = points - self.centre
            record[:, names.FRAME : names.PARAMETERS] = frames.reshape(-1, 9)
            record[:, names.VELOCITY : names.SPIN] = velocities
            record[:, names.SPIN : names.MEAN_VELOCITY] = spins
            record[1:, names.MEAN_VELOCITY : names.MEAN_SPIN] = np.diff(points, axis=0) / steps
            record[1:, names.MEAN_SPIN :] = _rotation_between(frames) / steps
        return rows

    def owned(self) -> list[arrays.Array]:
        """Return the arrays of the obstacles."""
        return [self.records, self.motion]


def _rotation_between(frames: np.ndarray) -> np.ndarray:
    """Return the rotation vectors [m-1, 3] [rad] from each frame to the next one (rows are local axes), below pi."""
    turn = np.einsum("tik,til->tkl", frames[1:], frames[:-1])  # R = Q1^t Q0
    sine = 0.5 * np.stack(
        [turn[:, 2, 1] - turn[:, 1, 2], turn[:, 0, 2] - turn[:, 2, 0], turn[:, 1, 0] - turn[:, 0, 1]], axis=1
    )
    size = np.linalg.norm(sine, axis=1)
    angle = np.arctan2(size, 0.5 * (np.trace(turn, axis1=1, axis2=2) - 1.0))
    return np.asarray(sine * np.where(size > 1e-12, angle / np.where(size > 1e-12, size, 1.0), 1.0)[:, None])
