"""Steel balls are thrown at a rigid plane at several speeds: how much of the speed they keep.

An elastic ball keeps all but a small share of its speed, in waves. One that yields keeps less, the less the faster:
Johnson (Contact Mechanics, 11.5) has e = 3.8 (Y/E*)^(1/2) (m v^2/(2 Y R^3))^(-1/8), E* = E/(1 - nu^2), for shallow
indents under a constant mean pressure of 3 Y; deeper ones lose more, up to e ~ v^(-1/2). The steel does not harden.
At 10, 20, 40 m/s, contact radii of .19, .27, .39 radii, e is .30, .23, .15, and the formula has .37, .31, .26: at 40
m/s the ball loses more than the check allows (`--set speed=20`), on meshes of 700 to 4600 cells alike.
A quarter of each ball is computed, with planes of symmetry; the balls stand side by side and do not touch each other.
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
from tcontact.cases import _round_meshes as meshes
from tcontact.cases._inputs import checked
from tcontact.results import checks as ck

SMALLEST = 1e-3  # contact radius over that of the ball, below which the mesh would have too many cells


@checked
def scene(
    *,
    cells: int = 3,
    young: float = 200e9,
    poisson: float = 0.3,
    density: float = 7850.0,
    yield_stress: float = 500e6,
    hardening: float = 0.0,
    radius: float = 5e-3,
    speed: float = 10.0,
    balls: int = 3,
    formulation: Literal["mean-dilatation", "reduced"] = "mean-dilatation",
    removal: choices.Removal = "normal",
    tolerance: float | None = None,
) -> tc.Scene:
    """An elastic ball at half the speed, and `balls` of steel at speed, 2 speed, 3 speed just touch the plane.

    SI units. cells: across the contact radius of the slowest ball of steel; hardening: modulus of its linear hardening.
    """
    if isinstance(cells, bool) or not isinstance(cells, int) or cells < 2:
        raise tc.InputError("cells", cells, "give a whole number of at least 2")
    if isinstance(balls, bool) or not isinstance(balls, int) or not 1 <= balls <= 3:
        raise tc.InputError("balls", balls, "give a whole number from 1 to 3")
    choices.positive(young=young, density=density, yield_stress=yield_stress, radius=radius, speed=speed)
    steel = tc.ElastoPlastic(young, poisson, density, tc.LinearHardening(yield_stress, hardening))
    # a mean pressure of 3 Y stops the ball at the contact radius a: m v^2/2 = 3 Y pi a^4/(4 R)
    contact = (8.0 / 9.0 * density * speed**2 / yield_stress) ** 0.25 * radius
    largest = contact * balls**0.5
    if largest > 0.5 * radius:
        raise tc.InputError("speed", speed, "the ball would be crushed: its contact radius exceeds half its own")
    if contact < SMALLEST * radius:
        remedy = f"the contact radius would be below {SMALLEST:g} of that of the ball; give a larger speed"
        raise tc.InputError("speed", speed, remedy)
    mesh = meshes.quarter_ball(
        radius, contact / cells, round(1.2 * cells * largest / contact), cap=0.2 + largest / radius
    )
    bodies = []
    for number in range(balls + 1):
        speed_of = speed * (number or 0.5)
        material = steel if number else tc.NeoHookean(young, poisson, density)
        place = mesh.nodes + np.array([3.0 * number * radius, 0.0, radius])
        bodies.append(
            tc.Body(
                tc.Mesh(place, mesh.cells, "hex8", face_sets=mesh.face_sets),
                material,
                velocity=(0.0, 0.0, -speed_of),
                contact="cap",
                supports=[tc.Support("xmin", "x"), tc.Support("ymin", "y")],
                formulation=formulation if number else "full",
                name=f"{speed_of:g} m/s" + ("" if number else ", elastic"),
            )
        )
    mass = 4.0 / 3.0 * np.pi * radius**3 * density
    depth = (15.0 * mass * (0.5 * speed) ** 2 / (16.0 * young / (1.0 - poisson**2) * np.sqrt(radius))) ** 0.4
    lasts = max(2.94 * depth / (0.5 * speed), 2.2 * np.sqrt(mass / (6.0 * np.pi * radius * yield_stress)))
    model = tc.MasslessContact(removal=removal, tolerance=tolerance)
    return tc.Scene(bodies, [tc.Plane()], duration=1.3 * lasts, contact=model)


def restitution(result: tc.Result) -> np.ndarray:
    """Return the share of its speed that every ball keeps."""
    kept = []
    for plan in tc.plan(result.scene).bodies:
        mass, velocity = plan.mass, result.velocity[result.nodes_of(plan.label)]
        kept.append(np.einsum("nij,nj->i", mass, velocity)[2] / (plan.body.mass * -plan.body.velocity[2]))
    return np.array(kept)


def johnson(scene: tc.Scene) -> np.ndarray:
    """Return the restitution of the balls of steel after Johnson."""
    steel = scene.bodies[1].material
    speed = np.array([-float(body.velocity[2]) for body in scene.bodies[1:]])
    yields = steel.hardening.yield_stress
    energy = 4.0 / 3.0 * np.pi * steel.density * speed**2 / (2.0 * yields)
    return np.asarray(3.8 * np.sqrt(yields * (1.0 - steel.poisson**2) / steel.young) * energy**-0.125)


def checks(result: tc.Result) -> list[ck.Check]:
    """Check the ledger, that the restitution falls with the speed, and how far it is below that of Johnson."""
    tolerance = result.scene.contact.tolerance or 1e-4
    found = [
        ck.finished(result),
        ck.thrown(result),
        ck.touched(result),
        ck.pushing(result),
        ck.no_overlap(result),
        ck.energy(result, 1e-3),
        ck.equals("static solves not converged", int((result.history["static_residual"] > tolerance).sum()), 0),
    ]
    if not result.ok:
        return found
    kept = restitution(result)
    found.append(ck.between("restitution, elastic", kept[0], 0.99, 1.0))
    found += [
        ck.at_most(f"restitution at {body.name} / slower", ratio, 1.0)
        for body, ratio in zip(result.scene.bodies[1:], kept[1:] / kept[:-1], strict=True)
    ]
    if result.scene.bodies[1].material.hardening.modulus == 0.0:
        for body, share in zip(result.scene.bodies[1:], kept[1:] / johnson(result.scene), strict=True):
            found.append(ck.between(f"restitution at {body.name} / Johnson", share, 0.6, 1.0))
    return found


if __name__ == "__main__":
    from tcontact.commands.cli import main

    sys.exit(main(["run", "ball-drop", *sys.argv[1:]]))
