"""A start that is displaced: a state handed to `simulate(initial=...)`."""

from __future__ import annotations

import numpy as np

from ..result import Result
from ..scene import Scene


def start(scene: Scene, displacement: np.ndarray) -> Result:
    """A result that holds the bodies of the scene at a displacement [n, 3], with their initial velocities.

    Nothing was run: its history is empty. Nodes are stacked in body order.
    """
    nodes = np.concatenate([body.mesh.nodes for body in scene.bodies])
    velocity = np.concatenate([body.initial_velocity for body in scene.bodies])
    return Result(
        ok=True,
        reason="finished",
        message="",
        steps=0,
        time=0.0,
        dt=0.0,
        dt_limit=0.0,
        wall_s=0.0,
        compile_s=0.0,
        cell_updates_per_s=0.0,
        memory={},
        terms=(),
        position=nodes + np.asarray(displacement, dtype=float),
        velocity=velocity,
        contact_node_force=np.zeros_like(nodes),
        history={},
        scene=scene,
    )
