"""A block tumbles freely (the case tumbling-block): its corners against a finer run, computed once and kept."""

from __future__ import annotations

from typing import Any

import numpy as np

from tcontact.cases import tumbling_block as case

from . import cell_stiffness

unit = cell_stiffness
ERRORS = ("corner_error", "angular_momentum_error")
SIZES = (6, 12, 24)
METHODS = (
    "massless-normal",
    "massless-normal@discrete-gradient",
    "massless-normal@discrete-gradient*4",
    "massless-normal@gonzalez*4",
    "massless-normal@midpoint*4",
    "massless-normal@trapezoidal*4",
)
FINER = 2  # the reference has so many times the largest size
REFERENCE_CFL = 0.9
DURATION = 5e-3  # [s]: a sixth of a turn, some periods of the vibration


def scene(*, cells: int = 6, kind: Any = "hex8", duration: float = DURATION) -> Any:
    """Return the block of the case."""
    return case.scene(cells=cells, kind=kind, duration=duration)


def corners(result: Any) -> np.ndarray:
    """Return the positions [8, 3] [m] of the corners at the end."""
    nodes = result.scene.bodies[0].mesh.nodes
    away = np.abs(nodes - nodes.mean(axis=0))
    found = np.flatnonzero((away > away.max(axis=0) - 1e-9).all(axis=1))
    return np.asarray(result.position[found[np.lexsort(nodes[found].T)]])


def reference(result: Any) -> dict[str, np.ndarray]:
    """Return what is kept of the fine run."""
    return {"corners": corners(result)}


def errors(result: Any, reference: dict[str, np.ndarray]) -> dict[str, float]:
    """Return errors of the corners over the longest edge, and the change of the angular momentum."""
    off = np.linalg.norm(corners(result) - reference["corners"], axis=1).max()
    turned = result.history["angular_momentum"]
    change = np.linalg.norm(turned - turned[0], axis=1).max() / np.linalg.norm(turned[0])
    edge = np.ptp(result.scene.bodies[0].mesh.nodes, axis=0).max()
    return {"corner_error": float(off / edge), "angular_momentum_error": float(change)}
