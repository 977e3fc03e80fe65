"""Tell of bodies that end inside an obstacle with nodes that are no contact nodes, and so went through its surface.

Scenes refuse bodies that touch something and start inside an obstacle: such nodes have entered in the run, because the
faces that met the obstacle are not in `Body.contact`. It is looked for once, at the end of a run. Obstacles that move
freely are left out, as their place is not a function of time.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..scene.body import Body
from ..scene.obstacles import Obstacle
from ..scene.obstacles.description import poses
from ..scene.scene import Scene

PORTION = 2**16  # nodes of which gaps are measured at a time


def entered(scene: Scene, positions: np.ndarray, time: float) -> Iterator[str]:
    """Yield a warning for each body and obstacle in which it ends deeper than its shortest edge, away from contact.

    positions [n, 3] [m]: of the nodes of all bodies at the time [s]. Where contact nodes are as deep, contact has given
    way to a penalty, which is another matter.
    """
    if scene.contact is None or not scene.obstacles:
        return
    first = 0
    for number, body in enumerate(scene.bodies):
        there = positions[first : first + body.mesh.node_count]
        first += body.mesh.node_count
        if not body.touches:
            continue
        touching = np.zeros(body.mesh.node_count, dtype=bool)
        touching[body.contact_nodes] = True
        for which, obstacle in enumerate(scene.obstacles):
            found = None if obstacle.free else _deepest(body, obstacle, there, touching, time)
            if found is not None:
                node, depth = found
                yield (
                    f"node {node} of {scene.label(number)} ends {depth:.3g} m inside obstacle"
                    f" {scene.obstacle_label(which)}, which does not hold it: only the faces in Body.contact ="
                    f" {_given(body)} touch anything; add those that meet the obstacle, or give contact='auto'"
                )


def _deepest(
    body: Body, obstacle: Obstacle, there: np.ndarray, touching: np.ndarray, time: float
) -> tuple[int, float] | None:
    """Return the node that is deepest inside an obstacle, and its depth [m]; None where none is deeper than an edge.

    there [n, 3] [m]: positions; touching [n]: whether a node is a contact node.
    """
    pose = poses(obstacle, np.array([time]), "", {})
    point, turn = (obstacle.reference, obstacle.frame) if pose is None else (part[0] for part in pose)
    lowest, node, held = 0.0, -1, 0.0
    for first in range(0, len(there), PORTION):
        part = slice(first, first + PORTION)
        gap = obstacle.local((there[part] - point) @ turn.T)[0]
        held = min(held, float(gap.min(where=touching[part], initial=0.0)))
        free = np.where(touching[part], np.inf, gap)
        if float(free.min()) < lowest:
            node, lowest = first + int(np.argmin(free)), float(free.min())
    if node < 0 or -lowest <= (edge := body.mesh.shortest_edge) or -held > edge:
        return None
    return node, -lowest


def _given(body: Body) -> str:
    """Return the sets of the contact of a body as a user gave them."""
    names = [*(body.contact or ())]
    return repr(names[0] if len(names) == 1 else names)
