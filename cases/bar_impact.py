"""A bar with poisson 0 hits a wall: an impact with an exact solution.

A square bar along z, moving at `speed` towards the plane z = 0, touches it after gap/speed. With poisson 0 and the
linear law the motion is one-dimensional: the wall is pushed with rho c speed A (c = sqrt(young/density)) for the time
2 length/c in which the wave runs up and down the bar, then the bar leaves free of stress at the speed it came with.
Every check but the general ones compares with that; the two jumps of the force, around which any discrete wave rings,
are judged through averages. Impulse and mean time of the force must be right with other laws and contacts too, as far
as large strain and a wall that yields leave them (`tcontact.results.exact.PenaltyWall`).
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
from tcontact.results.exact import PenaltyWall


@checked
def scene(
    *,
    cells: int = 160,
    kind: choices.Kind = "hex8",
    formulation: choices.Formulation = "full",
    law: choices.Law = "linear",
    young: float = 1e7,
    density: float = 1000.0,
    length: float = 0.1,
    width: float | None = None,
    speed: float = 10 / 3.6,
    gap: float = 2e-4,
    contact: choices.Contact = "massless",
    removal: choices.Removal = "auto",
    penalty: float | None = None,
    depth: int = 1,
    sweeps: int = 10,
    tolerance: float | None = None,
    duration: float | None = None,
) -> tc.Scene:
    """A square bar with all its `cells` cells along its length flies down from `gap` above the plane z = 0.

    SI units. formulation: full | reduced (one-point hexes) | mean-dilatation (one volume change per hex); width: of the
    bar and its cells, None = length/8; penalty: None = exact, else multiples of young/h (contact=penalty: None = 10);
    duration: None = until a quarter of the contact time after the bar has left.
    """
    material = choices.material(law, young, 0.0, density)
    choices.positive(length=length, speed=speed, width=width, cells=cells)
    choices.not_negative(gap=gap)
    h = length / cells
    side = length / 8.0 if width is None else width
    mesh = tc.box_mesh(size=(side, side, length), cells=(1, 1, cells), kind=kind, origin=(-side / 2, -side / 2, gap))
    model = choices.contact_model(
        contact, removal=removal, penalty=penalty, unit=young / h, depth=depth, sweeps=sweeps, tolerance=tolerance
    )
    if duration is None:
        duration = gap / speed + 2.5 * length / material.wave_speed
    velocity = (0.0, 0.0, -speed)
    bar = tc.Body(mesh, material, velocity, contact="zmin", name="bar", formulation=formulation)
    return tc.Scene(bodies=[bar], obstacles=[tc.Plane()], duration=duration, contact=model)


def times_and_force(scene: tc.Scene) -> tuple[float, float, float]:
    """Return the exact time of touch [s], time of release [s] and contact force between them [N]."""
    body = scene.bodies[0]
    size, speed = np.ptp(body.mesh.nodes, axis=0), -body.velocity[2]
    touch = scene.obstacles[0].gap(body.mesh.nodes).min() / speed
    c = body.material.wave_speed
    return touch, touch + 2.0 * size[2] / c, body.material.density * c * speed * size[0] * size[1]


def exact_force(times: np.ndarray, dt: float, scene: tc.Scene) -> np.ndarray:
    """Return the exact contact force [N] averaged over [t - dt/2, t + dt/2] at each of the times [s]."""
    touch, release, force = times_and_force(scene)
    overlap = np.minimum(times + dt / 2, release) - np.maximum(times - dt / 2, touch)
    return force * np.clip(overlap / dt, 0.0, 1.0)


def curves(result: tc.Result) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return the exact contact force of the linear bar, to plot."""
    touch, release, force = times_and_force(result.scene)
    end = result.scene.duration
    return {
        "exact (linear)": (np.array([0, touch, touch, release, release, end]), force * np.array([0, 0, 1, 1, 0, 0]))
    }


def pulse(result: tc.Result) -> list[ck.Check]:
    """Check impulse and mean time of the force, for any law and contact, by a linear bar and a wall that may yield.

    Large strain alters the wave speed by a share of speed/c.
    """
    scene, history = result.scene, result.history
    body = scene.bodies[0]
    touch, release, force = times_and_force(scene)
    stiffness = getattr(scene.contact, "stiffness", None) or getattr(scene.contact, "penalty", None)
    impulse, middle = force * (release - touch), 0.5 * (release - touch)
    if stiffness is not None:
        size = np.ptp(body.mesh.nodes, axis=0)
        wall = PenaltyWall(
            size[2], size[0] * size[1], body.material.young, body.material.density, -body.velocity[2], stiffness
        )
        if wall.rate * wall.crossing > 1.7:
            times = np.linspace(0.0, wall.contact_time, 2001)
            impulse, middle = float(wall.impulse(wall.contact_time)), ck.mean_time(times, wall.impulse(times))
    bound = 0.01 * np.sqrt(max(1.0, 160.0 / choices.cells_of(body.mesh)))
    bound *= 2.0 if isinstance(scene.contact, tc.ImpulseContact) else 1.0  # which loses what the struck nodes carry
    bound += 0.0 if body.material.linear else -body.velocity[2] / body.material.wave_speed
    bound += 0.06 if isinstance(scene.contact, tc.PenaltyContact) else 0.0  # which gains energy near its limit
    later = ck.mean_time(history["time"], history["impulse"][:, 2]) - touch
    return [
        ck.at_most("impulse, error", abs(history["impulse"][-1, 2] / impulse - 1.0), bound),
        ck.at_most("mean time of the force after the touch, error", abs(later / middle - 1.0), bound),
    ]


def checks(result: tc.Result) -> list[ck.Check]:
    """Check the general laws, and the exact solution where it holds (linear law, exact constraint, one layer deep)."""
    scene, history = result.scene, result.history
    body, n = scene.bodies[0], choices.cells_of(scene.bodies[0].mesh)
    coarse = max(1.0, 160.0 / n)
    normal = isinstance(scene.contact, tc.MasslessContact) and scene.contact.removal != "full"
    found = [ck.finished(result), ck.touched(result)]
    found += [ck.momentum_balance(result, 1e-8 if n >= 40 and normal else 1e-4), ck.pushing(result)]
    if isinstance(scene.contact, tc.MasslessContact):
        found.append(ck.energy(result, (2e-3 if scene.contact.penalty is None else 3e-3) * coarse))
    touch, release, plateau = times_and_force(scene)
    whole = result.ok and scene.duration >= release + 0.1 * (release - touch)
    plane = abs(body.material.poisson) < 1e-9  # a bar that bulges is no longer one-dimensional
    if whole and plane and isinstance(result.scheme, tc.CentralDifference):  # implicit steps may miss the waves
        found += pulse(result)
    if not choices.is_exact(scene):
        return found
    found.append(ck.no_overlap(result))
    if not (whole and body.material.linear and scene.contact.depth == 1):
        return found

    time, force = history["time"], history["contact_force"][:, 2]
    wanted = exact_force(time, result.dt, scene)
    impulse = plateau * np.clip(time - touch, 0.0, release - touch)
    middle = (time > touch + 0.1 * (release - touch)) & (time < touch + 0.9 * (release - touch))
    courant = body.material.wave_speed * result.dt * n / np.ptp(body.mesh.nodes[:, 2])
    slow = 1.0 if courant > 0.85 else 1.5  # smaller steps ring more: the front is wider
    rms = np.sqrt(np.mean((force[middle] / plateau - 1.0) ** 2))
    rebound = history["momentum"][-1, 2] / (ck.mass(result) * -body.velocity[2])
    error = np.linalg.norm(force - wanted) / np.linalg.norm(wanted)
    found += [
        ck.at_most("force, relative L2 error", error, 0.05 * slow * np.sqrt(coarse)),
        ck.at_most(
            "running impulse error", abs(history["impulse"][:, 2] - impulse).max() / impulse[-1], 4e-3 * slow * coarse
        ),
        ck.at_most("sum |dF| / (2 rho c v A)", abs(np.diff(force)).sum() / (2 * plateau), 1.5 if n >= 100 else 1.6),
        ck.equals("releases", np.sum((force[:-1] > 1e-6 * plateau) & (force[1:] <= 1e-6 * plateau)), 1),
        ck.between("rebound / speed", rebound, 1.0 - 0.01 * slow * coarse, 1.001 + 0.02 * (coarse - 1.0) / 3),
    ]
    if n >= 100:
        found.append(ck.at_most("plateau rms", rms, 2e-4 if body.mesh.kind == "hex8" else 2e-3))
    return found


if __name__ == "__main__":
    from tcontact.commands.cli import main

    sys.exit(main(["run", "bar-impact", *sys.argv[1:]]))
