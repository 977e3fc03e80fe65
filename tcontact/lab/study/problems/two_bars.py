"""Two bars meet (the case two-bars): exact force, against a penalty on ordinary mass with the same step."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from tcontact.cases import _choices as choices
from tcontact.cases import two_bars as case

from ....results.smoothness import releases
from ....scene.contact_models import MasslessContact
from .. import errors as err

scene = case.scene
unit = choices.slave_stiffness
ERRORS = ("plateau_ripple", "plateau_error", "impulse_error", "overshoot", "total_variation", "touches")
SIZES = (10, 20, 40, 80)
METHODS = ("massless-normal", "massless-full", "penalty-1", "penalty-10", "penalty-10*0.33", "penalty-10*0.11")
SCHEMES = False  # no implicit scheme has contact between bodies
REFERENCE = "exact: V Z1 Z2/(Z1 + Z2) until the first wave comes back (d'Alembert); steps over the bars' stable one"


def step(scene: Any) -> float:
    """Return the stable step [s] of the bars, which contact without mass does not change."""
    import tcontact as tc

    return float(tc.simulate(replace(scene, contact=MasslessContact(), duration=1e-9 * scene.duration)).dt_limit)


def errors(result: Any) -> dict[str, float]:
    """Return errors of the plateau (root mean square, mean) and of the running impulse.

    Beside them, though no errors: the overshoot, the sum of all changes of the force over twice the plateau (1 for one
    rise and one fall), and how often the bars touch (1 for equal bars).
    """
    scene, time = result.scene, result.history["time"]
    touch, lasts, plateau = case.exact(scene)
    force = result.pair_force["upper-lower"][:, 2]
    flat = force[(time > touch + 0.25 * lasts) & (time < touch + 0.85 * lasts)]
    impulse = np.concatenate([[0.0], np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(time))])
    wanted = plateau * np.clip(time - touch, 0.0, lasts)
    upper, lower = scene.bodies
    known = time <= (np.inf if upper.material == lower.material else touch + lasts)  # then they part
    return {
        "plateau_ripple": err.ripple(flat, plateau),
        "plateau_error": err.plateau(flat, plateau),
        "impulse_error": float(np.abs(impulse - wanted)[known].max() / (plateau * lasts)),
        "overshoot": float(force.max() / plateau - 1.0),
        "total_variation": float(np.abs(np.diff(force)).sum() / (2.0 * plateau)),
        "touches": float(releases(force) + (force[-1] > 0.0)),
    }
