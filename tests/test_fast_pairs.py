"""Bodies of a pair that approach with a large part of the speed of sound meet, or the run stops before they would not.

Two equal bars of rubber: F = rho c A V / 2 until the first wave comes back.
"""

import numpy as np
import pytest

import tcontact as tc

RUBBER = tc.LinearElastic(young=1e6, poisson=0.0, density=1000.0)
LENGTH, WIDTH, CELLS = 0.1, 0.02, 10
EXACT = RUBBER.density * RUBBER.wave_speed * WIDTH**2 / 2.0  # force [N] over the speed [m/s]


def bar(start, velocity, name):
    """A bar along z from `start` on."""
    mesh = tc.box_mesh((WIDTH, WIDTH, LENGTH), (2, 2, CELLS), origin=(0.0, 0.0, start))
    return tc.Body(mesh, RUBBER, (0.0, 0.0, velocity), contact=("zmin", "zmax"), name=name)


def collided(part, gap, removal="full", **options):
    """Let a bar meet another one at rest with this part of the speed of sound."""
    speed = part * RUBBER.wave_speed
    bodies = [bar(gap, -speed, "up"), bar(-LENGTH, 0.0, "low")]
    contact = tc.MasslessContact(removal)
    duration = gap / speed + 1.5 * LENGTH / RUBBER.wave_speed
    return speed, tc.simulate(tc.Scene(bodies, duration=duration, contact=contact), progress=False, **options)


@pytest.mark.parametrize("removal", ["full", "normal"])
@pytest.mark.parametrize(("part", "gap"), [(0.4, 0.010), (0.44, 0.0122), (0.6, 0.0145), (0.8, 0.010), (0.8, 0.0122)])
def test_the_force_is_that_of_a_shock_wave(part, gap, removal):
    """A step leads from beyond the reach of contact to beyond it inside the other body."""
    speed, result = collided(part, gap, removal)
    assert result.ok
    force = np.abs(result.history["pair_force:up-low"]).max(axis=1)
    pressed = force > 0.5 * EXACT * speed
    assert pressed.sum() >= 0.5 * LENGTH / RUBBER.wave_speed / result.dt
    assert np.median(force[pressed]) == pytest.approx(EXACT * speed, rel=0.15)


@pytest.mark.parametrize("gap", [1e-5, 0.010, 0.0145, 0.05])
@pytest.mark.parametrize("part", [1.2, 3.0])
def test_what_goes_further_in_a_step_than_contact_sees_is_stopped(part, gap):
    _speed, result = collided(part, gap)
    assert result.reason == "missed-contact"
    assert "further than contact sees" in result.message
    assert result.time < gap / (part * RUBBER.wave_speed) + 2.0 * result.dt


def test_a_smaller_step_sees_it():
    speed, result = collided(1.2, 0.01, scheme=tc.CentralDifference(cfl=0.4))
    assert result.reason != "missed-contact"
    assert np.abs(result.history["pair_force:up-low"]).max() > EXACT * speed
