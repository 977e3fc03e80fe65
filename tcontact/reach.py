"""Which faces of a body may meet an obstacle, `Body(contact="auto")`, and which obstacles are out of reach.

A face may, if it looks towards the obstacle (its outward normal within 90 degrees of minus the obstacle's) and the
obstacle is near enough at t = 0:

    distance <= 1.5 (|v| + |g| T + w) T + |u| + shortest edge,

|v| the body's largest initial speed, T the duration, g gravity, w the largest speed of the obstacle's points near the
body, |u| the largest initial displacement. Faces that turn towards an obstacle later are not found: name their set.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from .errors import FunctionError
from .mesh_geometry import shortest_edge
from .obstacles import Obstacle
from .obstacles.motion import Rate

if TYPE_CHECKING:
    from .scene import Body

SLACK = 1.5  # on the way, for what the body's waves add to its speed
FACING = -1e-6  # cosine: faces along the way do not look at it
SAMPLES = 257  # of a motion given as a function of time
OUT_OF_REACH = 10.0  # times the way that a node can go


def with_reached_faces(body: Body, obstacles: Sequence[Obstacle], duration: float, gravity: Any) -> Body:
    """The body with the faces that may meet one of the obstacles as its contact faces; itself unless "auto"."""
    if not body.finds_contact:
        return body
    faces = body.outer_faces
    if len(obstacles) == 0 or len(faces) == 0:
        faces = faces[:0]
    else:
        near = np.zeros(len(faces), dtype=bool)
        for obstacle in obstacles:
            near |= _meets(body, faces, obstacle, duration, gravity)
        faces = faces[near]
    result = copy.copy(body)
    result.__dict__.pop("contact_nodes", None)
    result.__dict__["contact_faces"] = faces
    return result


def _meets(body: Body, faces: np.ndarray, obstacle: Obstacle, duration: float, gravity: Any) -> np.ndarray:
    corners = body.initial_nodes[faces]
    centre = corners.mean(axis=1)
    radius = np.linalg.norm(corners - centre[:, None], axis=2).max(axis=1)
    across = np.cross(corners[:, 2] - corners[:, 0], corners[:, -1] - corners[:, 1])
    outward = across / np.linalg.norm(across, axis=1).clip(1e-300)[:, None]
    facing = np.einsum("ni,ni->n", outward, obstacle.normal_at(centre)) < FACING
    speed = float(np.linalg.norm(body.initial_velocity, axis=1).max())
    fall = 0.0 if gravity is None else float(np.linalg.norm(gravity)) * duration
    way = SLACK * (speed + fall + _speed(obstacle, body.initial_nodes, duration)) * duration
    shift = float(np.linalg.norm(body.initial_displacement, axis=1).max())
    near = obstacle.gap(centre) - radius <= way + shift + shortest_edge(body.mesh.nodes, body.mesh.cells)
    return np.asarray(facing & near)


def _speed(obstacle: Obstacle, positions: np.ndarray, duration: float) -> float:
    """Largest speed [m/s] that the obstacle's motion has at the distance of the farthest position."""
    if not obstacle.moves:
        return 0.0
    times = np.linspace(0.0, duration, SAMPLES)
    moving = float(np.linalg.norm(Rate(obstacle, "velocity").at(times), axis=1).max())
    turning = float(np.linalg.norm(Rate(obstacle, "angular_velocity").at(times), axis=1).max())
    return moving + turning * float(np.linalg.norm(positions - obstacle.reference, axis=1).max())


def within_reach(body: Body, obstacles: Sequence[Obstacle], duration: float, gravity: Any) -> list[int]:
    """Numbers of the obstacles that the contact nodes of the body may come to; all, if it is none."""
    nodes = body.initial_nodes[body.contact_nodes]
    edge = shortest_edge(body.mesh.nodes, body.mesh.cells)
    moved = body.initial_displacement - body.initial_displacement.mean(axis=0)
    freed = body.material.wave_speed * float(np.linalg.norm(moved, axis=1).max()) / edge
    own = float(np.linalg.norm(body.initial_velocity, axis=1).max()) + freed
    fall = 0.0 if gravity is None else float(np.linalg.norm(gravity)) * duration
    try:
        pushed = 2.0 * max((_speed(obstacle, nodes, duration) for obstacle in obstacles), default=0.0)
    except FunctionError:  # it may go anywhere; the run that asks it then stops there
        pushed = np.inf
    way = OUT_OF_REACH * ((own + fall + pushed) * duration + edge)
    near = [number for number, obstacle in enumerate(obstacles) if len(nodes) and obstacle.gap(nodes).min() <= way]
    return near or list(range(len(obstacles)))
