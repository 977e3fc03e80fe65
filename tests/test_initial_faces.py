"""A run that starts from another one's end has the contact faces and pairs that may meet from there."""

import warnings

import numpy as np
import pytest
from conftest import THREADS

import tcontact as tc
from tcontact.run.initial_faces import scene_of_start
from tcontact.run.initial_state import start_from
from tcontact.scene.rigid_motion import TURNED, rigid_motion

RUBBER = tc.NeoHookean(young=1e6, poisson=0.3, density=1000.0)
SPEED = 1.0


def scene(duration, speed=SPEED, gap=0.02, contact="auto", turn=0.0, **options):
    """Return a scene of a cube, turned about y by so many degrees, that falls on another one."""
    mesh = tc.box_mesh((0.1,) * 3, (3, 3, 3))
    above = mesh.rotated(((0, 1, 0), np.radians(turn)), about=(0.05, 0.05, 0.05)).translated((0.02, 0.01, 0.1 + gap))
    bodies = [
        tc.Body(above, RUBBER, (0, 0, -speed), contact=contact, name="up"),
        tc.Body(mesh, RUBBER, contact=contact, name="low"),
    ]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return tc.Scene(bodies, duration=duration, contact=tc.MasslessContact("full"), **options)


def faces(known):
    """Return how many contact faces the bodies of a scene have."""
    return [len(body.contact_faces) for body in known.bodies]


def test_bodies_that_are_named_at_rest_meet_as_they_move_in_fact():
    """By what the second scene says of them they would stay apart: no faces, no pair, and a stop where they meet."""
    far = {"gap": 0.3, "speed": 5.0}
    first = tc.simulate(scene(0.05, **far), threads=THREADS)
    rest = scene(0.02, **(far | {"speed": 0.0}))
    assert rest.pairs_at == ((), ())  # what the scene knows of its own start does not stay
    assert faces(rest) == [0, 0]
    assert not rest.body_pairs
    second = tc.simulate(rest, threads=THREADS, initial=first)
    assert second.ok, second.message
    assert [pair.name for pair in second.scene.body_pairs] == ["up-low"]
    assert min(faces(second.scene)) >= 9
    assert np.abs(second.pair_force["up-low"]).max() > 0.0


def test_faces_of_the_first_run_stay():
    """A long run has more of them than a short one that starts from its end."""
    first = tc.simulate(scene(0.012, turn=20.0), threads=THREADS)
    short = scene(1e-3, turn=20.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        second, told = scene_of_start(short, start_from(short, first), first, False)
    assert not told
    for body, before in zip(second.bodies, first.scene.bodies, strict=True):
        assert {*map(tuple, before.contact_faces)} <= {*map(tuple, body.contact_faces)}
    assert second.body_pairs == first.scene.body_pairs


def test_more_faces_than_the_first_run_had_are_named():
    """The first run was too short for the two to meet."""
    far = {"gap": 0.3, "speed": 5.0}
    first = tc.simulate(scene(1e-3, **far), threads=THREADS)
    assert faces(first.scene) == [0, 0]
    with pytest.warns(RuntimeWarning, match=r"contact='auto' of body up has \d+ faces more than in the run"):
        second = tc.simulate(scene(0.07, **far), threads=THREADS, initial=first)
    assert min(faces(second.scene)) >= 9
    assert any("faces more than in the run" in text for text in second.warnings)


def test_a_body_that_is_deformed_and_hardly_turned_gets_no_faces_of_its_sides():
    """They bulge and look at the plane: without their mass the first row had less energy than the last one before."""
    mesh = tc.box_mesh((0.1, 0.1, 0.1), (3, 3, 3)).translated((0.0, 0.0, 1e-4))
    body = tc.Body(
        mesh, RUBBER, lambda x: np.stack([40.0 * (x[:, 0] - 0.05), 0 * x[:, 1], 0 * x[:, 2] - 8.0], 1), "auto"
    )
    falling = tc.Scene([body], [tc.Plane()], 6e-3, contact=tc.MasslessContact("normal"))
    first = tc.simulate(falling, threads=THREADS)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        second = tc.simulate(falling, threads=THREADS, initial=first)
    assert faces(second.scene) == faces(first.scene) == [9]
    assert second.history["energy"][0] == pytest.approx(first.history["energy"][-1], rel=1e-3)


@pytest.mark.parametrize("angle", [2.5, 1.5 * TURNED, 0.5 * TURNED])
def test_the_rigid_motion_of_nodes_is_found_and_a_small_turn_left_out(angle):
    axis = np.array([2.0, -1.0, 2.0]) / 3.0
    cross = np.cross(np.eye(3), axis)
    rotation = np.eye(3) + np.sin(angle) * cross.T + (1.0 - np.cos(angle)) * cross @ cross  # Rodrigues
    x = np.random.default_rng(3).random((40, 3))
    arms = x - x.mean(axis=0)
    spin, shift, speed = np.array([3.0, 1.0, -2.0]), np.array([0.2, -5.0, 1.0]), np.array([1.0, 2.0, 3.0])
    turned = arms @ rotation.T
    motion = rigid_motion(lambda: (x[:7], x[7:]), turned - arms + shift, speed + np.cross(spin, turned))
    moved, velocity = motion.values((x[:7], x[7:]), len(x))
    small = angle < TURNED
    assert np.abs(moved - ((0.0 if small else turned - arms) + shift)).max() < 1e-13
    if not small:
        assert np.abs(velocity - (speed + np.cross(spin, turned))).max() < 1e-12


def test_all_makes_two_halves_the_whole():
    """Named faces do not depend on the duration."""
    scheme = tc.CentralDifference(dt=3e-4)
    whole, half = (scene(duration, contact="all", turn=20.0) for duration in (0.024, 0.012))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        known = tc.simulate(whole, scheme, threads=THREADS)
        first = tc.simulate(half, scheme, threads=THREADS)
        second = tc.simulate(half, scheme, threads=THREADS, initial=first)
    assert np.abs(known.pair_force["up-low"]).max() > 0.0
    assert np.abs(second.position - known.position).max() < 1e-6
    assert faces(second.scene) == [54, 54]


def test_a_run_that_is_resumed_has_the_faces_that_it_had(tmp_path):
    """Its scene alone does not know of them: they are in the checkpoint."""
    first = tc.simulate(scene(0.012, turn=20.0), threads=THREADS)
    short = scene(1e-3, turn=20.0)
    options = tc.Checkpoint(every_seconds=None, every_steps=2, keep=True)
    second = tc.simulate(short, threads=THREADS, initial=first, out=tmp_path / "run", checkpoint=options)
    again = tc.resume(tmp_path / "run", short, threads=THREADS)
    assert faces(again.scene) == faces(second.scene) == faces(first.scene)
    assert np.array_equal(again.position, second.position)
