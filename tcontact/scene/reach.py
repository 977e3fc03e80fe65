"""Find the faces of a body that may meet an obstacle, `Body(contact="auto")`, and the obstacles within reach.

A face may meet an obstacle that it faces (its outward normal within 90 degrees of minus the obstacle's) and that is
close enough at t = 0:

    distance <= 1.5 (|v| + |g| T + l + w) T + |u| + shortest edge,

|v| the body's largest initial speed, with that of supports that functions of time drive and of springs that let go, T
the duration, g gravity, l the speed that the loads of the body can give it, w the largest speed of the obstacle's
points near the body, |u| the largest initial displacement. Faces that turn towards an obstacle later are not found:
name their set.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence

import numpy as np

from ..base.errors import FunctionError
from ..mesh.geometry import chunks_of
from .body import Body
from .obstacles import Obstacle
from .obstacles.motion import Rate

SLACK = 1.5  # factor on the distance, for waves that add to the speed of the body
FACING = -1e-6  # cosine below which a face does not face the obstacle
SAMPLES = 257  # samples of a function of time
FEWER = 32  # one in so many of them for an own force, which may be slow
AT_ONCE = 1 << 14  # nodes in a portion
OUT_OF_REACH = 10.0  # times the distance that a node can cover


def with_reached_faces(
    body: Body, obstacles: Sequence[Obstacle], duration: float, gravity: float, others: np.ndarray | None = None
) -> Body:
    """Return the body with the faces that may meet an obstacle as contact faces; the body itself unless "auto".

    gravity [m/s^2]: its largest size; others [k]: for each outer face whether it may meet another body; None: it may
    not.
    """
    if not body.finds_contact:
        return body
    faces = body.outer_faces
    reached = np.zeros(len(faces), dtype=bool) if others is None else others.copy()
    if len(faces):
        for obstacle in obstacles:
            reached |= _meets(body, faces, obstacle, duration, gravity)
    reached &= ~body.tied[faces].any(axis=1)
    result = copy.copy(body)
    result.__dict__.pop("contact_nodes", None)
    result.__dict__["contact_faces"] = faces[reached]
    return result


def _meets(body: Body, faces: np.ndarray, obstacle: Obstacle, duration: float, gravity: float) -> np.ndarray:
    corners = body.initial_at(faces)
    centre = corners.mean(axis=1)
    radius = np.linalg.norm(corners - centre[:, None], axis=2).max(axis=1)
    across = np.cross(corners[:, 2] - corners[:, 0], corners[:, -1] - corners[:, 1])
    outward = across / np.linalg.norm(across, axis=1).clip(1e-300)[:, None]
    facing = np.einsum("ni,ni->n", outward, obstacle.normal_at(centre)) < FACING
    speed = _longest(body.initial_velocity) + body.driven_speed(duration)
    fall = gravity * duration + speed_by_loads(body, duration)
    positions = body.initial_nodes if obstacle.moves else np.zeros((0, 3))
    way = SLACK * (speed + fall + _speed(obstacle, positions, duration)) * duration
    shift = _longest(body.initial_displacement)
    close = obstacle.gap(centre) - radius <= way + shift + body.mesh.shortest_edge
    return np.asarray(facing & close)


def _longest(vectors: np.ndarray, origin: np.ndarray | float = 0.0) -> float:
    """Return the largest distance of vectors [n, 3] from an origin [3], of which all may be one (a stride of 0)."""
    vectors = vectors[:1] if vectors.strides[0] == 0 else vectors
    parts = chunks_of(len(vectors), AT_ONCE)
    return max(float(np.linalg.norm(vectors[part] - origin, axis=1).max()) for part in parts)


def _speed(obstacle: Obstacle, positions: np.ndarray, duration: float) -> float:
    """Return the largest speed [m/s] of the obstacle's motion at the distance of the farthest position."""
    if not obstacle.moves:
        return 0.0
    times = np.linspace(0.0, float(duration), SAMPLES)
    moving = float(np.linalg.norm(Rate(obstacle, "velocity").at(times), axis=1).max())
    turning = float(np.linalg.norm(Rate(obstacle, "angular_velocity").at(times), axis=1).max())
    return moving + turning * float(np.linalg.norm(positions - obstacle.reference, axis=1).max())


def speed_by_loads(body: Body, duration: float) -> float:
    """Return the speed [m/s] that the loads of a body can give it, infinite for a function that fails.

    That is force over mass times duration, and behind a loaded face p/(density wave speed). An own force counts as it
    is on the nodes at the start.
    """
    speed, times = 0.0, np.linspace(0.0, float(duration), SAMPLES)
    stiffness = min(material.density * material.wave_speed for material in body.materials)
    for load in body.loads:
        try:
            if load.own:
                nodes = load.nodes(body.mesh)
                start = body.mesh.nodes[nodes], body.initial_velocity[nodes]
                values = np.array([load.own_force(*start, float(time)).sum(axis=0) for time in times[::FEWER]])
            else:
                values = load.function(body.mesh).at(times if load.varies else times[:1])
        except FunctionError:  # the run stops where it fails
            return float(np.inf)
        size = float(np.linalg.norm(values.reshape(-1, 1 if load.kind == "pressure" else 3), axis=1).max())
        if load.kind != "force":
            speed += size / stiffness
            x = body.mesh.nodes[load.faces(body.mesh)]
            size *= 0.5 * float(np.linalg.norm(np.cross(x[:, 2] - x[:, 0], x[:, 3] - x[:, 1]), axis=1).sum())
        speed += size / body.mass * duration
    return speed


def within_reach(body: Body, obstacles: Sequence[Obstacle], duration: float, gravity: float) -> list[int]:
    """Return the numbers of the obstacles that the contact nodes may meet; all numbers if there is none."""
    nodes = body.initial_at(body.contact_nodes)
    edge = body.mesh.shortest_edge
    moved = _longest(body.initial_displacement, body.initial_displacement.mean(axis=0))
    freed = body.wave_speed * moved / edge
    own = _longest(body.initial_velocity) + body.driven_speed(duration) + freed
    fall = gravity * duration + speed_by_loads(body, duration)
    try:
        pushed = 2.0 * max((_speed(obstacle, nodes, duration) for obstacle in obstacles), default=0.0)
    except FunctionError:  # no bound of the motion; a run stops where the function fails
        pushed = np.inf
    way = OUT_OF_REACH * ((own + fall + pushed) * duration + edge)
    within = [number for number, obstacle in enumerate(obstacles) if len(nodes) and obstacle.gap(nodes).min() <= way]
    return within or list(range(len(obstacles)))
