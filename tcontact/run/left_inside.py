"""Tell of the contact node that ends deepest inside an obstacle, where exact contact should have kept it out.

A support may hold it there. With normal removal a node whose normal has turned by a right angle since the start, such
as one that has come to another face of a block, has no massless direction in which contact could move it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from ..planning.removal import FLAT, choose_removal
from ..scene.contact_models import MasslessContact
from ..scene.obstacles import Box
from ..scene.obstacles.description import poses
from ..scene.scene import Scene

DEEP = 1e-6  # depth over the size of the largest body up to which a node is not inside


def left_inside(
    scene: Scene, implicit: bool, positions: np.ndarray, history: Mapping[str, np.ndarray]
) -> Iterator[str]:
    """Yield a warning about the deepest contact node at the end of a run, if exact contact left one inside.

    implicit: whether the scheme is; positions [n, 3] [m]: of the nodes of all bodies at the end; history: of the run.
    """
    exact = isinstance(scene.contact, MasslessContact) and scene.contact.penalty is None
    near = -DEEP * max(body.mesh.size for body in scene.bodies)
    if not exact or not scene.obstacles or not len(history["time"]) or not history["gap_min"][-1] < near:
        return
    lowest, first, time = near, 0, float(history["time"][-1])
    found: tuple[int, int, int, np.ndarray] | None = None
    for number, body in enumerate(scene.bodies):
        there = positions[first : first + body.mesh.node_count]
        first += body.mesh.node_count
        if not body.touches:
            continue
        for which, obstacle in enumerate(scene.obstacles):
            pose = poses(obstacle, np.array([time]), scene.obstacle_label(which), history)
            point, frame = (obstacle.reference, obstacle.frame) if pose is None else (part[0] for part in pose)
            gaps, normals = obstacle.local((there[body.contact_nodes] - point) @ frame.T)
            deepest = int(np.argmin(gaps))
            if gaps[deepest] < lowest:
                lowest = float(gaps[deepest])
                found = number, which, int(body.contact_nodes[deepest]), normals[deepest] @ frame
    if found is None:
        return
    number, which, node, normal = found
    body = scene.bodies[number]
    begin = sum(one.mesh.node_count for one in scene.bodies[:number])
    place = ", ".join(f"{part:.6g}" for part in positions[begin + node])
    text = f"contact node {node} of {scene.label(number)} at ({place}) ends {-lowest:.3g} m inside obstacle"
    text += f" {scene.obstacle_label(which)} at t = {time:.6g} s"
    if (np.abs(normal[~np.isnan(body.prescribed[node])]) > FLAT).any():
        yield f"{text}: its support holds it there"
    elif not implicit and choose_removal(scene, number) == "normal":
        block = isinstance(scene.obstacles[which], Box)
        edges = ", or put the edges of the block between lines of nodes" if block else ""
        yield (
            f"{text}: with normal removal contact moves a node along its normal of the start alone, and that is not the"
            f" way out there; use MasslessContact(removal='full') or PenaltyContact{edges}"
        )
    elif not implicit:
        yield f"{text}: contact did not move it out; use a smaller cfl or dt"
