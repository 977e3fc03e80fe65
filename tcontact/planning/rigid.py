"""The rigid bodies of a domain: obstacles that move freely, and rigid parts of its bodies with the nodes they carry."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..base.errors import InputError
from ..kernels.rigid_places import DRIVEN, FREE, PRESCRIBED
from ..scene.body import Body
from ..scene.obstacles.motion import Motion
from ..scene.rigid import RigidPart, inertia_matrix, point_inertia
from ..scene.scene import Scene


@dataclass(frozen=True, eq=False)
class RigidPlan:
    """One rigid body at t = 0, in axes of the world.

    kind: FREE, DRIVEN or PRESCRIBED (an obstacle that is none of the rigid bodies, but keeps its number); mass [kg];
    inertia [3, 3] [kg m^2] about the centre of mass [3] [m]; velocity, angular_velocity [3]; frame [3, 3]: axes of an
    obstacle, in rows; nodes [t]: boundary nodes of the domain that move with it, at arms [t, 3] from the centre; part:
    what the user gave; motion: of the reference point of a driven part.
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
    part: RigidPart | None = None
    motion: Motion | None = None

    @property
    def own_mass(self) -> float:
        """Mass [kg] beside that of its nodes."""
        if self.part is not None:
            return float(self.part.mass or 0.0)
        return self.mass if self.kind == FREE else 0.0


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
        found.append(
            RigidPlan(
                name,
                FREE,
                mass=float(obstacle.mass or 0.0),
                inertia=obstacle.inertia_about_center(),
                center=obstacle.reference,
                velocity=np.zeros(3) if obstacle.velocity is None else obstacle.velocity,
                angular_velocity=np.zeros(3) if obstacle.angular_velocity is None else obstacle.angular_velocity,
                frame=obstacle.frame,
            )
        )
    return tuple(found)


def rigid_parts(
    body: Body, label: str, lumped: np.ndarray, mass: np.ndarray, rows: np.ndarray
) -> tuple[RigidPlan, ...]:
    """Return the rigid parts of a body with the nodes that they carry.

    lumped [n] [kg]: masses of its nodes; mass [s, 3, 3] [kg]: of its boundary nodes, after redistribution; rows [n]:
    boundary node of each node. Raises `InputError` where a part takes mass in one direction only, and for nodes on a
    line without an inertia.
    """
    found = []
    for part in body.rigid_parts:
        nodes = np.asarray(body.mesh.nodes_of(part.set))
        tensors = mass[rows[nodes]]
        masses = tensors[:, 0, 0]
        if np.abs(tensors - masses[:, None, None] * np.eye(3)).max() > 1e-12 * lumped.max():
            remedy = "it lies next to contact nodes that give it their mass along the normal alone; use removal='full'"
            raise InputError("Body.rigid_parts", part.set, remedy)
        place, speed = body.initial_nodes[nodes], body.initial_velocity[nodes]
        middle = np.asarray(masses @ place / masses.sum())
        own = part.mass or 0.0
        centre = middle if part.center is None or part.driven else part.center
        total = float(own + masses.sum())
        joint = (own * centre + masses @ place) / total
        of_nodes = point_inertia(masses, place - middle)
        inertia = point_inertia(masses, place - joint) + own * point_inertia(np.ones(1), (centre - joint)[None])
        if part.inertia is not None:
            inertia += inertia_matrix(part.inertia, np.eye(3))
        elif own:
            inertia += own / masses.sum() * of_nodes
        if not np.isfinite([*inertia.flat, *joint]).all():
            remedy = "its inertia overflows; look at the units of center, mass and density"
            raise InputError("Body.rigid_parts", part, remedy)
        if not np.linalg.eigvalsh(inertia)[0] > 1e-9 * np.trace(inertia):
            remedy = "its nodes lie on a line: give mass and inertia"
            if part.driven:
                remedy = (
                    "its nodes lie on a line: drive them by Support(velocity=), or take a set with nodes off the line"
                )
            raise InputError("RigidPart.inertia", part.inertia, remedy)
        reference = middle if part.center is None else part.center
        turning = np.linalg.lstsq(of_nodes, masses @ np.cross(place - middle, speed), rcond=1e-9)[0]
        moving = masses @ speed / masses.sum() + np.cross(turning, reference - middle)
        motion = None
        if part.driven:
            motion = Motion(replace(part, center=reference))  # type: ignore[arg-type]
            moving, turning = motion.velocity.at(np.zeros(1))[0], motion.spin.at(np.zeros(1))[0]
        moving = moving if part.velocity is None or part.driven else part.velocity
        turning = turning if part.angular_velocity is None or part.driven else part.angular_velocity
        velocity = moving + np.cross(turning, joint - reference)
        kind = DRIVEN if part.driven else FREE
        ties = {"nodes": rows[nodes], "arms": place - joint, "motion": motion, "part": part}
        found.append(RigidPlan(part.column(label), kind, total, inertia, joint, velocity, turning, **ties))
    return tuple(found)


def names_of(bodies: Sequence[RigidPlan]) -> dict[str, tuple[str, ...]]:
    """Return the names of the rigid bodies that the history has columns for, by the groups of these columns."""
    obstacles = tuple(body.name for body in bodies if body.part is None and body.kind == FREE)
    return {"free": obstacles, "part": tuple(body.name for body in bodies if body.part is not None)}
