"""The state of all bodies at the end of a run, as the result has it."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..cells.point_state import has_state, metal_fields
from ..mesh.geometry import joined
from ..scene.scene import Scene
from ..schemes.explicit.body_view import BodyView
from ..schemes.explicit.pair_memory import remembered
from .snapshot import Snapshot


def end_state(scene: Scene, states: list[BodyView], last: Snapshot) -> dict[str, Any]:
    """Return the fields of the result with values of nodes and cells; last: the state at the end."""
    return motion(scene, last) | forces_and_points(scene, states)


def motion(scene: Scene, last: Snapshot) -> dict[str, Any]:
    """Return the fields of `end_state` that say where the nodes are and go."""
    return {"position": _positions(scene, last), "velocity": last.velocity_field().values()}


def forces_and_points(scene: Scene, states: list[BodyView]) -> dict[str, Any]:
    """Return the other fields of `end_state`."""
    points = tuple(state.points() for state in states) if has_state(scene) else ()
    return {
        "contact_node_force": joined([state.contact_force() for state in states]),
        "layers": tuple(state.layers() for state in states),
        "metals": metal_fields(scene.bodies, points) if scene.plastic else {},
        "points": points,
        "pairs": remembered(scene, states),
    }


def _positions(scene: Scene, last: Snapshot) -> np.ndarray:
    """Return the positions [n, 3] [m] of the nodes of all bodies; last: the state, which forgets its displacements."""
    found = []
    for body, places in zip(scene.bodies, last.last_displacements(), strict=True):
        first = 0
        for nodes in body.mesh.portions("nodes"):
            places[first : first + len(nodes)] += nodes
            first += len(nodes)
        found.append(places)
    return joined(found)
