"""Starts and near misses: touching, a little inside, contact on a step, flights that never touch."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import tcontact as tc
from tcontact.cases import bar_impact

from ....results import checks as ck
from ....results.result import Result
from ..hard_cases import HardCase, Run, nothing, sound, worst
from ..problems import column
from .references import against_plane_wave

CELLS = {False: 20, True: 160}


def cases() -> list[HardCase]:
    """Return the cases: starts and near misses."""
    return [
        HardCase(
            "start-touching",
            "the first step begins at gap 0",
            lambda full: [Run(_bar(full, 0.0))],
            lambda results: [
                _impulse(results[0]),
                *against_plane_wave(results, 0.0),
                *sound(results, energy=_energy(results[0])),
            ],
        ),
        HardCase(
            "start-inside",
            "1e-12 m inside the wall: closed by the first static solve",
            lambda full: [Run(_bar(full, -1e-12)), Run(_bar(full, 0.0))],
            lambda results: [
                _same(results, 1e-6),
                *against_plane_wave(results, 0.0),
                *sound(results, energy=_energy(results[0])),
            ],
        ),
        HardCase(
            "start-deep-inside",
            "a tenth of a cell inside: there is no right answer",
            lambda full: [Run(_bar(full, -0.1 * 0.1 / CELLS[full]))],
            lambda results: [],
            expected=("refused",),
            says="move the body or the obstacle apart",
            remedy="move the body or the obstacle apart",
            cannot_feel=nothing("the scene is refused where it is made, before anything runs"),
        ),
        HardCase(
            "contact-on-a-step",
            "the gap closes exactly at a step, or a rounding before or after it",
            lambda full: [
                Run(_bar(full, gap), tc.CentralDifference(dt=_step(CELLS[full]))) for gap in _on_step(CELLS[full])
            ],
            lambda results: [
                _same(results, 1e-6),
                *against_plane_wave(results, *_on_step(results[0].scene.bodies[0].mesh.cell_count)),
                *sound(results, energy=_energy(results[0])),
            ],
        ),
        HardCase(
            "grazing-flight",
            "a block slides along the wall at gap 0 without pressing: nothing may happen",
            lambda full: [Run(_grazing(full, kind)) for kind in ("normal", "full")],
            lambda results: [_straight(result) for result in results] + [_untouched(r) for r in results],
            cannot_feel=nothing("a free flight: nothing pushes, nothing deforms, and it is straight at any time"),
        ),
        HardCase(
            "hanging-above-the-wall",
            "a bar hangs and swings above a wall that it just does not reach; a little nearer it is reached",
            lambda full: [Run(_hanging(full, 1.05)), Run(_hanging(full, NEAR))],
            lambda results: [
                _untouched(results[0]),
                _sag(results[0]),
                _pressed(results[1]),
                ck.no_overlap(results[1]),
                worst([ck.energy(result, 0.01) for result in results]),
            ],
        ),
    ]


def _bar(full: bool, gap: float) -> tc.Scene:
    cells = CELLS[full]
    scene = bar_impact.scene(cells=cells, gap=1e-4, duration=2.6e-3)
    (body,) = scene.bodies
    return replace(scene, bodies=[replace(body, mesh=body.mesh.translated((0.0, 0.0, gap - 1e-4)))])


def _energy(result: Result) -> float:
    return 0.2 / result.scene.bodies[0].mesh.cell_count


def _step(cells: int) -> float:
    """Return a step well inside the stable one: 0.7 of the time in which the wave crosses a cell."""
    return 0.7 * 1e-3 / cells


def _on_step(cells: int) -> list[float]:
    """Return the gaps [m] that close at the eighth step, and a rounding before and after it."""
    gap = 8.0 * _step(cells) * 10 / 3.6
    return [gap, gap * (1.0 - 1e-13), gap * (1.0 + 1e-13)]


def _impulse(result: Result) -> ck.Check:
    """Check that the whole impulse of an impact without loss is 2 m v."""
    momentum = result.history["momentum"][:, 2]
    coarse = 20.0 / result.scene.bodies[0].mesh.cell_count
    return ck.at_most("rebound against the exact one", abs(momentum[-1] / momentum[0] + 1.0), 0.05 * coarse)


def _same(results: list[Result], bound: float) -> ck.Check:
    """Check that all runs give the same running impulse, relative to the last."""
    curves = [result.history["impulse"][:, 2] for result in results]
    rows = min(len(curve) for curve in curves)
    most = max(np.abs(curve[:rows] - curves[0][:rows]).max() for curve in curves)
    return ck.at_most("difference of the running impulses", most / curves[0][-1], bound)


def _grazing(full: bool, removal: str) -> tc.Scene:
    n = 8 if full else 4
    mesh = tc.box_mesh((0.1,) * 3, (n,) * 3)
    body = tc.Body(mesh, tc.NeoHookean(1e7, 0.3, 1000.0), velocity=(5.0, -3.0, 0.0), contact="zmin")
    return tc.Scene([body], [tc.Plane()], duration=3e-3, contact=tc.MasslessContact(removal=removal))


def _straight(result: Result) -> ck.Check:
    wanted = result.scene.bodies[0].mesh.nodes + result.time * np.array((5.0, -3.0, 0.0))
    return ck.at_most("deviation from the straight flight [m]", np.abs(result.position - wanted).max(), 1e-12)


def _untouched(result: Result) -> ck.Check:
    largest = np.abs(result.history["contact_force"]).max()
    weight = ck.mass(result) * 9.81
    return ck.at_most("largest contact force / weight", largest / weight, 1e-9)


GRAVITY = 50.0
SAG = 1000.0 * GRAVITY * 0.1**2 / 1e5  # rho g L^2/E of a bar with a wave speed of 10 m/s
NEAR = 0.6  # distance of the wall that is reached, in sags


def _hanging(full: bool, share: float) -> tc.Scene:
    """Return a bar held at its top, released without strain for half a period; the wall is at a share of its sag."""
    cells = CELLS[full]
    mesh, material = column(cells, 0.1, 1e5, 1000.0)
    body = tc.Body(mesh, material, contact="zmin", supports=[tc.Support("zmax", "z")])
    wall = tc.Plane(point=(0.0, 0.0, -share * SAG))
    duration = 2.0 * 0.1 / material.wave_speed
    return tc.Scene([body], [wall], duration=duration, gravity=(0.0, 0.0, -GRAVITY))


def _sag(result: Result) -> ck.Check:
    """Check that the free end swings to rho g L^2/E at half a period.

    s(t) = rho g L^2/E (1 - (1 - ct/2L)^2 ...) is flat there.
    """
    moved = -(result.position - result.scene.bodies[0].mesh.nodes)[:, 2].min()
    return ck.at_most("sag against the exact one", abs(moved / SAG - 1.0), 0.6 / result.scene.bodies[0].mesh.cell_count)


def _pressed(result: Result) -> ck.Check:
    """Check the impulse on the wall until half a period, against the exact one.

    With s(t) = rho g L^2/E - g (2L/c - t)^2/2 the free end arrives with s' = g (2L/c - t) and is held from then on,
    which takes the pressure rho c s'(t) until the wave from the top is back.
    """
    left = np.sqrt(2.0 * (1.0 - NEAR) * SAG / GRAVITY)  # time from the touch to half a period [s]
    wanted = 1000.0 * 10.0 * (0.1 / 8.0) ** 2 * GRAVITY * left**2 / 2.0
    given = result.history["impulse"][-1, 2]
    return ck.at_most(
        "impulse on the near wall, error", abs(given / wanted - 1.0), 2.0 / result.scene.bodies[0].mesh.cell_count
    )
