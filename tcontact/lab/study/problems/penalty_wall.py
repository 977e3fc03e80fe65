"""A bar strikes a wall that yields: the overlap, the contact time and the rebound of that wall in closed form.

The K of massless-penalty-K and penalty-K is the stiffness of the wall in rho c^2/L: the same wall at every size. A
method must converge to this wall's answer, not to the rigid one's.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ....base.errors import InputError
from ....results.exact import PenaltyWall
from .. import errors as err
from . import column

ERRORS = (
    "force_error",
    "overlap_error",
    "largest_overlap_error",
    "contact_time_error",
    "impulse_error",
    "restitution_error",
)
SIZES = (20, 40, 80, 160)
METHODS = tuple(f"{kind}-{k}" for kind in ("massless-penalty", "penalty") for k in (5, 20, 80, 200))
REFERENCE = "exact: a linear bar on a spring layer, in closed form (tcontact.results.exact.PenaltyWall)"
GAP = 1e-3  # gap over the length


def scene(
    *, cells: int = 80, young: float = 1e7, density: float = 1000.0, length: float = 0.1, speed: float = 1.0
) -> Any:
    """The bar starts a thousandth of its length above the wall; SI units. The contact model is the method's."""
    import tcontact as tc

    mesh, material = column(cells, length, young, density, gap=GAP * length)
    bar = tc.Body(mesh, material, velocity=(0.0, 0.0, -speed), contact="zmin", name="bar")
    duration = GAP * length / speed + 2.6 * length / material.wave_speed
    return tc.Scene(bodies=[bar], obstacles=[tc.Plane()], duration=duration, contact=tc.MasslessContact(penalty=1.0))


def unit(scene: Any) -> float:
    """Return rho c^2/L [N/m^3]."""
    body = scene.bodies[0]
    return body.material.young / float(np.ptp(body.mesh.nodes[:, 2]))


def exact(scene: Any) -> PenaltyWall:
    """Return the closed form for the scene. Raises `InputError` for a contact model without a stiffness."""
    model, body = scene.contact, scene.bodies[0]
    stiffness = getattr(model, "penalty", None) or getattr(model, "stiffness", None)
    if stiffness is None:
        raise InputError("--methods", type(model).__name__, "use massless-penalty-K or penalty-K: this wall yields")
    size = np.ptp(body.mesh.nodes, axis=0)
    material = body.material
    speed = -float(body.velocity[2])
    return PenaltyWall(float(size[2]), float(size[0] * size[1]), material.young, material.density, speed, stiffness)


def errors(result: Any) -> dict[str, float]:
    """Return errors of force, overlap (largest; mean over the plateau), contact time, impulse and rebound."""
    wall, history = exact(result.scene), result.history
    touch = GAP * wall.length / wall.speed
    time, force = history["time"], err.normal_force(result)
    overlap = np.maximum(0.0, -history["gap_min"])
    since = time - touch
    flat = (since > 0.3 * wall.crossing) & (since < 0.9 * wall.crossing)
    mean = float(np.mean(overlap[flat] / wall.overlap(since[flat])))
    momentum = history["momentum"][:, 2]
    impulse = float(wall.impulse(wall.contact_time))
    return {
        "force_error": err.relative_l2(force, err.centred_mean(lambda t: wall.impulse(t - touch), time)),
        "overlap_error": abs(mean - 1.0),
        "largest_overlap_error": abs(float(overlap.max()) / wall.largest_overlap - 1.0),
        "contact_time_error": abs(closed_time(time, history["gap_min"]) / wall.contact_time - 1.0),
        "impulse_error": float(np.abs(history["impulse"][:, 2] - wall.impulse(since)).max()) / impulse,
        "restitution_error": abs(-momentum[-1] / momentum[0] - wall.rebound),
    }


def closed_time(time: np.ndarray, gap: np.ndarray) -> float:
    """Return the time [s] from the first to the last zero of the gap, interpolated; nan if it never closes or opens."""
    ends = np.flatnonzero((gap[:-1] < 0.0) != (gap[1:] < 0.0))
    if len(ends) < 2:
        return float("nan")
    zeros = [time[i] + (time[i + 1] - time[i]) * gap[i] / (gap[i] - gap[i + 1]) for i in (ends[0], ends[-1])]
    return float(zeros[1] - zeros[0])
