"""The last row of a run, where no step follows, is that of a longer run at that time: friction acts in whole kicks."""

import dataclasses

import numpy as np
import pytest

import tcontact as tc

SIZE = np.array([0.1, 0.08, 0.12])
LAW = tc.NeoHookean(2.3e7, 0.27, 1350.0)
CONTACT = tc.MasslessContact(removal="normal", tolerance=1e-10)
ELSEWHERE = ("pair_rebuilds", "static_residual", "energy_error")  # of launches; rounding; over the largest of the run
SAME = 1e-12  # of the largest value


def block(counts=(3, 3, 4), at=(0.0, 0.0, 1e-4), velocity=(1.0, 0.5, -8.0), **given):
    """Return a block above the plane z = 0, whose contact nodes stick and slip as they come to rest."""
    mesh = tc.box_mesh(SIZE, counts).translated(at)
    return tc.Body(mesh, LAW, velocity=velocity, contact="zmin", **given)


def on_a_ball():
    ball = tc.Sphere((0.05, 0.04, -0.2), 0.2)
    slow = block(velocity=(0.2, 0.1, -8.0))
    return tc.Scene([slow], [ball], 1.2e-3, contact=CONTACT, friction=tc.Coulomb(0.5))


def on_a_body():
    lower = block(counts=(4, 4, 3), at=(-0.003, 0.004, -0.1201), velocity=(0.0, 0.0, 0.0), name="lower")
    lower = dataclasses.replace(lower, contact="zmax")
    bodies = [lower, block(name="upper")]
    return tc.Scene(bodies, duration=1.2e-3, contact=CONTACT, friction=tc.Coulomb(0.3), pairs="auto")


def on_a_free_plate():
    plate = tc.Plane((0.05, 0.04, 0.0), mass=2.0, inertia=0.02)
    return tc.Scene([block()], [plate], 1.2e-3, contact=CONTACT, friction=tc.Coulomb(0.3))


def with_a_penalty():
    return dataclasses.replace(on_a_ball(), contact=tc.PenaltyContact(stiffness=5e9))


ROWS = [(on_a_ball, 4), (on_a_body, 9), (on_a_free_plate, 9), (with_a_penalty, 5)]  # where some nodes stick


@pytest.mark.parametrize(("make", "row"), ROWS)
def test_the_last_row_is_that_of_a_longer_run(make, row):
    physics, scheme = make(), tc.CentralDifference(cfl=0.35)
    longer = tc.simulate(physics, scheme=scheme)
    end = longer.history["time"][row]
    shorter = tc.simulate(dataclasses.replace(physics, duration=end * (1.0 - 1e-12)), scheme=scheme)
    assert shorter.steps == row < longer.steps
    assert shorter.history["friction_work"][-1] > 0.0
    columns = [name for name in shorter.history if name not in ELSEWHERE]
    assert "contact_force" in columns
    for name in columns:
        one, other = longer.history[name][: row + 1], shorter.history[name]
        same = (one == other) | (
            np.abs(np.where(one == other, 0.0, one - other)) <= SAME * np.abs(one).max(initial=0.0)
        )
        assert same.all(), name
