"""An elastic ball strikes an equal one centrally, against the formulas of Hertz.

With 1/E* = sum of (1 - nu^2)/E, 1/R* = 2/R, 1/m* = 2/m and the approach d: F = 4/3 E* sqrt(R*) d^1.5, contact radius
a = sqrt(R* d). At a speed v well below that of waves d_max = (15 m* v^2 / (16 E* sqrt(R*)))^(2/5), contact lasts
2.94 d_max/v (Johnson, Contact Mechanics, chapters 4 and 11), and the balls exchange their velocities. The meshes are
turned against each other. Hertz takes each ball for a half-space and its surface for a paraboloid; a ball is stiffer by
a share of first order in a/R: with the linear law the largest force is 11 % above the formula at a/R = .25 on fine
meshes, 7 % at .13. With fewer than two faces across the contact radius, rows of the contact that begin take or give
some energy: .2 to .6 % at the default size, with the turn of the meshes, and a fifth of that with 12 cells.
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
from tcontact.scene.slaves import mean_area

AFTER = 1.3  # the run ends this long after the touch, in durations of the contact


@checked
def scene(
    *,
    cells: int = 8,
    lower_cells: int | None = None,
    kind: Literal["hex8", "tet4"] = "hex8",
    law: choices.Law = "linear",
    young: float = 1e7,
    stiffness: float = 1.0,
    poisson: float = 0.3,
    density: float = 1000.0,
    radius: float = 0.05,
    contact_radius: float = 0.25,
    turn: float = 30.0,
    removal: choices.Removal = "auto",
    tolerance: float | None = None,
) -> tc.Scene:
    """The upper ball, with `cells` faces along a quarter of its rim, falls on one of `lower_cells` (None: as many).

    SI units. The speed is the one that gives a contact of radius `contact_radius` times that of the balls by the
    formulas. stiffness: modulus of the upper ball over that of the lower one; turn: angle between the meshes about the
    vertical [degrees].
    """
    for name, count in (("cells", cells), ("lower_cells", lower_cells)):
        if count is not None and (isinstance(count, bool) or not isinstance(count, int) or count < 3):
            raise tc.InputError(name, count, "give a whole number of at least 3, an even one to meet at corners")
    if not 0.0 < contact_radius <= 0.3:
        raise tc.InputError("contact_radius", contact_radius, "give a share of the radius, above 0 and at most 0.3")
    choices.positive(young=young, stiffness=stiffness, density=density, radius=radius)
    laws = [choices.material(law, modulus, poisson, density) for modulus in (stiffness * young, young)]
    depth = 2.0 * contact_radius**2 * radius
    gap = _facet(radius, min(cells, lower_cells or cells)) ** 2 / (4.0 * radius)  # by which flat faces on balls err
    start = np.array((0.0, 0.0, radius + 0.5 * gap))
    above = tc.ball_mesh(radius, cells, kind).rotated(((0, 0, 1), np.radians(turn))).translated(start)
    below = tc.ball_mesh(radius, lower_cells or cells, kind).translated(-start)
    speed = np.sqrt(16.0 * _modulus(laws) * np.sqrt(radius / 2.0) * depth**2.5 / (15.0 * _mass(radius, density)))
    upper = tc.Body(above, laws[0], velocity=(0, 0, -speed), contact="low", name="upper")
    lower = tc.Body(below, laws[1], contact="high", name="lower")
    contact = tc.MasslessContact(removal, tolerance=tolerance)
    return tc.Scene([upper, lower], duration=(gap + AFTER * 2.94 * depth) / speed, contact=contact)


def _facet(radius: float, cells: int) -> float:
    """Return the size of a face of a ball [m]."""
    return np.pi / 2.0 * radius / cells


def _modulus(laws) -> float:
    """Return E* [Pa]."""
    return 1.0 / sum((1.0 - law.poisson**2) / law.young for law in laws)


def _mass(radius: float, density: float) -> float:
    """Return m*, half the mass of a ball [kg]."""
    return 2.0 / 3.0 * np.pi * radius**3 * density


def _radius(ball: tc.Body) -> float:
    """Return the radius of a ball [m]."""
    nodes = ball.mesh.nodes
    return float(np.linalg.norm(nodes - 0.5 * (nodes.min(axis=0) + nodes.max(axis=0)), axis=1).max())


def theory(scene: tc.Scene) -> tuple[float, float, float]:
    """Return the largest force [N], the largest approach [m] and the duration of the contact [s]."""
    upper, lower = scene.bodies
    radius, speed = _radius(upper), -float(upper.velocity[2])
    modulus, mass = _modulus((upper.material, lower.material)), _mass(radius, upper.material.density)
    depth = (15.0 * mass * speed**2 / (16.0 * modulus * np.sqrt(radius / 2.0))) ** 0.4
    return 4.0 / 3.0 * modulus * np.sqrt(radius / 2.0) * depth**1.5, depth, 2.94 * depth / speed


def curves(result: tc.Result) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return the force of Hertz, nearly sin(pi t/T)^1.5 (Johnson 11.4), to plot."""
    force, _, duration = theory(result.scene)
    touch = result.scene.duration - AFTER * duration
    times = np.linspace(0.0, result.scene.duration, 501)
    share = np.clip((times - touch) / duration, 0.0, 1.0)
    return {"Hertz, nearly": (times, force * np.sin(np.pi * share) ** 1.5)}


def checks(result: tc.Result) -> list[ck.Check]:
    """Check force, duration and impulse of the contact against Hertz, one touch without pull, and the ledger."""
    scene, history = result.scene, result.history
    upper = scene.bodies[0]
    most, depth, duration = theory(scene)
    radius = _radius(upper)
    share = np.sqrt(depth / (2.0 * radius))  # a/R
    size = max(np.sqrt(mean_area(body)) for body in scene.bodies)
    across = share * radius / size  # faces along the contact radius
    found = [
        ck.finished(result),
        ck.thrown(result),
        ck.momentum_balance(result, 1e-10),
        ck.energy(result, 4e-3 * max(1.0, 1.8 / across) ** 2),
        ck.pair_overlap(result, size, 1e-6),
    ]
    if not result.ok:
        return found
    time, force = history["time"], result.pair_force["upper-lower"][:, 2]
    closed = time[force > 1e-3 * most]
    lasted = np.ptp(closed) / duration if len(closed) else np.nan
    coarse = max(0.0, 1.2 / across - 1.0)
    # flat faces at the poles, of an odd number, touch later and part earlier
    late = sum(_radius(body) - 0.5 * float(np.ptp(body.mesh.nodes[:, 2])) for body in scene.bodies)
    least = 0.9 - 0.3 * coarse - 2.0 * late / (2.94 * depth)
    momentum = upper.mass * -upper.velocity[2]
    angular = np.linalg.norm(history["angular_momentum"] - history["angular_momentum"][0], axis=1).max()
    return [
        *found,
        ck.one_touch(result, "upper-lower"),
        ck.no_pull(result, "upper-lower", np.array((0.0, 0.0, 1.0))),
        ck.between(
            "largest force / Hertz",
            force.max() / most,
            1.0 + 0.2 * share - 0.5 * coarse,
            1.0 + 0.8 * share + 0.5 * coarse,
        ),
        ck.between("duration of the contact / Hertz", lasted, least, 1.05 + 0.3 * coarse),
        ck.at_most("impulse against m v, error", abs(np.trapezoid(force, time) / momentum - 1.0), 0.02),
        ck.at_most("change of the angular momentum / (m v R)", angular / (momentum * radius), 5e-3),
    ]


if __name__ == "__main__":
    from tcontact.commands.cli import main

    sys.exit(main(["run", "two-spheres", *sys.argv[1:]]))
