"""Two halves of a run of bodies in contact are the whole: a `Result` hands on rows of pairs and their closed gaps."""

import dataclasses

import numpy as np
import pytest
from pair_scenes import oblique_cubes

import tcontact as tc
from tcontact.cases import ring_in_ring, two_spheres

STEP = 0.025


def halves(scene, step, key):
    """Return the force of a pair in the second half of a run: of the whole one, and of a run from its middle."""
    scheme = tc.CentralDifference(dt=step)
    half = dataclasses.replace(scene, duration=scene.duration / 2.0)
    whole, first = tc.simulate(scene, scheme), tc.simulate(half, scheme)
    second = tc.simulate(half, scheme, initial=first)
    rows = len(first.pair_force[key]) - 1
    both = whole.pair_force[key][rows:], second.pair_force[key]
    count = min(map(len, both))
    return *(force[:count] for force in both), whole, first, second


@pytest.mark.parametrize(
    ("contact", "bound"),
    [(tc.MasslessContact("full"), 1e-5), (tc.MasslessContact("normal"), 1e-5), (tc.PenaltyContact(3.0), 1e-12)],
    ids=["full", "normal", "penalty"],
)
def test_the_second_half_slides_on_with_the_rows_of_the_first(contact, bound):
    """Rows built anew in the middle would differ by .1 of the force with a penalty, .01 with normal removal."""
    known, found, whole, first, second = halves(oblique_cubes(duration=3.6, contact=contact), STEP, "up-low")
    assert np.abs(known[0]).max() > 0.05 * np.abs(whole.pair_force["up-low"]).max()  # they touch in the middle
    assert first.history["pair_rebuilds"][-1] > 1
    assert np.abs(found - known).max() <= bound * np.abs(whole.pair_force["up-low"]).max()
    assert np.abs(second.velocity - whole.velocity).max() <= 10.0 * bound * np.abs(whole.velocity).max()


def test_gaps_that_count_as_closed_are_those_of_the_start():
    """Openings that come during the run are real."""
    scene = ring_in_ring.scene(cells=12, outer_cells=12, turn=1.0)
    bodies = list(scene.bodies)
    push = np.asarray(bodies[0].initial_velocity) + np.array((0.004 * bodies[0].material.wave_speed, 0.0, 0.0))
    bodies[0] = dataclasses.replace(bodies[0], velocity=push)
    scene = dataclasses.replace(scene, bodies=bodies, duration=0.5 * scene.duration)
    step = 0.5 * tc.simulate(dataclasses.replace(scene, duration=1e-3 * scene.duration)).dt_limit
    known, found, whole, first, second = halves(scene, step, "inner-outer")
    assert np.isfinite(first.pairs.closed).any()
    assert np.array_equal(first.pairs.closed, second.pairs.closed, equal_nan=True)
    assert np.array_equal(first.pairs.closed, whole.pairs.closed, equal_nan=True)
    assert np.abs(found - known).max() <= 1e-4 * np.abs(whole.pair_force["inner-outer"]).max()


def test_gaps_that_a_second_run_closes_are_those_where_the_bodies_then_are():
    """Not those where the first run built its rows, when the bodies were further apart."""
    scene = two_spheres.scene(cells=6)
    step = 0.5 * tc.simulate(dataclasses.replace(scene, duration=1e-3 * scene.duration)).dt_limit
    scheme = tc.CentralDifference(dt=step)
    touching = np.abs(next(iter(tc.simulate(scene, scheme).pair_force.values()))).max(axis=1) > 0.0
    first = tc.simulate(dataclasses.replace(scene, duration=(np.argmax(touching) - 1) * step), scheme)
    names = [body.name for body in scene.bodies]
    closed = dataclasses.replace(scene, pairs=[tc.Pair(*names, initial_gap="closed")], duration=3.0 * step)
    second = tc.simulate(closed, scheme, initial=first)
    alone = tc.simulate(closed, scheme, initial=dataclasses.replace(first, pairs=None))
    assert np.nanmax(np.abs(alone.pairs.closed)) > 0.0
    force = [np.abs(next(iter(result.pair_force.values()))) for result in (second, alone)]
    assert force[0][0].max() <= 1e-9 * force[1].max()


def test_surfaces_that_the_first_run_did_not_have_get_rows_where_they_are():
    scene = oblique_cubes(duration=0.5)
    first = tc.simulate(scene)
    bodies = [
        dataclasses.replace(body, contact=(*faces, "xmin"))
        for body, faces in zip(scene.bodies, (["zmin"], ["zmax"]), strict=True)
    ]
    assert tc.simulate(dataclasses.replace(scene, bodies=bodies), initial=first).ok


def test_runs_without_pairs_remember_nothing():
    scene = oblique_cubes(duration=0.1)
    assert tc.simulate(dataclasses.replace(scene, pairs=None, contact=None)).pairs is None
    alone = dataclasses.replace(scene, bodies=scene.bodies[:1])
    assert tc.simulate(alone).pairs is None
