"""A bar strikes a rigid wall: exact force, rebound and final displacement (the case bar-impact)."""

from __future__ import annotations

from typing import Any

import numpy as np

from tcontact.cases import bar_impact as case

from ....results.smoothness import force_variation
from .. import errors as err
from ..methods import STANDARD
from . import cell_stiffness

scene = case.scene
unit = cell_stiffness
ERRORS = (
    "force_error",
    "plateau_error",
    "plateau_ripple",
    "impulse_error",
    "overshoot",
    "force_variation",
    "restitution_error",
    "displacement_error",
)
SIZES = (20, 40, 80, 160)
METHODS = STANDARD
REFERENCE = "exact: rho c v A for the time 2 length/c, then free of stress (d'Alembert)"


def errors(result: Any) -> dict[str, float]:
    """Return errors of force, plateau (mean, ripple), running impulse, restitution, end displacement in units of vL/c.

    Beside them, though no errors against the exact solution: the overshoot at the touch and the force variation (1).
    """
    scene = result.scene
    body = scene.bodies[0]
    touch, release, plateau = case.times_and_force(scene)
    speed, length = -float(body.velocity[2]), float(np.ptp(body.mesh.nodes[:, 2]))
    time, force = result.history["time"], err.normal_force(result)

    def impulse(t: np.ndarray) -> np.ndarray:
        return plateau * np.clip(t - touch, 0.0, release - touch)

    flat = force[(time > touch + 0.1 * (release - touch)) & (time < touch + 0.9 * (release - touch))]
    found = {
        "force_error": err.relative_l2(force, err.centred_mean(impulse, time)),
        "plateau_error": err.plateau(flat, plateau),
        "plateau_ripple": err.ripple(flat, plateau),
        "impulse_error": float(np.abs(result.history["impulse"][:, 2] - impulse(time)).max() / impulse(time[-1:])[0]),
    }
    found["overshoot"] = float(force.max() / plateau - 1.0)
    found["force_variation"] = force_variation(force)
    momentum = result.history["momentum"][:, 2]
    found["restitution_error"] = float(abs(momentum[-1] / momentum[0] + 1.0))
    wanted = speed * (result.time - release) - touch * speed
    moved = result.position[:, 2] - body.mesh.nodes[:, 2]
    found["displacement_error"] = float(
        np.sqrt(np.mean((moved - wanted) ** 2)) / (speed * length / body.material.wave_speed)
    )
    return found
