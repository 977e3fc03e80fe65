"""A nearly incompressible beam swings (the case incompressible-beam): against a finer run, computed once and kept.

Nothing touches anything: the methods differ in their time schemes alone, explicit ones at their stable step, implicit
ones far above it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tcontact.cases import incompressible_beam as case

from .. import errors as err
from . import cell_stiffness

unit = cell_stiffness
ERRORS = ("tip_error", "momentum_error")
SIZES = (10, 20, 40)
METHODS = (
    "massless-normal",
    "massless-normal@discrete-gradient*10",
    "massless-normal@discrete-gradient*50",
    "massless-normal@gonzalez*50",
    "massless-normal@midpoint*50",
    "massless-normal@trapezoidal*50",
    "massless-normal@paper-implicit*50",
)
FINER = 2  # the reference has so many times the largest size
REFERENCE_CFL = 0.9
DURATION = 0.5  # [s]; the free end has gone up, stopped and turned back


def scene(*, cells: int = 20, ratio: float = 10.0, duration: float = DURATION) -> Any:
    """Return the beam of the case."""
    return case.scene(cells=cells, ratio=ratio, duration=duration)


def tip(result: Any) -> np.ndarray:
    """Return the mean displacement [3] [m] of the corners of the free end."""
    mesh = result.scene.bodies[0].mesh
    span = np.abs(mesh.nodes[:, 1] - np.mean(mesh.nodes[:, 1]))
    far = (mesh.nodes[:, 0] > mesh.nodes[:, 0].max() - 1e-9) & (span > span.max() - 1e-9)
    return np.asarray((result.position - mesh.nodes)[far].mean(axis=0))


def reference(result: Any) -> dict[str, np.ndarray]:
    """Return what is kept of the fine run."""
    history, volume = result.history, np.prod(np.ptp(result.scene.bodies[0].mesh.nodes, axis=0))
    return {"time": history["time"], "momentum": history["momentum"][:, :2] / volume, "tip": tip(result)}


def errors(result: Any, reference: dict[str, np.ndarray]) -> dict[str, float]:
    """Return errors of the tip over the length of the beam, and of the momentum per volume over time."""
    own, time = result.history, np.linspace(0.0, float(reference["time"][-1]), 201)
    volume = np.prod(np.ptp(result.scene.bodies[0].mesh.nodes, axis=0))
    found = [np.interp(time, own["time"], own["momentum"][:, axis] / volume) for axis in (0, 1)]
    wanted = [np.interp(time, reference["time"], reference["momentum"][:, axis]) for axis in (0, 1)]
    way = tip(result) - reference["tip"]
    return {
        "tip_error": float(np.linalg.norm(way) / np.ptp(result.scene.bodies[0].mesh.nodes[:, 0])),
        "momentum_error": err.relative_l2(np.concatenate(found), np.concatenate(wanted)),
    }
