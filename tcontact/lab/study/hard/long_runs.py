"""Many impacts, many periods, many steps: what small errors add up to."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import tcontact as tc
from tcontact.cases import bouncing_bar

from ....results import checks as ck
from ....results.result import Result
from ....scene.contact_models import ContactModel
from ..hard_cases import HardCase, Run, worst
from ..problems import column
from .references import against

FIRST = 3  # contacts of the bar that are compared one by one


def cases() -> list[HardCase]:
    """Return the cases: long runs."""
    return [
        HardCase(
            "80-bounces",
            "a block is thrown down by a huge gravity 80 times; beside it the impulse method, which goes to sleep",
            lambda full: [
                Run(_bouncing(full, tc.MasslessContact()), tc.CentralDifference(cfl=0.4)),
                Run(_bouncing(full, tc.MasslessContact()), tc.CentralDifference(cfl=0.2)),
                Run(_bouncing(full, tc.ImpulseContact()), tc.CentralDifference(cfl=0.4)),
            ],
            _bounces,
        ),
        HardCase(
            "20-periods",
            "the bouncing bar through 20 periods at cfl 0.5: energy must stay",
            lambda full: [
                Run(_bar(80 if full else 20), tc.CentralDifference(cfl=0.5)),
            ],
            lambda results: [_energy_left(results[0]), ck.no_overlap(results[0]), *_on_time(results[0])],
        ),
        HardCase(
            "resting-under-gravity",
            "a bar rests on the wall in equilibrium: no drift and no energy, however many steps",
            lambda full: [_resting(1_000_000 if full else 2000)],
            _at_rest,
            cannot_feel={"duration": "it rests at any time"},
        ),
    ]


def _bouncing(full: bool, contact: ContactModel) -> tc.Scene:
    """Return a slab of 10 x 10 x 1 hexes, z held, .1 m, thrown down y at 10 km/h under 800 m/s^2; full: 80 bounces."""
    n = 10
    mesh = tc.box_mesh((0.1, 0.1, 0.01), (n, n, 1), origin=(0.0, 1e-3, 0.0))
    body = tc.Body(
        mesh,
        tc.NeoHookean(young=1e7, poisson=0.3, density=1000.0),
        velocity=(0.0, -10 / 3.6, 0.0),
        contact="ymin",
        supports=[tc.Support("zmin", "z"), tc.Support("zmax", "z")],
    )
    wall = tc.Plane(normal=(0.0, 1.0, 0.0))
    return tc.Scene([body], [wall], duration=0.16 if full else 0.012, gravity=(0.0, -800.0, 0.0), contact=contact)


def _bounces(results: list[Result]) -> list[ck.Check]:
    """Check energy against the kinetic energy of the start, the first contact, the last one, and the weight carried."""
    full = results[0].scene.duration > 0.1
    duration = 0.16 if full else 0.012
    fastest = np.sqrt((10 / 3.6) ** 2 + 2.0 * 800.0 * 1e-3)  # speed after the fall from the start
    change = []
    for result in results:
        energy = result.history["energy"]
        change.append(float(np.abs(energy - energy[0]).max()) / result.history["kinetic"][0])
    return [
        ck.at_most("energy error over m v^2/2, cfl 0.4", change[0], 3e-2),
        ck.at_most("energy error over m v^2/2, cfl 0.2", change[1], 8e-3),
        ck.at_least("loss of the impulse method over m v^2/2", change[2], 0.9 if full else 10.0 * change[0]),
        worst([ck.touched(result) for result in results]),
        worst([ck.no_overlap(result) for result in results[:2]]),
        worst([_weight(result, 0.1 * 800.0, fastest, duration) for result in results]),
        ck.at_least("last contact / duration", _last_contact(results[0]) / duration, 0.6),
        *against("80-bounces", results),
    ]


def _last_contact(result: Result) -> float:
    """Return the time of the last row with a contact force [s], 0 if there is none."""
    pressed = np.abs(result.history["contact_force"]).max(axis=1) > 0.0
    return float(result.history["time"][pressed].max(initial=0.0))


def _weight(result: Result, weight: float, fastest: float, duration: float) -> ck.Check:
    """Check that on the long run the wall carries the weight [N]: impulse less weight x duration, over 2 m v.

    fastest: v [m/s], of the fall from the start; the momentum stays within m v, with a quarter to spare.
    """
    axis = int(np.argmax(np.abs(result.scene.gravity)))
    carried = float(np.linalg.norm(result.history["impulse"][-1])) - weight * duration
    mass = weight / abs(result.scene.gravity[axis])
    return ck.at_most("impulse less weight x time over 2 m v", abs(carried) / (2.0 * mass * fastest), 1.25)


def _bar(cells: int) -> tc.Scene:
    """Return the bouncing bar: 8 contacts of 20 cells, 40 of 80 cells."""
    return bouncing_bar.scene(cells=cells, contacts=cells // 2 if cells > 20 else 8)


def _energy_left(result: Result) -> ck.Check:
    """Check the energy at the end over m g h, the energy of the drop."""
    energy = result.history["energy"]
    drop = ck.mass(result) * -result.scene.gravity[2] * result.scene.bodies[0].mesh.nodes[:, 2].min()
    return ck.at_least("energy left of the start", 1.0 + float((energy[-1] - energy[0]).min()) / drop, 0.95)


def _on_time(result: Result) -> list[ck.Check]:
    """Check the first contacts of the bar against d'Alembert's solution: their number, impulses and times.

    The bar forgets them: a small error of its vibration alters the next flight, and so on.
    """
    scene = _bar(result.scene.bodies[0].mesh.cell_count)
    speed, gravity, wave, begins = bouncing_bar.timing(scene)
    time, force = result.history["time"], result.history["contact_force"][:, 2]
    period = 2.0 * speed / gravity + wave
    fine = np.linspace(0.0, scene.duration, 20001)
    impulse, middle = bouncing_bar.bounces(time, result.history["impulse"][:, 2], scene)
    wanted, wanted_middle = bouncing_bar.bounces(fine, bouncing_bar.exact_impulse(fine, scene), scene)
    late = (middle - wanted_middle)[:FIRST] / period
    pressed = (force > 1e-6 * force.max()) & (time < begins[FIRST] - 0.5 * speed / gravity)
    return [
        ck.equals("contacts", bouncing_bar.touches(time, pressed, wave / 10.0), FIRST),
        ck.at_most("impulse of a bounce, error", np.abs(impulse / wanted - 1.0)[:FIRST].max(), 0.03),
        ck.at_most("time of a bounce, error in periods", np.abs(late).max(), 0.03),
        _weight(result, 10.0 * 10.0, 10.0 + wave * gravity, scene.duration),
    ]


def _resting(steps: int) -> Run:
    """Return a run of ten cells in static equilibrium: each cell carries the weight of the nodes above it."""
    cells, length = 10, 0.1
    mesh, material = column(cells, length, 1e7, 1000.0)
    body = tc.Body(mesh, material, contact="zmin")
    crossing = length / cells / material.wave_speed
    scene = tc.Scene([body], [tc.Plane()], duration=steps * 0.5 * crossing, gravity=(0.0, 0.0, -9.81))
    mass = tc.plan(scene).bodies[0].mass[:, 2, 2]
    level = np.round(mesh.nodes[:, 2] / length * cells).astype(int)
    weight = 9.81 * np.bincount(level, mass)
    area = float(np.prod(np.ptp(mesh.nodes[:, :2], axis=0)))
    above = np.cumsum(weight[::-1])[::-1][1:]  # weight on each cell
    sag = np.concatenate([[0.0], -np.cumsum(above) * length / cells / (material.young * area)])
    moved = np.zeros((mesh.node_count, 3))
    moved[:, 2] = sag[level]
    return Run(
        replace(scene, bodies=[replace(body, displacement=moved)]),
        tc.CentralDifference(dt=0.5 * crossing),
        history_every=100 if steps > 100_000 else 1,
    )


def _at_rest(results: list[Result]) -> list[ck.Check]:
    (result,) = results
    history, material = result.history, result.scene.bodies[0].material
    weight = ck.mass(result) * 9.81
    sag = material.density * 9.81 * 0.1**2 / (2.0 * material.young)
    moved = (result.position - result.scene.bodies[0].mesh.nodes)[:, 2].min()
    return [
        ck.at_most("largest kinetic / elastic energy", history["kinetic"].max() / history["elastic"][0], 1e-12),
        ck.at_most(
            "contact force against the weight", np.abs(history["contact_force"][:, 2] / weight - 1.0).max(), 1e-6
        ),
        ck.at_most("sag against its static value", abs(-moved / sag - 1.0), 0.02),
        ck.energy(result, 1e-9),
    ]
