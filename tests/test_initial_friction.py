"""A run that starts from the end of another one goes on with its friction, also where coefficients vary."""

import dataclasses

import numpy as np
import pytest
from scenes import simulate

import tcontact as tc

PRESSURE, YOUNG, PART = 2e4, 2e7, 2e-3
LAWS = {
    "constant": tc.Coulomb(0.3),
    "falling": tc.Coulomb(static=0.4, kinetic=0.2, decay=3.0),
    "rising": tc.Coulomb(static=0.1, kinetic=0.4, decay=3.0),
    "by speed": tc.FrictionTable([0.0, 0.6], [1e4], [[0.2], [0.4]]),
    "by pressure": tc.FrictionTable([0.0], [1e4, 3e4], [[0.1, 0.4]]),
    "by both": tc.FrictionTable([0.0, 0.6], [1e4, 3e4], [[0.1, 0.3], [0.2, 0.35]]),
    "limited": tc.Coulomb(0.3, limit=3e3),
}


def pressed(law, partner, duration, cells=(3, 2, 2)):
    """Return a block that is pressed on a plane or on another block and slides with full removal."""
    material = tc.LinearElastic(YOUNG, 0.0, 1000.0)
    body = tc.Body(
        tc.box_mesh((0.15, 0.1, 0.1), cells),
        material,
        (0.4, 0.0, 0.0),
        contact="zmin",
        name="up",
        loads=[tc.Load("zmax", traction=(0.0, 0.0, -PRESSURE))],
        displacement=lambda x: x[:, 2:] * (0.0, 0.0, -PRESSURE / YOUNG),
    )
    contact = tc.MasslessContact("full", tolerance=1e-11)
    if partner == "plane":
        return tc.Scene([body], [tc.Plane()], duration, friction=law, contact=contact)
    mesh = tc.box_mesh((0.4, 0.2, 0.1), (5, 3, cells[2] - 1), origin=(-0.05, -0.05, -0.1))
    under = tc.Body(mesh, material, contact="zmax", name="low", supports=[tc.Support("zmin", "xyz")])
    return tc.Scene([body, under], duration=duration, friction=law, contact=contact)


def parts(scene, **options):
    """Return the whole run, the first half and the second one, which starts from the first."""
    half = dataclasses.replace(scene, duration=scene.duration / 2)
    first = simulate(half, **options)
    whole = simulate(dataclasses.replace(scene, duration=2 * first.time), dt=first.dt, **options)
    return whole, first, simulate(half, dt=first.dt, initial=first, **options)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("partner", ["plane", "pair"])
def test_two_halves_are_the_whole_run_with_any_law(law, partner):
    whole, first, second = parts(pressed(LAWS[law], partner, 2 * PART))
    key = "contact_force" if partner == "plane" else "pair_force:up-low"
    seam = first.steps
    force, found = whole.history[key][seam:], second.history[key]
    assert 0.05 * force[0, 2] < -force[0, 0] < 0.45 * force[0, 2]
    np.testing.assert_allclose(found, force, rtol=0, atol=1e-8 * np.abs(force).max())
    work = whole.history["friction_work"][seam:] - whole.history["friction_work"][seam]
    np.testing.assert_allclose(second.history["friction_work"], work, rtol=0, atol=1e-8 * work[-1])
    momentum = whole.history["momentum"][seam:]
    np.testing.assert_allclose(second.history["momentum"], momentum, rtol=0, atol=1e-9 * np.abs(momentum).max())
