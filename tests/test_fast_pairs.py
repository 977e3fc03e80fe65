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


def box(size, cells, start, velocity, name, contact):
    """A box of rubber; velocity over the speed of sound."""
    mesh = tc.box_mesh(size, cells, origin=start)
    return tc.Body(mesh, RUBBER, np.array(velocity) * RUBBER.wave_speed, contact=contact, name=name)


def ran(*bodies, duration):
    """Run bodies for a duration over the time that sound takes through .01 m."""
    contact = tc.MasslessContact("full")
    return tc.simulate(tc.Scene(bodies, duration=duration * 0.01 / RUBBER.wave_speed, contact=contact), progress=False)


PLATE = (0.2, 0.2, 0.02), (10, 10, 2), (0.0, 0.0, -0.02), (0.0, 0.0, 0.0), "plate", "zmax"


def test_what_would_pass_a_plate_away_from_its_middle_is_stopped():
    """It flies away from the middle of the plate, and down."""
    block = box((0.02, 0.02, 0.02), (2, 2, 2), (0.12, 0.09, 0.013), (1.0, 0.0, -1.5), "block", "zmin")
    assert ran(block, box(*PLATE), duration=4.0).reason == "missed-contact"


def test_a_fast_flight_past_another_body_goes_on():
    block = box((0.02, 0.02, 0.02), (2, 2, 2), (-0.05, 0.0, 0.002), (1.2, 0.0, 0.0), "block", "zmin")
    bar = box((0.1, 0.02, 0.02), (10, 2, 2), (0.0, 0.0, -0.02), (0.0, 0.0, 0.0), "bar", "zmax")
    assert ran(block, bar, duration=15.0).ok


def test_a_fast_slide_goes_on():
    block = box((0.04, 0.04, 0.04), (4, 4, 4), (0.005, 0.03, 1e-6), (1.0, 0.0, -0.02), "block", "zmin")
    result = ran(block, box(*PLATE), duration=8.0)
    assert result.ok
    assert np.abs(result.history["pair_force:block-plate"]).max() > 0.0
    assert np.abs(result.history["energy_error"]).max() < 1e-3


def test_slow_contact_at_edges_does_not_count_faces_that_overlap_beside_it():
    """Two blocks of few cells meet with edges; rows on their sides as well give an energy error of .4."""
    random = np.random.default_rng(6)
    rubber = tc.NeoHookean(young=1e6, poisson=0.3, density=1000.0)
    sizes, turns = random.uniform(0.5, 1.5, (2, 3)), (0.8, 0.2)
    meshes = []
    for size, turn in zip(sizes, turns, strict=True):
        axis = random.normal(size=3)
        mesh = tc.box_mesh(tuple(size), (3, 3, 3)).rotated((tuple(axis / np.linalg.norm(axis)), turn), about=size / 2)
        meshes.append(mesh.translated(-size / 2))
    way = random.normal(size=3)
    way /= np.linalg.norm(way)
    apart = (meshes[1].nodes @ way).max() - (meshes[0].nodes @ way).min() + 0.02
    bodies = [
        tc.Body(meshes[0].translated(apart * way), rubber, -0.07 * rubber.wave_speed * way, contact="auto", name="a"),
        tc.Body(meshes[1], rubber, contact="auto", name="b"),
    ]
    scene = tc.Scene(bodies, duration=5.0 / rubber.wave_speed, contact=tc.MasslessContact("full"))
    result = tc.simulate(scene, progress=False)
    assert result.ok
    assert np.abs(result.history["energy_error"]).max() < 0.15
