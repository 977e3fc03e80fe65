"""The rigid motion next to that of the nodes of a body, by which planning takes a start from the end of another run."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np

from .body import Body

TURNED = 0.1  # angle [rad] up to which a body counts as not turned


class RigidMotion(NamedTuple):
    """A rigid motion: displacement (x - middle) turn + shift [m], velocity (x - middle) whirl + mean [m/s].

    middle, shift, mean [3]; turn, whirl [3, 3].
    """

    middle: np.ndarray
    shift: np.ndarray
    mean: np.ndarray
    turn: np.ndarray
    whirl: np.ndarray

    def values(self, portions: Iterable[np.ndarray], count: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the displacement [count, 3] [m] and velocity [count, 3] [m/s] of nodes at places in portions."""
        result, first = np.empty((2, count, 3)), 0
        for places in portions:
            arms, rows = places - self.middle, slice(first, first + len(places))
            result[0, rows], result[1, rows] = arms @ self.turn + self.shift, arms @ self.whirl + self.mean
            first += len(places)
        return result[0], result[1]

    def given_to(self, body: Body) -> Body:
        """Return the body with this motion as its start, unchecked."""
        displacement, velocity = self.values(body.mesh.portions("nodes"), body.mesh.node_count)
        result = copy.copy(body)
        result.__dict__.update(displacement=displacement, initial_displacement=displacement, initial_velocity=velocity)
        return result


class EndBefore(NamedTuple):
    """What planning takes from the end of the run that a run goes on from.

    motions: of every body; removal: "normal" or "full" of every body there, None without massless contact.
    """

    motions: tuple[RigidMotion, ...]
    removal: tuple[str | None, ...]


def rigid_motion(
    portions: Callable[[], Iterable[np.ndarray]], displacement: np.ndarray, velocity: np.ndarray
) -> RigidMotion:
    """Return the rigid motion next to that of nodes with displacement [n, 3] [m] and velocity [n, 3] [m/s].

    portions: gives the places [m] of the nodes before it, some [k, 3] after the other, so that a mesh that makes them
    when they are read keeps none. The rotation minimises the sum of squared distances (Kabsch, Acta Cryst. A 32, 922,
    1976), and so does the angular velocity; a rotation up to `TURNED` is left out.
    """
    middle = sum(places.sum(axis=0) for places in portions()) / len(displacement)
    shift, mean = displacement.mean(axis=0), velocity.mean(axis=0)
    squares, moved, moving, first = np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3)), 0
    for places in portions():
        arms, rows = places - middle, slice(first, first + len(places))
        squares += arms.T @ arms
        moved += arms.T @ (arms + displacement[rows] - shift)
        moving += arms.T @ (velocity[rows] - mean)
        first += len(places)
    rotation = _nearest_rotation(moved)
    if np.arccos(np.clip(0.5 * (np.trace(rotation) - 1.0), -1.0, 1.0)) <= TURNED:
        rotation = np.eye(3)
    squares, moving = rotation.T @ squares @ rotation, rotation.T @ moving  # of arms that have turned
    momentum = np.array([moving[1, 2] - moving[2, 1], moving[2, 0] - moving[0, 2], moving[0, 1] - moving[1, 0]])
    spin = np.linalg.pinv(np.trace(squares) * np.eye(3) - squares) @ momentum
    return RigidMotion(middle, shift, mean, rotation - np.eye(3), rotation @ np.cross(np.eye(3), spin).T)


def _nearest_rotation(moments: np.ndarray) -> np.ndarray:
    """Return the rotation [3, 3] that takes arms (rows) nearest to where they moved; moments: sum of arm^T moved."""
    left, _, right = np.linalg.svd(moments)
    return np.asarray((left * [1.0, 1.0, np.sign(np.linalg.det(left @ right)) or 1.0]) @ right)
