"""The rigid bodies of a domain: obstacles that move freely, and rigid parts of its bodies with the nodes they carry."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..kernels.rigid_places import DRIVEN, FREE, PRESCRIBED
from ..scene.scene import Scene


@dataclass(frozen=True, eq=False)
class RigidPlan:
    """One rigid body at t = 0, in axes of the world.

    kind: FREE, DRIVEN or PRESCRIBED (an obstacle that is none of the rigid bodies, but keeps its number); mass [kg];
    inertia [3, 3] [kg m^2] about the centre of mass [3] [m]; velocity, angular_velocity [3]; frame [3, 3]: axes of an
    obstacle, in rows; nodes [t]: boundary nodes of the domain that move with it, at arms [t, 3] from the centre.
    """

    name: str
    kind: int
    mass: float = 1.0
    inertia: Any = None
    center: Any = None
    velocity: Any = None
    angular_velocity: Any = None
    frame: Any = None
    nodes: Any = ()
    arms: Any = ()
    part: Any = None


def free_obstacles(scene: Scene) -> tuple[RigidPlan, ...]:
    """Return a plan for every obstacle of a scene in which some move freely, else none."""
    if not any(obstacle.free for obstacle in scene.obstacles):
        return ()
    found = []
    for number, obstacle in enumerate(scene.obstacles):
        name = scene.obstacle_label(number)
        if not obstacle.free:
            found.append(RigidPlan(name, PRESCRIBED))
            continue
        rates = [np.zeros(3) if rate is None else rate for rate in (obstacle.velocity, obstacle.angular_velocity)]
        inertia = obstacle.inertia_about_center()
        found.append(
            RigidPlan(name, FREE, obstacle.mass, inertia, obstacle.reference, *rates, frame=obstacle.frame)
        )
    return tuple(found)


def names_of(bodies: Sequence[RigidPlan]) -> dict[str, tuple[str, ...]]:
    """Return the names of the rigid bodies that the history has columns for, by the groups of these columns."""
    obstacles = tuple(body.name for body in bodies if body.part is None and body.kind == FREE)
    return {"free": obstacles, "part": tuple(body.name for body in bodies if body.kind == DRIVEN or body.part is not None)}
