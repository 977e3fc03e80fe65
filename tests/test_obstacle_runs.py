"""Runs do not depend on how a wall is described, nor on who moves."""

import numpy as np
import pytest

import tcontact as tc

GAP = 1e-4
BLOCK = tc.Box((0.05, 0.05, -0.5 - GAP), (2.0, 2.0, 1.0))
SAMPLED = tc.Sdf(lambda x: x[:, 2] + GAP, origin=(-0.1, -0.1, -0.1), spacing=0.05, nodes=(7, 7, 7))


def dropped(wall, speed=2.0):
    """History of a cube that hits a wall."""
    cube = tc.Body(
        tc.box_mesh((0.1, 0.1, 0.1), (3, 3, 3)), tc.NeoHookean(1e7, 0.3, 1000.0), (0, 0, -speed), contact="zmin"
    )
    scene = tc.Scene(cube, wall, duration=1e-3, contact=tc.MasslessContact(removal="full"))
    result = tc.simulate(scene, scheme=tc.CentralDifference(dt=2e-5))
    assert result.ok
    return result.history


@pytest.fixture(scope="module")
def plane():
    return dropped(tc.Plane((0, 0, -GAP)))


@pytest.mark.parametrize("wall", [BLOCK, SAMPLED], ids=["box", "sdf"])
@pytest.mark.slow  # a kernel for each shape is compiled
def test_a_wall_is_a_wall_whatever_its_description(plane, wall):
    history = dropped(wall)
    largest = plane["contact_force"].max()
    assert largest > 1e3
    assert np.abs(history["contact_force"] - plane["contact_force"]).max() < 1e-9 * largest
    np.testing.assert_allclose(history["gap_min"], plane["gap_min"], atol=1e-12)


@pytest.mark.parametrize(
    "velocity", [(0.0, 0.0, 2.0), lambda t: np.array([0.0, 0.0, 2.0])], ids=["constant", "function of time"]
)
def test_a_moving_block_that_hits_a_body_is_a_body_that_hits_it(plane, velocity):
    moving = tc.Box(BLOCK.center, BLOCK.size, velocity=velocity)
    history = dropped(moving, speed=0.0)
    largest = plane["contact_force"].max()
    assert np.abs(history["contact_force"] - plane["contact_force"]).max() < 1e-9 * largest
