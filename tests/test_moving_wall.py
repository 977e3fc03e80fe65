"""A wall that hits a resting body does what a resting wall does to the body that hits it, friction included."""

import numpy as np
import pytest

import tcontact as tc

WALL = np.array([2.0, 1.0, 5.0])  # [m/s]
CONTACTS = {
    "normal": tc.MasslessContact(removal="normal"),
    "full": tc.MasslessContact(removal="full", tolerance=1e-8),
    "penalty": tc.PenaltyContact(1e9),
    "impulse": tc.ImpulseContact(),
}


def impact(moving, contact, friction):
    # the gap is no whole number of steps: a node that arrives at gap 0 exactly would be closed or open by rounding
    mesh = tc.box_mesh(size=(0.1, 0.1, 0.1), cells=(3, 3, 3), kind="hex8", origin=(0, 0, 1.3e-4))
    material = tc.LinearElastic(young=1e7, poisson=0.3, density=1000.0)
    body = tc.Body(mesh, material, velocity=(0, 0, 0) if moving else -WALL, contact="zmin")
    wall = tc.Plane(velocity=WALL if moving else None)
    scene = tc.Scene(bodies=[body], obstacles=[wall], duration=1e-3, contact=contact, friction=friction)
    return tc.simulate(scene, scheme=tc.CentralDifference(dt=2e-5))


RUBBING = {  # full removal: two kernels that take long to compile; test_friction has it row by row against the oracle
    name: pytest.param(contact, tc.Coulomb(0.3), marks=[pytest.mark.slow] * (name == "full"), id=f"{name}-coulomb")
    for name, contact in CONTACTS.items()
}


@pytest.mark.parametrize(
    ("contact", "friction"),
    [*(pytest.param(contact, None, id=name) for name, contact in CONTACTS.items()), *RUBBING.values()],
)
def test_only_the_relative_velocity_counts(contact, friction):
    thrown, hit = impact(False, contact, friction), impact(True, contact, friction)
    np.testing.assert_allclose(hit.position, thrown.position + WALL * hit.time, rtol=0, atol=1e-10)
    for name in ("contact_force", "friction_work", "elastic"):
        wanted = thrown.history[name]
        np.testing.assert_allclose(hit.history[name], wanted, rtol=0, atol=1e-9 * np.abs(wanted).max(), err_msg=name)
    change = hit.history["momentum"] - hit.history["momentum"][0] - hit.history["impulse"]
    assert np.abs(change).max() <= 1e-9 * np.abs(hit.history["momentum"]).max()


def test_nodes_that_a_wall_leaves_at_once_are_balanced_again():
    # from one step to the next: its first state is in balance, but for a wall that is no longer there
    mesh = tc.box_mesh(size=(0.1, 0.1, 0.1), cells=(2, 2, 2), kind="hex8")
    body = tc.Body(mesh, tc.NeoHookean(young=1e7, poisson=0.3, density=1000.0), contact="zmin")
    dt = 3e-4

    def velocity(time):
        return (0.0, 0.0, 3.0 if time < 3.0 * dt else -3.0)

    scene = tc.Scene(bodies=[body], obstacles=[tc.Plane(velocity=velocity)], duration=10 * dt)
    history = tc.simulate(scene, scheme=tc.CentralDifference(dt=dt)).history
    assert history["contact_nodes"].max() == 9
    assert history["contact_nodes"][-1] == 0
    assert history["static_residual"].max() <= 1e-4
