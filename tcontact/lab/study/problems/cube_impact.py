"""A cube strikes a wall (the case cube-impact): against a finer run of the massless method, computed once and kept."""

from __future__ import annotations

from typing import Any

import numpy as np

from tcontact.cases import cube_impact as case

from ....results.smoothness import force_variation
from .. import errors as err
from ..methods import STANDARD
from . import cell_stiffness

scene = case.scene
unit = cell_stiffness
ERRORS = ("force_error", "force_step_error", "impulse_error", "plateau_error", "restitution_error", "force_variation")
SIZES = (4, 8, 16)
METHODS = tuple(name for name in STANDARD if name != "penalty-100")
FINER = 2  # the reference has so many times the largest size
REFERENCE_CFL = 0.45


def reference(result: Any) -> dict[str, np.ndarray]:
    """Return what is kept of the fine run."""
    history = result.history
    return {
        "time": history["time"],
        "impulse": history["impulse"] @ np.asarray(result.scene.obstacles[0].normal),
        "momentum": history["momentum"] @ np.asarray(result.scene.obstacles[0].normal),
    }


def errors(result: Any, reference: dict[str, np.ndarray]) -> dict[str, float]:
    """Return errors of force (means of sixteenths of the contact), running impulse, middle force, restitution."""
    time, force = result.history["time"], err.normal_force(result)
    normal = np.asarray(result.scene.obstacles[0].normal)

    def impulse(t: np.ndarray) -> np.ndarray:
        return np.interp(t, reference["time"], reference["impulse"])

    total = reference["impulse"][-1]
    begin, end = (np.interp(share * total, reference["impulse"], reference["time"]) for share in (0.01, 0.99))
    own = result.history["impulse"] @ normal
    windows = np.linspace(begin, end, 17)
    mean = np.diff(np.interp(windows, time, own)) / np.diff(windows)
    inside = np.array([begin + 0.25 * (end - begin), begin + 0.75 * (end - begin)])
    plateau = np.diff(np.interp(inside, time, own))[0] / np.diff(impulse(inside))[0]
    speed = reference["momentum"]
    left = (result.history["momentum"] @ normal)[-1] / (result.history["momentum"] @ normal)[0]
    return {
        "force_error": err.relative_l2(mean, np.diff(impulse(windows)) / np.diff(windows)),
        "force_step_error": err.relative_l2(force, err.centred_mean(impulse, time)),
        "impulse_error": float(np.abs(own - impulse(time)).max() / total),
        "plateau_error": abs(float(plateau) - 1.0),
        "restitution_error": abs(float(left - speed[-1] / speed[0])),
        "force_variation": force_variation(force),
    }
