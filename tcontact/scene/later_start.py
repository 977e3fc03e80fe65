"""Find what may meet in a scene that starts from the end of another run instead of from its own bodies' start.

Contact faces of bodies with contact="auto", and the pairs of pairs="auto", are those that may meet from where the
bodies are then and with the velocities that they have; faces that the run before had stay contact faces, as their nodes
are without mass. Each body counts with its rigid motion: as it is deformed, or vibrates, faces of its sides would look
at what they do not meet, and their nodes would lose their mass amid the motion. For the same reason a body that has
hardly turned counts as not turned.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence

import numpy as np

from .approach import Approach
from .body import Body
from .pairs import pairs_of
from .reach import with_reached_faces
from .rigid_motion import EndBefore, rigid_motion
from .scene import OF_PAIRS, Scene


def started_from(
    scene: Scene,
    displacement: Sequence[np.ndarray],
    velocity: Sequence[np.ndarray],
    known: Sequence[np.ndarray | None],
    removal: Sequence[str | None] | None,
) -> Scene:
    """Return the scene with this start, by which planning takes it, and with its contact faces and pairs.

    displacement [m], velocity [m/s]: of the nodes [n, 3] of every body; known: faces [k, 4|3] of every body that stay
    contact faces, None where it was without "auto"; removal: as in `EndBefore`; None: planning takes the start that the
    bodies name, as in checkpoints without it.
    """
    states = zip(scene.bodies, displacement, velocity, strict=True)
    motions = tuple(rigid_motion(lambda body=body: body.mesh.portions("nodes"), *two) for body, *two in states)  # type: ignore[misc]
    result = _with_bodies(scene, scene.bodies)
    if removal is not None:
        object.__setattr__(result, "end_before", EndBefore(motions, tuple(removal)))
    if not any(body.finds_contact for body in scene.bodies) and not isinstance(scene.pairs, str):
        return result
    moved = _with_bodies(scene, [motion.given_to(body) for motion, body in zip(motions, scene.bodies, strict=True)])
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
    result = _with_bodies(result, [_touching(*one) for one in zip(scene.bodies, faces, strict=True)])
    object.__setattr__(result, "body_pairs", pairs_of(result, Approach(moved, outer=False, before=outer_approach)))
    return result


def from_own_start(scene: Scene) -> Scene:
    """Return the scene without the start that `started_from` gave it, as it may be that of a result."""
    if scene.end_before is None:
        return scene
    result = copy.copy(scene)
    object.__setattr__(result, "end_before", None)
    return result


def holds(faces: np.ndarray, asked: np.ndarray) -> np.ndarray:
    """Return whether rows asked [m, k] are among the rows of faces [n, k]."""
    _, number = np.unique(np.concatenate([faces, asked]), axis=0, return_inverse=True)
    number = number.reshape(-1)
    return np.isin(number[len(faces) :], number[: len(faces)])


def _with_bodies(scene: Scene, bodies: Sequence[Body]) -> Scene:
    """Return the scene with other bodies, unchecked."""
    result = copy.copy(scene)
    for name in OF_PAIRS:
        result.__dict__.pop(name, None)
    object.__setattr__(result, "bodies", tuple(bodies))
    return result


def _touching(body: Body, faces: np.ndarray) -> Body:
    """Return the body with these contact faces [k, 4|3], the body itself unless it has "auto"."""
    if not body.finds_contact:
        return body
    result = copy.copy(body)
    result.__dict__.pop("contact_nodes", None)
    result.__dict__["contact_faces"] = faces
    return result
