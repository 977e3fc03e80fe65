"""A neo-Hookean block in uniaxial strain strikes a wall: plateau, shock speed and stretch (the case wall-shock)."""

from __future__ import annotations

from typing import Any

import numpy as np

from tcontact.cases import wall_shock as case

from .. import errors as err
from . import cell_stiffness

scene = case.scene
unit = cell_stiffness
ERRORS = ("force_error", "plateau_error", "plateau_ripple", "shock_speed_error", "stretch_error")
SIZES = (40, 80, 160)
METHODS = ("massless-normal", "massless-depth-3", "massless-penalty-10", "penalty-1", "penalty-10", "impulse")
REFERENCE = "exact: jump conditions of a shock (Rankine-Hugoniot) in uniaxial strain"


def errors(result: Any) -> dict[str, float]:
    """Return errors of force, plateau (mean, ripple), speed of the shock, compression behind it."""
    shock, touch, plateau = case.exact(result.scene)
    time, force = result.history["time"], err.normal_force(result)
    since = (time - touch) / (time[-1] - touch)
    flat = force[(since > 0.2) & (since < 0.95)]
    levels, stretch = case.stretches(result)
    still = (levels > 0.1 * levels[-1]) & (levels < 0.7 * case.TRAVEL * levels[-1])
    return {
        "force_error": err.relative_l2(force, err.centred_mean(lambda t: plateau * np.maximum(0.0, t - touch), time)),
        "plateau_error": err.plateau(flat, plateau),
        "plateau_ripple": err.ripple(flat, plateau),
        "shock_speed_error": abs(case.front(result) / (result.time - touch) / shock.shock_speed - 1.0),
        "stretch_error": abs(float(stretch[still].mean()) - shock.stretch) / (1.0 - shock.stretch),
    }
