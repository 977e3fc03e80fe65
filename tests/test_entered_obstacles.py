"""A body that falls into an obstacle with faces that are not in its contact set is told of at the end of the run."""

import re
import warnings

import numpy as np
import pytest
from conftest import THREADS
from scenes import material

import tcontact as tc

FLOOR = tc.Plane((0.0, 0.0, -0.001), name="floor")


def told(contact, obstacle=FLOOR, model="default", duration=0.02, speed=3.0):
    """Return the warnings of the run of a cube that falls at an obstacle."""
    mesh = tc.box_mesh((0.1, 0.1, 0.1), (3, 3, 3))
    body = tc.Body(mesh, material("linear"), (0.0, 0.0, -speed), contact=contact, name="cube")
    with warnings.catch_warnings(record=True):
        warnings.simplefilter("always")
        given = {} if model == "default" else {"contact": model}
        result = tc.simulate(tc.Scene([body], [obstacle], duration, **given), threads=THREADS)
    assert result.ok
    return [text for text in result.warnings if "inside obstacle" in text]


def test_a_wrong_contact_face_is_told_of_with_depth_and_remedy():
    """The lowest nodes end 59 mm below the floor, and the contact face, the upper one, above it."""
    (text,) = told("zmax")
    assert re.search(r"of cube ends 0\.059\d* m inside obstacle floor", text)
    assert "Body.contact = 'zmax'" in text
    assert "contact='auto'" in text


@pytest.mark.parametrize("contact", ["zmin", "auto", ["zmin", "zmax"]])
def test_bodies_that_are_held_are_told_of_nothing(contact):
    """A body that bounces, and one whose soft penalty gives way as a whole, are not told of."""
    assert not told(contact)


def test_a_soft_penalty_that_gives_way_is_another_matter():
    """All of the body is deep inside, its contact nodes most of all."""
    assert not told("zmin", model=tc.PenaltyContact(1e3))


def test_obstacles_that_move_are_looked_for_where_they_end():
    """The floor rises as the body rests: it is as deep inside at the end; a floor that sinks faster is not met."""
    rising = tc.Plane((0.0, 0.0, -0.001), velocity=(0.0, 0.0, 3.0), name="floor")
    assert len(told("zmax", rising, speed=0.0)) == 1
    # 62 waves: three Gauss points over the whole time see almost no motion
    waves = tc.Plane(
        (0.0, 0.0, -0.001),
        velocity=lambda t: np.array([0.0, 0.0, 3.0 * (1.0 - np.cos(2.0 * np.pi * 62.0 * t / 0.02))]),
        name="floor",
    )
    assert len(told("zmax", waves, speed=0.0)) == 1
    sinking = tc.Plane((0.0, 0.0, -0.001), velocity=lambda t: (0.0, 0.0, -4.0 + 0.0 * t), name="floor")
    assert not told("zmax", sinking)


def test_without_contact_no_one_is_told_twice():
    """Scenes say at once that their bodies pass through obstacles."""
    mesh = tc.box_mesh((0.1, 0.1, 0.1), (3, 3, 3))
    body = tc.Body(mesh, material("linear"), (0.0, 0.0, -3.0))
    with pytest.warns(UserWarning, match="no Body.contact"):
        scene = tc.Scene([body], [FLOOR], 0.01)
    assert not tc.simulate(scene, threads=THREADS).warnings


def test_a_motion_that_fails_between_the_rows_costs_no_result():
    """The looks at the end follow a motion at more times than the run, which has everything by then."""

    def velocity(t):
        if 3.011e-4 < t < 3.019e-4:
            raise ValueError("no value here")
        return 0.0, 0.0, 0.1

    wall = tc.Plane((0.0, 0.0, -1e-4), velocity=velocity)
    mesh = tc.box_mesh((0.1, 0.1, 0.1), (2, 2, 2))
    body = tc.Body(mesh, material("neo"), velocity=(0.0, 0.0, -1.0), contact="zmin")
    scene = tc.Scene([body], [wall], 1e-3, contact=tc.MasslessContact("full"))
    assert tc.simulate(scene, tc.CentralDifference(dt=2e-5), threads=THREADS).reason == "finished"
