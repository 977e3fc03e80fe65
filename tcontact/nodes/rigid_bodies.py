"""Rigid bodies that move freely or carry nodes: their records for the kernels (kernels/nodes/rigid_body.py)."""

from __future__ import annotations

import numpy as np

from ..base.errors import FunctionError
from ..device import arrays
from ..kernels import rigid_places as at
from ..kernels.lanes import MAXIMUM_ROWS
from ..planning.rigid import RigidPlan
from ..scene.rigid import principal


class RigidBodies:
    """The records of the rigid bodies of a domain.

    centre [3] [m]: origin of the positions of the obstacles; place: first number of the group "rigid" in `sums`;
    rows: largest number of rows of a launch. `prepare` gives driven parts their poses before every launch.
    """

    name = "rigid-bodies"

    def __init__(self, bodies: tuple[RigidPlan, ...], centre: np.ndarray, place: int, rows: int) -> None:
        self.bodies = bodies
        self.motions = [body.motion for body in bodies]
        arms_at = at.HEAD + at.RECORD * len(bodies)
        poses_at = arms_at + sum(np.size(body.arms) for body in bodies)
        poses = (rows + 1) * len(bodies) * at.POSE if self.driven else 0
        values = np.zeros(poses_at + poses)
        values[[at.COUNT, at.SUMS_AT, at.ARMS_AT, at.POSES_AT]] = len(bodies), place, arms_at, poses_at
        values[at.CENTRE : at.CENTRE + 3] = centre
        for body, first in zip(bodies, _starts(bodies), strict=False):
            values[arms_at + 3 * first : arms_at + 3 * first + np.size(body.arms)] = np.ravel(body.arms)
        records = values[at.HEAD : arms_at].reshape(len(bodies), at.RECORD)
        for record, body in zip(records, bodies, strict=True):
            if body.kind != at.PRESCRIBED:
                record[:] = _record(body)
        self.values = arrays.put(values)
        self.ties = None
        if any(body.part is not None for body in bodies):
            starts = _starts(bodies)
            nodes = [np.asarray(body.nodes, dtype=np.int64) for body in bodies]
            self.ties = arrays.put(np.concatenate([starts, *nodes]).astype(np.int32))

    @property
    def driven(self) -> bool:
        """Return whether some of them are driven."""
        return any(motion is not None for motion in self.motions)

    def start_velocity(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the boundary nodes [t] that they carry, and the velocity [t, 3] of these at the start."""
        tied = [body for body in self.bodies if len(body.nodes)]
        parts = [body.velocity + np.cross(body.angular_velocity, body.arms) for body in tied]
        return np.concatenate([body.nodes for body in tied]), np.concatenate(parts)

    def rows_at_once(self, small: bool) -> int:
        """Return the largest number of rows of a launch, see `schemes.explicit.timed.Timed`."""
        return MAXIMUM_ROWS if small or not self.driven else 1

    def prepare(self, time: float, before: float, after: float, rows: int) -> None:
        """Write the poses of driven parts for the levels from `time` on, see `Timed`. Raises `FunctionError`.

        After the last row the motion goes on for one more step of the same length; if the function fails there, with
        the velocity of the step before.
        """
        step = after or before
        try:
            poses = self._poses(np.cumsum([time, *[step] * rows]))
        except FunctionError:
            if after > 0.0:
                raise
            poses = np.zeros((rows + 1, len(self.bodies), at.POSE))
        arrays.set_values(self.values, poses, self._poses_at)

    def _poses(self, times: np.ndarray) -> np.ndarray:
        """Return displacement and quaternion [m, bodies, POSE] of the centres of mass at the times [m] [s]."""
        result = np.zeros((len(times), len(self.bodies), at.POSE))
        for number, (body, motion) in enumerate(zip(self.bodies, self.motions, strict=True)):
            if motion is not None:
                points, frames, _velocities, _spins = motion.poses(times)  # frames: R^t
                arm = body.center - motion.obstacle.reference
                result[:, number, :3] = points + arm @ frames - body.center
                result[:, number, 3:] = [quaternion(frame.T) for frame in frames]
        return result

    @property
    def _poses_at(self) -> int:
        return int(arrays.get(self.values)[at.POSES_AT])

    @property
    def records(self) -> np.ndarray:
        """The present records [bodies, RECORD]; read only."""
        end = at.HEAD + at.RECORD * len(self.bodies)
        return arrays.get(self.values)[at.HEAD : end].reshape(len(self.bodies), at.RECORD)

    def pose(self, number: int) -> tuple[np.ndarray, np.ndarray]:
        """Return centre [3] [m] and axes (rows) [3, 3] of free obstacle `number`, after a step those at its end."""
        record = self.records[number]
        centre = record[at.START : at.START + 3] + record[at.MOVED : at.MOVED + 3]
        frame = record[at.FRAME : at.FRAME + 9].reshape(3, 3)
        return centre, np.asarray(frame @ rotation_matrix(record[at.TURN : at.TURN + 4]).T)

    def set_reach(self, seconds: float, first_step: float) -> None:
        """Set the time [s] within which nodes count before they touch, and the length [s] of the first step."""
        arrays.set_values(self.values, np.array([seconds, first_step]), at.REACH)

    def set_limit(self, rate: float) -> None:
        """Set the rate [1/s^2] above which a launch of several rows ends."""
        arrays.set_values(self.values, np.array([rate]), at.LIMIT)

    def arguments(self) -> dict[str, arrays.Array]:
        """Return the arrays by the names of kernels/language/bundles.Rigid."""
        return {"values": self.values} | ({} if self.ties is None else {"ties": self.ties})

    def owned(self) -> list[arrays.Array]:
        """Return the arrays of this term."""
        return list(self.arguments().values())


def _record(body: RigidPlan) -> np.ndarray:
    """Return the record of a rigid body at the start."""
    moments, axes = principal(body.inertia)
    record = np.zeros(at.RECORD)
    record[[at.KIND, at.MASS, at.INVERSE_MASS, at.TURN]] = body.kind, body.mass, 1.0 / body.mass, 1.0
    parts = {
        at.MOMENTS: moments,
        at.INVERSE_MOMENTS: 1.0 / moments,
        at.START: body.center,
        at.AXES: axes,
        at.FRAME: np.eye(3) if body.frame is None else body.frame,
        at.VELOCITY: body.velocity,
        at.SPIN: axes.T @ (moments * (axes @ body.angular_velocity)),
        at.MEAN_SPIN: body.angular_velocity,
    }
    for place, numbers in parts.items():
        record[place : place + np.size(numbers)] = np.ravel(numbers)
    return record


def rotation_matrix(turn: np.ndarray) -> np.ndarray:
    """Return the rotation matrix [3, 3] of a unit quaternion [4]."""
    w, own = turn[0], turn[1:]
    cross = np.array([[0.0, -own[2], own[1]], [own[2], 0.0, -own[0]], [-own[1], own[0], 0.0]])
    return np.asarray(np.eye(3) + 2.0 * (w * cross + cross @ cross))


def quaternion(rotation: np.ndarray) -> np.ndarray:
    """Return the unit quaternion [4] of a rotation matrix [3, 3]: the eigenvector of the largest eigenvalue.

    (Bar-Itzhack, J. Guid. Control Dyn. 23, 1085, 2000.)
    """
    skew = np.array([rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0], rotation[1, 0] - rotation[0, 1]])
    matrix = np.zeros((4, 4))
    matrix[0, 0] = np.trace(rotation)
    matrix[0, 1:] = matrix[1:, 0] = skew
    matrix[1:, 1:] = rotation + rotation.T - np.trace(rotation) * np.eye(3)
    return np.asarray(np.linalg.eigh(matrix)[1][:, -1])


def _starts(bodies: tuple[RigidPlan, ...]) -> np.ndarray:
    """Return where the tied nodes of every body start, and where the last ones end [bodies + 1]."""
    return np.cumsum([0, *(len(body.nodes) for body in bodies)])
