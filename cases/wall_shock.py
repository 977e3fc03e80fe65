"""A neo-Hookean block in uniaxial strain strikes a wall at a share of its wave speed: a shock with a known plateau.

The sides are held, so the motion is plane. From the touch on a shock runs up the block; behind it the block rests, with
a stretch and a pressure that follow from the jump conditions (`tcontact.results.exact.WallShock`). The run ends when
the shock has gone through 0.8 of the block. Nothing dissipates here: energy must not grow, and what a real shock would
turn into heat stays behind the front as small vibration.
"""

from __future__ import annotations

import sys
from pathlib import Path

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import numpy as np

import tcontact as tc
from tcontact.cases import _choices as choices
from tcontact.cases._inputs import checked
from tcontact.results import checks as ck
from tcontact.results.exact import WallShock

TRAVEL = 0.8  # share of the block that the shock runs through


@checked
def scene(
    *,
    cells: int = 80,
    kind: choices.Kind = "hex8",
    mach: float = 0.1,
    young: float = 1e7,
    poisson: float = 0.3,
    density: float = 1000.0,
    length: float = 0.1,
    gap: float = 1e-5,
    contact: choices.Contact = "massless",
    removal: choices.Removal = "auto",
    penalty: float | None = None,
    depth: int = 1,
    sweeps: int = 10,
    tolerance: float | None = None,
) -> tc.Scene:
    """A square block with all its `cells` cells along its length flies down from `gap` above the plane z = 0.

    SI units. mach: speed over the wave speed sqrt((lambda + 2 mu)/density), below 1; penalty: None = exact, else
    multiples of young/h (contact=penalty: None = 10).
    """
    material = choices.material("neo-hookean", young, poisson, density)
    choices.positive(length=length, mach=mach, cells=cells)
    choices.not_negative(gap=gap)
    if not mach < 1.0:
        raise tc.InputError("mach", mach, "must be less than 1")
    speed, side = mach * material.wave_speed, length / 8.0
    mesh = tc.box_mesh(size=(side, side, length), cells=(1, 1, cells), kind=kind, origin=(-side / 2, -side / 2, gap))
    held = [tc.Support(f"{axis}{end}", axis) for axis in "xy" for end in ("min", "max")]
    model = choices.contact_model(
        contact,
        removal=removal,
        penalty=penalty,
        unit=young * cells / length,
        depth=depth,
        sweeps=sweeps,
        tolerance=tolerance,
    )
    block = tc.Body(mesh, material, velocity=(0.0, 0.0, -speed), contact="zmin", supports=held, name="block")
    shock = WallShock(material.lame_lambda, material.lame_mu, density, speed)
    duration = gap / speed + TRAVEL * length / shock.shock_speed
    return tc.Scene(bodies=[block], obstacles=[tc.Plane()], duration=duration, contact=model)


def exact(scene: tc.Scene) -> tuple[WallShock, float, float]:
    """Return the jump conditions, the time of touch [s] and the force of the plateau [N]."""
    body = scene.bodies[0]
    speed, size = -body.velocity[2], np.ptp(body.mesh.nodes, axis=0)
    shock = WallShock(body.material.lame_lambda, body.material.lame_mu, body.material.density, speed)
    touch = scene.obstacles[0].gap(body.mesh.nodes).min() / speed
    return shock, touch, shock.pressure * size[0] * size[1]


def front(result: tc.Result) -> float:
    """Return the reference height [m] at which the stretch is half that of the shock, at the end of the run."""
    shock, _, _ = exact(result.scene)
    levels, stretch = stretches(result)
    half = 0.5 * (1.0 + shock.stretch)
    behind = np.flatnonzero(stretch < half)
    last = behind[-1] if len(behind) else 0
    if not 0 < last < len(levels) - 1:
        return float("nan")
    share = (half - stretch[last]) / (stretch[last + 1] - stretch[last])
    return float(levels[last] + share * (levels[last + 1] - levels[last]))


def stretches(result: tc.Result) -> tuple[np.ndarray, np.ndarray]:
    """Return the height [m] of each layer of cells above the lower end, and its mean stretch at the end of the run."""
    mesh = result.scene.bodies[0].mesh
    height = np.round(mesh.nodes[:, 2] - mesh.nodes[:, 2].min(), 12)
    levels, member = np.unique(height, return_inverse=True)
    place = np.bincount(member, result.position[:, 2]) / np.bincount(member)
    return 0.5 * (levels[1:] + levels[:-1]), np.diff(place) / np.diff(levels)


def curves(result: tc.Result) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return the contact force by the jump conditions, to plot."""
    _, touch, force = exact(result.scene)
    return {"jump conditions": (np.array([0, touch, touch, result.scene.duration]), force * np.array([0, 0, 1, 1]))}


def checks(result: tc.Result) -> list[ck.Check]:
    """Check the general laws; plateau, shock speed and stretch against the jump conditions; no gain of energy."""
    scene, history = result.scene, result.history
    found = [ck.finished(result), ck.touched(result), ck.momentum_balance(result, 1e-8), ck.pushing(result)]
    if choices.is_exact(scene):
        found.append(ck.no_overlap(result))
    if not result.ok or not isinstance(scene.contact, tc.MasslessContact):
        return found
    shock, touch, force = exact(scene)
    n = choices.cells_of(scene.bodies[0].mesh)
    coarse = max(1.0, 80.0 / n)
    time, energy = history["time"], history["energy"]
    flat = (time - touch > 0.2 * (time[-1] - touch)) & (time - touch < 0.95 * (time[-1] - touch))
    mean = history["contact_force"][flat, 2].mean() / force
    levels, stretch = stretches(result)
    still = (levels > 0.1 * levels[-1]) & (levels < 0.7 * TRAVEL * levels[-1])
    touched = len(energy) // 10
    growth = (energy[touched:].max() - energy[touched]) / energy[0]
    found += [
        ck.energy(result, 3e-3 * coarse),
        ck.at_most("growth of the energy after the touch", growth, 1e-3),
        ck.between("plateau / jump conditions", mean, 0.99, 1.01),
        ck.between("shock speed / jump conditions", front(result) / (result.time - touch) / shock.shock_speed,
                   1.0 - 0.02 * coarse, 1.0 + 0.02 * coarse),
        ck.between("compression / jump conditions", (1.0 - stretch[still].mean()) / (1.0 - shock.stretch), 0.99, 1.01),
    ]  # fmt: skip
    return found


if __name__ == "__main__":
    from tcontact.commands.cli import main

    sys.exit(main(["run", "wall-shock", *sys.argv[1:]]))
