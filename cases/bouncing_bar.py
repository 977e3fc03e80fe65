"""A bar bounces under gravity, again and again: an exact periodic motion.

A bar (poisson 0, linear law, length L, wave speed c) is dropped from the height v^2/2g that makes its flights last
`flight` wave periods T = 2L/c: v = flight g L/c at touch. This is the benchmark of Doyen, Ern and Piperno (SIAM J. Sci.
Comput. 33, 2011), there with flight = 3. By d'Alembert's solution, with s the time since touch:

    odd contacts   F = rho c A (v + g s),        0 < s < T: arrives free of strain, leaves with twice its static sag
    even contacts  F = rho c A (v + g T - g s),  0 < s < T: has vibrated with period T, arrives sagged, leaves free

Contact j (from 0) begins at v/g + j (flight + 1) T; flight >= 3 keeps the vibrating bar clear of the floor between.
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


@checked
def scene(
    *,
    cells: int = 80,
    contacts: int = 4,
    flight: int = 3,
    kind: choices.Kind = "hex8",
    young: float = 900.0,
    density: float = 1.0,
    length: float = 10.0,
    width: float | None = None,
    gravity: float = 10.0,
    removal: choices.Removal = "auto",
    depth: int = 1,
    sweeps: int = 10,
    tolerance: float | None = None,
) -> tc.Scene:
    """A bar with all its `cells` cells along its length is dropped; the run ends half a flight after the last contact.

    SI units. width: of the bar and its cells, None = length/10; contacts: how many bounces; flight: free flight between
    them in wave periods 2 length/c, 3 or more.
    """
    for name, value, low in (("cells", cells, 1), ("contacts", contacts, 1), ("flight", flight, 3)):
        if isinstance(value, bool) or not isinstance(value, int) or value < low:
            raise tc.InputError(name, value, f"give a whole number of at least {low}")
    choices.positive(length=length, gravity=gravity, width=width)
    material = choices.material("linear", young, 0.0, density)
    speed, wave = flight * gravity * length / material.wave_speed, 2.0 * length / material.wave_speed
    side, height = length / 10.0 if width is None else width, speed**2 / (2.0 * gravity)
    mesh = tc.box_mesh(size=(side, side, length), cells=(1, 1, cells), kind=kind, origin=(-side / 2, -side / 2, height))
    bar = tc.Body(mesh, material, contact="zmin", name="bar")
    model = tc.MasslessContact(removal=removal, depth=depth, sweeps=sweeps, tolerance=tolerance)
    duration = speed / gravity + ((contacts - 1) * (flight + 1) + 1 + flight / 2) * wave
    return tc.Scene(bodies=[bar], obstacles=[tc.Plane()], duration=duration, gravity=(0, 0, -gravity), contact=model)


def timing(scene: tc.Scene) -> tuple[float, float, float, np.ndarray]:
    """Return the exact speed at touch [m/s], gravity [m/s^2], contact time T [s] and beginnings of the contacts [s]."""
    body, gravity = scene.bodies[0], -scene.gravity[2]
    length = np.ptp(body.mesh.nodes[:, 2])
    speed = np.sqrt(2.0 * gravity * scene.obstacles[0].gap(body.mesh.nodes).min())
    wave = 2.0 * length / body.material.wave_speed
    period = 2.0 * speed / gravity + wave
    return speed, gravity, wave, np.arange(speed / gravity, scene.duration, period)


def exact_impulse(times: np.ndarray, scene: tc.Scene) -> np.ndarray:
    """Return the exact running impulse of the contact force [N s] at each of the times [s]."""
    speed, gravity, wave, begins = timing(scene)
    body = scene.bodies[0]
    area = np.prod(np.ptp(body.mesh.nodes[:, :2], axis=0))
    result = np.zeros_like(times, dtype=float)
    for j, begin in enumerate(begins):
        s = np.clip(times - begin, 0.0, wave)
        result += speed * s + gravity * s**2 / 2 if j % 2 == 0 else (speed + gravity * wave) * s - gravity * s**2 / 2
    return body.material.density * body.material.wave_speed * area * result


def exact_force(times: np.ndarray, dt: float, scene: tc.Scene) -> np.ndarray:
    """Return the exact contact force [N] averaged over [t - dt/2, t + dt/2] at each of the times [s]."""
    return (exact_impulse(times + dt / 2, scene) - exact_impulse(times - dt / 2, scene)) / dt


def curves(result: tc.Result) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return the exact contact force, to plot."""
    times = np.linspace(0.0, result.scene.duration, 20001)
    return {"exact": (times, exact_force(times, times[1], result.scene))}


def bounces(time: np.ndarray, impulse: np.ndarray, scene: tc.Scene) -> tuple[np.ndarray, np.ndarray]:
    """Return impulse [N s] and mean time [s] of every bounce: what a running impulse gains from flight to flight."""
    speed, gravity, wave, begins = timing(scene)
    limits = np.append(0.0, begins + wave + speed / gravity)
    given = np.diff(impulse)
    moment = np.append(0.0, np.cumsum(given * (time[1:] + time[:-1]) / 2.0))
    total = np.diff(np.interp(limits, time, impulse))
    with np.errstate(invalid="ignore", divide="ignore"):
        return total, np.diff(np.interp(limits, time, moment)) / total


def touches(time: np.ndarray, closed: np.ndarray, flutter: float) -> int:
    """Count how often contact begins; one that opens for less than `flutter` [s] is not over."""
    begins, ends = (np.flatnonzero(np.diff(closed.astype(int), prepend=0, append=0) == way) for way in (1, -1))
    return len(begins) - int(np.sum(time[begins[1:]] - time[ends[:-1] - 1] < flutter))


def checks(result: tc.Result) -> list[ck.Check]:
    """Check the number of bounces, that no bounce gains energy, and impulse and time of every bounce."""
    scene, history = result.scene, result.history
    speed, gravity, wave, begins = timing(scene)
    n = choices.cells_of(scene.bodies[0].mesh)
    coarse = max(1.0, 80.0 / n)
    massless = isinstance(scene.contact, tc.MasslessContact)
    balance = 1e-8 if n >= 40 and massless and scene.contact.removal != "full" else 1e-4
    found = [ck.finished(result), ck.touched(result), ck.momentum_balance(result, balance)]
    found += [ck.pushing(result), ck.no_overlap(result)]
    found.append(ck.energy(result, (2e-3 if result.dt <= 0.55 * result.dt_limit else 5e-3) * coarse))
    if not (result.ok and massless and scene.contact.depth == 1 and len(begins)):
        return found
    time, force = history["time"], history["contact_force"][:, 2]
    floor = 1e-6 * exact_force(np.array([begins[0] + wave / 2]), wave, scene)[0]
    impulse, middle = bounces(time, history["impulse"][:, 2], scene)
    fine = np.linspace(0.0, max(scene.duration, time[-1]), 20001)
    wanted, wanted_middle = bounces(fine, exact_impulse(fine, scene), scene)
    late = (middle - wanted_middle) / (2.0 * speed / gravity + wave)
    many = max(1.0, len(begins) / 4.0)  # errors of time add up
    half = len(time) // 2
    growth = (history["energy"][half:].max() - history["energy"][:half].max()) / np.ptp(history["kinetic"])
    found += [
        ck.equals("contacts", touches(time, force > floor, wave / 10.0), len(begins)),
        ck.at_most("impulse of a bounce, error", np.abs(impulse / wanted - 1.0).max(), 0.02 * coarse * many),
        ck.at_most("growth of energy, second half", growth, 4e-3 * coarse),
    ]
    if isinstance(result.scheme, tc.CentralDifference):  # implicit steps may miss the waves
        bound, first = 0.03 * max(1.0, coarse / 4.0), np.abs(late)[:2].max()  # later ones carry on its errors
        found.append(ck.at_most("time of the first bounces, error / period", first, bound))
    return found


if __name__ == "__main__":
    from tcontact.commands.cli import main

    sys.exit(main(["run", "bouncing-bar", *sys.argv[1:]]))
