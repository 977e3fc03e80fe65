"""A seal is pressed between two planes, and a fluid presses on its side: an exact state of large deformation.

A block of rubber lies on a plane, beside a wall, between planes in the third direction. The plane above comes down by a
given share of its height; then the pressure of a fluid rises on the free side and pushes the seal against the wall.
Without friction the deformation is uniform: the forces of all planes are exact, and mass damping lets the seal come to
rest. The fluid pushes with p times the present height, however the side bends.
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
from tcontact.cases.inflated_ring import smooth
from tcontact.results import checks as ck
from tcontact.show import plots

PRESSED, FILLED = 0.4, 0.7  # shares of the duration at which the planes stand still, and the pressure is at its end


@checked
def scene(
    *,
    cells: int = 4,
    press: float = 0.2,
    pressure: float = 3e5,
    height: float = 0.01,
    young: float = 3e6,
    poisson: float = 0.4,
    density: float = 1100.0,
    periods: float = 20.0,
    kind: choices.Kind = "hex8",
) -> tc.Scene:
    """A seal as wide as high with `cells` cells along both is pressed by a share of its height, then by the fluid.

    SI units. press: share of the height; pressure: of the fluid; periods: duration in 2 height over the speed of waves
    in a bar of the material.
    """
    choices.positive(cells=cells, height=height, young=young, density=density, periods=periods)
    if not 0.0 < press < 1.0:
        raise tc.InputError("press", press, "must be between 0 and 1")
    law = tc.NeoHookean(young, poisson, density)
    mesh = tc.box_mesh((height, height / cells, height), (cells, 1, cells), kind)
    mesh = mesh.with_sets(node_sets={"all": np.arange(mesh.node_count)})
    speed = np.sqrt(young / density)
    duration = periods * 2.0 * height / speed
    fast = press * height / (PRESSED * duration)

    def down(t: float) -> tuple[float, float, float]:
        share = min(t / (PRESSED * duration), 1.0)
        return (0.0, 0.0, -30.0 * fast * share**2 * (1.0 - share) ** 2)  # the slope of `smooth`

    def fluid(t: float) -> float:
        return pressure * smooth((t / duration - PRESSED) / (FILLED - PRESSED))

    seal = tc.Body(
        mesh,
        law,
        contact=["zmin", "zmax", "xmax"],
        supports=[tc.Support("all", "y")],
        loads=[tc.Load("xmin", pressure=fluid)],
        name="seal",
    )
    planes = [
        tc.Plane(name="floor"),
        tc.Plane((0.0, 0.0, height), (0.0, 0.0, -1.0), name="lid", velocity=down),
        tc.Plane((height, 0.0, 0.0), (-1.0, 0.0, 0.0), name="wall"),
    ]
    damping = tc.MassDamping(2.0 * speed / height)
    return tc.Scene([seal], planes, duration=duration, contact=tc.MasslessContact("full"), damping=damping)


def exact(scene: tc.Scene) -> tuple[float, np.ndarray]:
    """Return the height [m] at the end, and the forces [N] of the seal on floor (down), lid (up) and wall (across).

    Uniform stretches: 1 along y, c = 1 - press along z, and along x such that the stress there is minus the pressure.
    """
    body = scene.bodies[0]
    law, mesh = body.material, body.mesh
    width, depth, height = np.ptp(mesh.nodes, axis=0)
    times = scene.duration * (np.arange(2000) + 0.5) / 2000
    moved = np.mean([scene.obstacles[1].velocity(t)[2] for t in times]) * scene.duration
    c = 1.0 + moved / height
    fluid = body.loads[0].value(scene.duration)
    mu, lam = law.lame_mu, law.lame_lambda

    def stress(along, a):  # Cauchy stress along an axis of stretch `along`
        return mu * (along**2 - 1.0) / (a * c) + lam * (a * c - 1.0)

    low, high = 0.01, 100.0
    for _ in range(100):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if stress(middle, middle) < -fluid else (low, middle)
    plate = -stress(c, low) * low * width * depth
    return c * height, np.array([plate, plate, fluid * c * height * depth])


def draw(result: tc.Result, folder: Path, title: str) -> None:
    """Draw the forces on the planes and that of the fluid."""
    history = result.history
    force = {name: (history["time"], np.linalg.norm(result.obstacle_force[name], axis=1)) for name in PLANES}
    force["fluid"] = history["time"], history["applied_force"][:, 0]
    plots.panels(folder / "forces.png", {("force", "N"): force}, title)


PLANES = ("floor", "lid", "wall")


def checks(result: tc.Result) -> list[ck.Check]:
    """Check the forces on all planes and of the fluid against the exact ones, their balance, and the ledger."""
    found = [ck.finished(result), ck.energy(result, 1e-2), ck.momentum_balance(result, 1e-10)]
    if not result.ok:
        return found
    history = result.history
    height, wanted = exact(result.scene)
    forces = np.array([result.obstacle_force[name][-1] for name in PLANES])
    fluid = history["applied_force"][-1]
    pushed = (-forces[0, 2], forces[1, 2], forces[2, 0])
    scale = np.abs(forces).max()
    return [
        *found,
        *(ck.between(f"force on the {name} / exact", force / right, 0.999, 1.001)
          for name, force, right in zip(PLANES, pushed, wanted, strict=True)),
        ck.at_most("force of the fluid / (p x height x depth), error", abs(fluid[0] / wanted[2] - 1.0), 1e-6),
        ck.at_most("forces out of balance / largest", np.abs(fluid - forces.sum(axis=0)).max() / scale, 1e-4),
        ck.at_most("height / exact, error", abs(np.ptp(result.position[:, 2]) / height - 1.0), 1e-6),
    ]  # fmt: skip


if __name__ == "__main__":
    from tcontact.commands.cli import main

    sys.exit(main(["run", "pressed-seal", *sys.argv[1:]]))
