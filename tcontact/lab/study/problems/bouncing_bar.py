"""A bar bounces under gravity: exact force through every contact (the case bouncing-bar)."""

from __future__ import annotations

from typing import Any

import numpy as np

from tcontact.cases import bouncing_bar as case

from .. import errors as err
from . import cell_stiffness

scene = case.scene
unit = cell_stiffness
ERRORS = ("force_error", "impulse_error", "restitution_error")
SIZES = (20, 40, 80)
METHODS = ("massless-normal", "massless-full", "massless-penalty-10", "penalty-1", "penalty-10", "impulse")
REFERENCE = "exact: d'Alembert's solution through every contact"


def errors(result: Any) -> dict[str, float]:
    """Return errors of force, running impulse, impulse of the worst bounce (restitution), energy left at the end."""
    scene, history = result.scene, result.history
    time, force = history["time"], err.normal_force(result)
    speed, gravity, wave, begins = case.timing(scene)
    flights = begins + wave + speed / gravity
    bounce = np.diff([np.interp(t, time, history["impulse"][:, 2]) for t in flights], prepend=0.0)
    wanted = np.diff(case.exact_impulse(flights, scene), prepend=0.0)
    total = case.exact_impulse(time[-1:], scene)[0]
    return {
        "force_error": err.relative_l2(force, err.centred_mean(lambda t: case.exact_impulse(t, scene), time)),
        "impulse_error": float(np.abs(history["impulse"][:, 2] - case.exact_impulse(time, scene)).max() / total),
        "restitution_error": float(np.abs(bounce / wanted - 1.0).max()),
    }
