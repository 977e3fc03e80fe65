"""Find what may meet in a scene that starts from the end of another run instead of from its own bodies' start.

Contact faces of bodies with contact="auto", and the pairs of pairs="auto", are those that may meet from where the
bodies are then and with the velocities that they have; faces that the run before had stay contact faces, as their nodes
are without mass. Each body counts with its rigid motion: as it is deformed, or vibrates, faces of its sides would look
at what they do not meet, and their nodes would lose their mass amid the motion. For the same reason a body that has
hardly turned counts as not turned.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterable, Sequence

import numpy as np

from .approach import Approach
from .body import Body
from .pairs import pairs_of
from .reach import with_reached_faces
from .scene import Scene

TURNED = 0.1  # angle [rad] up to which a body counts as not turned


def started_from(
    scene: Scene,
    displacement: Sequence[np.ndarray],
    velocity: Sequence[np.ndarray],
    known: Sequence[np.ndarray | None],
) -> Scene:
    """Return the scene with the contact faces and pairs of this start; the scene itself where all of them are given.

    displacement [m], velocity [m/s]: of the nodes [n, 3] of every body; known: faces [k, 4|3] of every body that stay
    contact faces, None where it was without "auto".
    """
    if not any(body.finds_contact for body in scene.bodies) and not isinstance(scene.pairs, str):
        return scene
    moved = _with_bodies(scene, [_started(*one) for one in zip(scene.bodies, displacement, velocity, strict=True)])
    obstacles = scene.obstacles if scene.contact is not None else ()
    faces, outer_approach = [], Approach(moved, outer=True)
    reached = moved.faces_of_others(outer_approach)
    for index, (body, before, others) in enumerate(zip(moved.bodies, known, reached, strict=True)):
        found = with_reached_faces(body, obstacles, scene.duration, scene.largest_gravity, others).contact_faces
        if body.finds_contact and before is not None:
            outer = body.outer_faces
            found = outer[holds(np.concatenate([found, before]), outer)]
        faces.append(found if len(found) else scene.bodies[index].contact_faces)
    moved = _with_bodies(scene, [_touching(*one) for one in zip(moved.bodies, faces, strict=True)])
    result = _with_bodies(scene, [_touching(*one) for one in zip(scene.bodies, faces, strict=True)])
    object.__setattr__(result, "body_pairs", pairs_of(result, Approach(moved, outer=False, before=outer_approach)))
    return result


def holds(faces: np.ndarray, asked: np.ndarray) -> np.ndarray:
    """Return whether rows asked [m, k] are among the rows of faces [n, k]."""
    _, number = np.unique(np.concatenate([faces, asked]), axis=0, return_inverse=True)
    number = number.reshape(-1)
    return np.isin(number[len(faces) :], number[: len(faces)])


def _with_bodies(scene: Scene, bodies: Sequence[Body]) -> Scene:
    """Return the scene with other bodies, unchecked."""
    result = copy.copy(scene)
    object.__setattr__(result, "bodies", tuple(bodies))
    return result


def _started(body: Body, displacement: np.ndarray, velocity: np.ndarray) -> Body:
    """Return the body with another start, of its rigid motion: displacement [n, 3] [m], velocity [n, 3] [m/s]."""
    displacement, velocity = rigid_motion(lambda: body.mesh.portions("nodes"), displacement, velocity)
    result = copy.copy(body)
    result.__dict__.update(displacement=displacement, initial_displacement=displacement, initial_velocity=velocity)
    return result


def _touching(body: Body, faces: np.ndarray) -> Body:
    """Return the body with these contact faces [k, 4|3], the body itself unless it has "auto"."""
    if not body.finds_contact:
        return body
    result = copy.copy(body)
    result.__dict__.pop("contact_nodes", None)
    result.__dict__["contact_faces"] = faces
    return result


def rigid_motion(
    portions: Callable[[], Iterable[np.ndarray]], displacement: np.ndarray, velocity: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the displacement [n, 3] [m] and velocity [n, 3] [m/s] of the rigid motion next to that of some nodes.

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
    turn, whirl = rotation - np.eye(3), rotation @ np.cross(np.eye(3), spin).T
    result, first = np.empty((2, len(displacement), 3)), 0
    for places in portions():
        arms, rows = places - middle, slice(first, first + len(places))
        result[0, rows], result[1, rows] = arms @ turn + shift, arms @ whirl + mean
        first += len(places)
    return result[0], result[1]


def _nearest_rotation(moments: np.ndarray) -> np.ndarray:
    """Return the rotation [3, 3] that takes arms (rows) nearest to where they moved; moments: sum of arm^T moved."""
    left, _, right = np.linalg.svd(moments)
    return np.asarray((left * [1.0, 1.0, np.sign(np.linalg.det(left @ right)) or 1.0]) @ right)
