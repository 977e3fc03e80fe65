"""Impacts that are not flat: on corners and edges, spinning, oblique, against several walls."""

from __future__ import annotations

import numpy as np

import tcontact as tc
from tcontact.cases import cube_impact

from ....results import checks as ck
from ....results.result import Result
from ..hard_cases import HardCase, Run, sound
from .references import against

SIZE, SPEED = 0.1, 10 / 3.6
RUBBER = tc.NeoHookean(young=1e7, poisson=0.3, density=1000.0)


def cases() -> list[HardCase]:
    """Return the cases: impacts."""
    return [
        HardCase(
            "corner-first",
            "a cube on its corner: one node carries the whole contact at first",
            lambda full: [Run(cube_impact.scene(cells=8 if full else 4, yaw=45.0, pitch=54.7356))],
            lambda results: [*against("corner-first", results), *sound(results, energy=0.01, momentum=1e-5)],
        ),
        HardCase(
            "edge-first",
            "a cube on its edge: a line of nodes, then rolling onto both faces",
            lambda full: [Run(cube_impact.scene(cells=8 if full else 4, pitch=45.0))],
            lambda results: [*against("edge-first", results), *sound(results, energy=0.01, momentum=1e-5)],
        ),
        HardCase(
            "oblique-25",
            "a cube turned by 25 degrees that also flies sideways, frictionless: sideways momentum must stay",
            lambda full: [Run(_oblique(8 if full else 4))],
            lambda results: [
                _sideways(results[0]),
                *against("oblique-25", results),
                *sound(results, energy=0.02, momentum=1e-5),
            ],
            cannot_feel={"duration": "the cube has all but left the wall after half of the run"},
        ),
        HardCase(
            "spinning-cube",
            "a cube that spins while it strikes: full removal must keep what angular momentum it should",
            lambda full: [Run(_spinning(8 if full else 4, tolerance)) for tolerance in (None, 1e-8)],
            lambda results: [
                _spin_in_balance(results[0]),
                *_spin(results[1]),
                *against("spinning-cube", results),
                *sound(results, energy=0.02, momentum=1e-5),
            ],
        ),
        HardCase(
            "two-walls",
            "a block that bounces between two walls",
            lambda full: [Run(_between(16 if full else 8))],
            lambda results: [
                _both(results[0]),
                *against("two-walls", results),
                *sound(results, energy=0.05, momentum=1e-5),
            ],
        ),
        HardCase(
            "three-walls",
            "a cube flies into a corner of three walls: three normals at one node; the three ways are alike",
            lambda full: [Run(_corner(8 if full else 4))],
            lambda results: [
                _alike(results[0]),
                *against("three-walls", results),
                *sound(results, energy=0.05, momentum=1e-5),
            ],
        ),
    ]


def _oblique(n: int) -> tc.Scene:
    scene = cube_impact.scene(cells=n, pitch=25.0)
    (body,) = scene.bodies
    moving = tc.Body(body.mesh, body.material, velocity=(3.0, 1.0, -SPEED), contact=body.contact)
    return tc.Scene([moving], scene.obstacles, duration=scene.duration)


def _sideways(result: Result) -> ck.Check:
    momentum = result.history["momentum"]
    change = np.abs(momentum[:, :2] - momentum[0, :2]).max() / np.abs(momentum[0]).max()
    return ck.at_most("change of the momentum along the wall", change, 1e-7)  # no better than the static solve balances


def _spinning(n: int, tolerance: float | None) -> tc.Scene:
    """Return a scene: a cube, spun by 200 rad/s about an oblique axis, a quarter turn above the wall."""
    axis = 200.0 * np.array([0.6, 0.0, 0.8])
    mesh = tc.box_mesh((SIZE,) * 3, (n,) * 3, origin=(-SIZE / 2, -SIZE / 2, 0.25 * SIZE))
    centre = mesh.nodes.mean(axis=0)
    body = tc.Body(
        mesh,
        RUBBER,
        velocity=lambda x: np.cross(axis, x - centre) - np.array((0.0, 0.0, 4.0 * SPEED)),
        contact=["zmin", "xmin", "xmax", "ymin", "ymax"],
    )
    contact = tc.MasslessContact(removal="full", tolerance=tolerance)
    return tc.Scene([body], [tc.Plane()], duration=6e-3, contact=contact)


def _spin(result: Result) -> list[ck.Check]:
    """Check the angular momentum about the origin: constant before the impact, about the normal always."""
    force, change = result.history["contact_force"][:, 2], _spin_change(result)
    before = int(np.argmax(force > 0.0)) if (force > 0.0).any() else 0
    flight = float(change[:before].max()) if before > 1 else np.nan
    return [
        ck.at_most("change of the angular momentum before the impact", flight, 1e-9),
        ck.at_most("change of the angular momentum about the normal", change[:, 2].max(), 1e-8),
    ]


def _spin_in_balance(result: Result) -> ck.Check:
    """Check how far what the static solve leaves unbalanced turns the body: it goes to other nodes of the body."""
    change, residual = _spin_change(result)[:, 2].max(), result.history["static_residual"].max()
    return ck.at_most("change of the angular momentum about the normal / static residual", change / residual, 10.0)


def _spin_change(result: Result) -> np.ndarray:
    """Return the change of the angular momentum since the start [rows, 3], relative to its largest component there."""
    spin = result.history["angular_momentum"]
    return np.asarray(np.abs(spin - spin[0]) / np.abs(spin[0]).max())


def _between(n: int) -> tc.Scene:
    mesh = tc.box_mesh((SIZE / 2, SIZE / 2, SIZE), (max(1, n // 2), max(1, n // 2), n), origin=(0, 0, 5e-4))
    body = tc.Body(mesh, RUBBER, velocity=(0.0, 0.0, -SPEED), contact=["zmin", "zmax"])
    walls = [tc.Plane(), tc.Plane(point=(0.0, 0.0, SIZE + 1e-3), normal=(0.0, 0.0, -1.0))]
    return tc.Scene([body], walls, duration=8e-3)


def _both(result: Result) -> ck.Check:
    """Check that both walls push, in turn."""
    force = result.history["contact_force"][:, 2]
    return ck.at_least("smaller of the two largest wall forces", min(force.max(), -force.min()), 1.0)


def _corner(n: int) -> tc.Scene:
    mesh = tc.box_mesh((SIZE,) * 3, (n,) * 3, origin=(1e-3,) * 3)
    body = tc.Body(mesh, RUBBER, velocity=(-SPEED,) * 3, contact=["xmin", "ymin", "zmin"])
    return tc.Scene([body], [tc.Plane(normal=normal) for normal in np.eye(3)], duration=3e-3)


def _alike(result: Result) -> ck.Check:
    """Check the largest difference between the forces on two walls, relative to the largest force."""
    force = result.history["contact_force"]
    return ck.at_most("difference between the three walls", np.ptp(force, axis=1).max() / force.max(), 1e-3)
