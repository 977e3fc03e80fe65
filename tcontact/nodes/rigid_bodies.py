"""Rigid bodies that move freely or carry nodes: their records for the kernels (kernels/nodes/rigid_body.py)."""

from __future__ import annotations

import numpy as np

from ..device import arrays
from ..kernels import rigid_places as at
from ..planning.rigid import RigidPlan
from ..scene.rigid import principal


class RigidBodies:
    """The records of the rigid bodies of a domain.

    centre [3] [m]: origin of the positions of the obstacles; place: first number of the group "rigid" in `sums`.
    """

    name = "rigid-bodies"

    def __init__(self, bodies: tuple[RigidPlan, ...], centre: np.ndarray, place: int) -> None:
        self.bodies = bodies
        values = np.zeros(at.HEAD + at.RECORD * len(bodies))
        values[[at.COUNT, at.SUMS_AT]] = len(bodies), place
        values[at.CENTRE : at.CENTRE + 3] = centre
        records = values[at.HEAD :].reshape(len(bodies), at.RECORD)
        for record, body in zip(records, bodies, strict=True):
            if body.kind != at.PRESCRIBED:
                record[:] = _record(body)
        self.values = arrays.put(values)
        self.ties = None

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
