"""A rigid striker, a ball or a block of its own mass, falls on a block of rubber and bounces.

The ball (or block) is an obstacle that moves freely: contact forces and gravity act on it, and its energy and momentum
stand in the ledger. The rubber is held at its bottom. A block that covers the whole top of rubber with poisson 0 sends
a plane wave into it: until the wave comes back its speed is exactly v exp(-rho c A t/M), c^2 = young/rho.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Literal

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import numpy as np

import tcontact as tc
from tcontact.cases import _choices as choices
from tcontact.cases._inputs import checked
from tcontact.results import checks as ck

SIZE = (0.1, 0.1, 0.05)  # of the rubber [m]


@checked
def scene(
    *,
    striker: Literal["ball", "box"] = "ball",
    cells: int = 8,
    law: choices.Law = "neo-hookean",
    young: float = 5e6,
    poisson: float = 0.4,
    density: float = 1100.0,
    mass: float = 0.5,
    speed: float = 2.0,
    friction: float = 0.0,
    removal: choices.Removal = "auto",
    duration: float | None = None,
) -> tc.Scene:
    """The striker just touches the middle of the rubber; SI units.

    cells: along the longest edge of the rubber, and twice as many layers under a block; mass: of the striker; friction:
    coefficient, 0 = none; duration: None = until a ball has left, or until the wave under a block has come back twice.
    """
    if isinstance(cells, bool) or not isinstance(cells, int) or cells < 2:
        raise tc.InputError("cells", cells, "give a whole number of at least 2")
    choices.positive(young=young, density=density, mass=mass, speed=speed, duration=duration)
    choices.not_negative(friction=friction)
    length, width, height = SIZE
    layers = max(2, cells // 2) if striker == "ball" else 2 * cells
    mesh = tc.box_mesh(SIZE, (cells, cells, layers))
    material = choices.material(law, young, poisson, density)
    rubber = tc.Body(mesh, material, contact="zmax", supports=[tc.Support("zmin", "xyz")], name="rubber")
    middle = np.array([0.5 * length, 0.5 * width, height])
    velocity = (0.0, 0.0, -speed)
    obstacle: tc.Sphere | tc.Box
    if striker == "ball":
        obstacle = tc.Sphere(middle + np.array([0.0, 0.0, 0.03]), 0.03, mass=mass, velocity=velocity, name="striker")
        plane = young / (1.0 - poisson**2)
        hertz = 2.94 * (15.0 * mass / (16.0 * plane * np.sqrt(0.03))) ** 0.4 / speed**0.2  # on a half-space
        lasts = 1.3 * hertz
    elif striker == "box":
        size = np.array([1.2 * length, 1.2 * width, height])
        obstacle = tc.Box(
            middle + np.array([0.0, 0.0, 0.5 * height]), size, mass=mass, velocity=velocity, name="striker"
        )
        lasts = 4.0 * height / material.wave_speed
    else:
        raise tc.InputError("striker", striker, "use one of ball, box")
    return tc.Scene(
        bodies=[rubber],
        obstacles=[obstacle],
        duration=lasts if duration is None else duration,
        gravity=(0.0, 0.0, -9.81),
        contact=tc.MasslessContact(removal),
        friction=tc.Coulomb(friction) if friction else None,
    )


def exact_speed(scene: tc.Scene, time: np.ndarray) -> np.ndarray:
    """Return the speed [m/s] of a block on rubber with poisson 0, until the wave comes back; NaN from then on.

    M dv/dt = M g - rho c A (v - 0), as the rubber under it moves at its speed.
    """
    material, striker = scene.bodies[0].material, scene.obstacles[0]
    rate = material.density * material.wave_speed * SIZE[0] * SIZE[1] / striker.mass
    pull = -float(scene.gravity[2]) / rate
    fall = pull + (-float(striker.velocity[2]) - pull) * np.exp(-rate * time)
    return np.where(time < 1.9 * SIZE[2] / material.wave_speed, fall, np.nan)


def checks(result: tc.Result) -> list[ck.Check]:
    """Check the ledger, and the speed of the striker: of a block by the exact wave, of a ball by its bounce.

    The first layer of cells delays the wave: the error of the speed is of first order, about half of the mass of a
    layer over that of the block.
    """
    found = [ck.finished(result), ck.touched(result), ck.momentum_balance(result, 1e-10), ck.energy(result, 5e-3)]
    if not result.ok:
        return found
    history, striker = result.history, result.scene.obstacles[0]
    speed = -history["obstacle_velocity:striker"][:, 2]
    weight = striker.mass * -result.scene.gravity[2]
    given = striker.mass * (speed[0] - speed) + weight * history["time"]
    error = np.abs(given - history["rigid_impulse"][:, 2]).max() / np.abs(given).max()
    found.append(ck.at_most("impulse = change of momentum of the striker", error, 1e-10))
    if isinstance(striker, tc.Sphere):
        found.append(ck.between("speed kept by the striker", -speed[-1] / speed[0], 0.5, 1.0))
    elif result.scene.bodies[0].material.poisson == 0.0:
        exact = exact_speed(result.scene, history["time"])
        error = np.nanmax(np.abs(speed - exact)) / speed[0]
        body = result.scene.bodies[0]
        layer = body.mass * np.diff(np.unique(body.mesh.nodes[:, 2])).max() / SIZE[2]
        found.append(ck.at_most("speed of the block - exact / first", error, 0.6 * layer / striker.mass))
    return found


if __name__ == "__main__":
    from tcontact.commands.cli import main

    sys.exit(main(["run", "striker", *sys.argv[1:]]))
