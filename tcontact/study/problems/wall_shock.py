"""A neo-Hookean block in uniaxial strain strikes a wall at a share of its wave speed: plateau and shock speed.

The sides are held, so the motion is plane. The run ends when the shock has run through `travel` of the block.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .. import errors as err
from ..exact import WallShock
from . import cell_stiffness

unit = cell_stiffness
ERRORS = ("force_error", "plateau_error", "plateau_ripple", "shock_speed_error", "stretch_error")
SIZES = (40, 80, 160)
METHODS = ("massless-normal", "massless-depth-3", "massless-penalty-10", "penalty-1", "penalty-10", "impulse")
REFERENCE = "exact: jump conditions of a shock (Rankine-Hugoniot) in uniaxial strain"
TRAVEL = 0.8
GAP = 1e-4


def scene(
    *,
    cells: int = 80,
    mach: float = 0.1,
    young: float = 1e7,
    poisson: float = 0.3,
    density: float = 1000.0,
    length: float = 0.1,
) -> Any:
    """The block a ten-thousandth of its length above the wall; mach: speed over the wave speed sqrt((l + 2m)/rho)."""
    import tcontact as tc

    material = tc.NeoHookean(young=young, poisson=poisson, density=density)
    speed = mach * material.wave_speed
    side = length / 8.0
    mesh = tc.box_mesh(size=(side, side, length), cells=(1, 1, cells), origin=(0.0, 0.0, GAP * length))
    held = [tc.Support(f"{axis}{end}", axis) for axis in "xy" for end in ("min", "max")]
    block = tc.Body(mesh, material, velocity=(0.0, 0.0, -speed), contact="zmin", supports=held, name="block")
    shock = WallShock(material.lame_lambda, material.lame_mu, density, speed)
    duration = GAP * length / speed + TRAVEL * length / shock.shock_speed
    return tc.Scene(bodies=[block], obstacles=[tc.Plane()], duration=duration)


def exact(scene: Any) -> WallShock:
    """The jump conditions for the scene."""
    body = scene.bodies[0]
    return WallShock(body.material.lame_lambda, body.material.lame_mu, body.material.density, -float(body.velocity[2]))


def errors(result: Any) -> dict[str, float]:
    """Force, plateau (mean and ripple), shock speed from where the block moves at half its speed, density behind it."""
    shock, body = exact(result.scene), result.scene.bodies[0]
    size = np.ptp(body.mesh.nodes, axis=0)
    force, plateau = err.normal_force(result), shock.pressure * float(size[0] * size[1])
    time = result.history["time"]
    touch = GAP * float(size[2]) / shock.speed
    since = (time - touch) / (time[-1] - touch)
    flat = force[(since > 0.2) & (since < 0.95)]
    wanted = err.centred_mean(lambda t: plateau * np.maximum(0.0, t - touch), time)
    height = body.mesh.nodes[:, 2] - body.mesh.nodes[:, 2].min()
    levels = np.unique(np.round(height, 12))
    moved = np.array([(result.position - body.mesh.nodes)[np.abs(height - z) < 1e-9, 2].mean() for z in levels])
    stretch = 1.0 + np.diff(moved) / np.diff(levels)
    middle = 0.5 * (levels[1:] + levels[:-1])
    behind = stretch < 0.5 * (1.0 + shock.stretch)
    last = int(np.flatnonzero(behind)[-1]) if behind.any() else 0
    front = float("nan")
    if 0 < last < len(middle) - 1:
        half = 0.5 * (1.0 + shock.stretch)
        share = (half - stretch[last]) / (stretch[last + 1] - stretch[last])
        front = float(middle[last] + share * (middle[last + 1] - middle[last]))
    still = (middle > 0.1 * size[2]) & (middle < 0.7 * TRAVEL * size[2])
    return {
        "force_error": err.relative_l2(force, wanted),
        "plateau_error": err.plateau(flat, plateau),
        "plateau_ripple": err.ripple(flat, plateau),
        "shock_speed_error": abs(front / (result.time - touch) / shock.shock_speed - 1.0),
        "stretch_error": abs(float(stretch[still].mean()) - shock.stretch) / (1.0 - shock.stretch),
    }
