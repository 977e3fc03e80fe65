"""The ball of hertz-impact: its mesh is a ball; thrown or pressed it follows Hertz."""

import dataclasses

import numpy as np
import pytest
from scenes import simulate

import tcontact as tc
from tcontact.cases import _round_meshes, hertz_impact
from tcontact.results import checks as ck


def test_the_quarter_ball_is_one():
    mesh = _round_meshes.quarter_ball(2.0, 0.06, 6)
    assert ck.volume(mesh) == pytest.approx(np.pi / 3 * 8.0, rel=2e-2)
    assert np.linalg.norm(mesh.nodes, axis=1).max() == pytest.approx(2.0, rel=1e-12)
    cap = mesh.nodes[np.unique(mesh.faces_of(["cap"]))]
    np.testing.assert_allclose(np.linalg.norm(cap, axis=1), 2.0, rtol=1e-12)


@pytest.mark.slow
def test_the_impact_is_that_of_hertz_and_nearer_on_a_finer_mesh():
    errors = []
    for cells in (4, 8):
        scene = hertz_impact.scene(cells=cells)
        assert hertz_impact.cells_across(scene) == cells
        found = {check.name: check for check in hertz_impact.checks(tc.simulate(scene))}
        assert all(check.passed for check in found.values()), found
        errors.append(found["largest force, error"].value)
    assert errors[1] < errors[0]


def pressed(cells, contact_radius):
    """The ball put on the plane under its weight, with damping: force over that of Hertz at the same approach.

    `cells` across the contact radius, which is `contact_radius` times that of the ball. The approach is that of the
    centre of mass. The mesh widens faster than that of the case: what is far away counts less.
    """
    thrown = hertz_impact.scene(cells=4, contact_radius=contact_radius)
    most, depth, _ = hertz_impact.theory(thrown)  # the weight of the quarter is to be the largest force of the impact
    radius = 0.05
    mesh = _round_meshes.quarter_ball(radius, contact_radius * radius / cells, cells + 1, 1.5)
    ball = dataclasses.replace(thrown.bodies[0], mesh=mesh, velocity=(0.0, 0.0, 0.0))
    mass = ball.material.density * ck.volume(mesh)
    frequency = np.sqrt(1.5 * most / (mass * depth))
    scene = tc.Scene(
        [ball],
        [tc.Plane(point=(0.0, 0.0, float(mesh.nodes[:, 2].min())))],
        duration=5.0 / frequency,
        gravity=(0.0, 0.0, -most / mass),
        damping=tc.MassDamping(1.5 * frequency),
    )
    history = simulate(scene, cfl=0.9).history
    speed = history["momentum"][:, 2] / mass
    approach = -np.sum(0.5 * (speed[1:] + speed[:-1]) * np.diff(history["time"]))
    force = history["contact_force"][-1, 2]
    assert force == pytest.approx(most, rel=5e-2)  # all but at rest
    return force / most / (approach / depth) ** 1.5


@pytest.mark.slow
def test_a_pressed_ball_follows_hertz():
    """Hertz takes a ball for a half-space: what is off is of first order in a/R, and small for a small contact."""
    large, half = pressed(4, 0.13) - 1.0, pressed(4, 0.065) - 1.0
    assert 1.7 < large / half < 2.6
    assert abs(pressed(8, 0.05) - 1.0) <= 0.05
