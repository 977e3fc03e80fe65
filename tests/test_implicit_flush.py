"""Exact contact in implicit steps with obstacles whose normals are nearly, but not exactly, equal."""

import numpy as np
import pytest
from test_implicit_runs import RUBBER, run

import tcontact as tc

SCHEMES = [tc.DiscreteGradient, tc.Midpoint, tc.Trapezoidal, tc.HilberHughesTaylor, tc.PaperImplicit]
TURN = np.array([[np.cos(0.3), np.sin(0.3), 0.0], [-np.sin(0.3), np.cos(0.3), 0.0], [0.0, 0.0, 1.0]])


def leaning(angle):
    """Return a plane through the y axis, turned about it by an angle [rad]."""
    return tc.Plane(normal=(np.sin(angle), 0.0, np.cos(angle)))


def landed(obstacles, scheme, left, velocity, height=1e-3):
    """Return 4 x 1 x 1 cells, from x = left on, that land on the obstacles and are pressed on them at the end."""
    mesh = tc.box_mesh(size=(0.1, 0.04, 0.04), cells=(4, 1, 1), origin=(left, 0.0, height))
    body = tc.Body(mesh, RUBBER, velocity, contact="zmin")
    return run(tc.Scene([body], obstacles, duration=1.5e-3, contact=tc.MasslessContact("full")), scheme)


@pytest.mark.parametrize("scheme", SCHEMES, ids=lambda scheme: scheme.name)
@pytest.mark.parametrize(
    "second",
    [
        tc.Plane(),
        tc.Box(center=(0.0, 0.0, -0.1), size=(1.0, 1.0, 0.2)),
        tc.Box(center=(0.0, 0.0, -0.1), size=(1.0, 1.0, 0.2), axes=TURN),
        *(leaning(10.0**power) for power in (-12, -9, -6)),
    ],
    ids=["plane", "box", "turned-box", "1e-12", "1e-9", "1e-6"],
)
def test_a_second_obstacle_flush_with_a_plane_changes_nothing(second, scheme):
    left, velocity = 0.001, (-0.5, 0.3, -3.0)
    one = landed([tc.Plane()], scheme(dt=5e-5), left, velocity)
    both = landed([tc.Plane(), second], scheme(dt=5e-5), left, velocity)
    assert one.history["impulse"][-1, 2] > 0.3
    assert np.abs(both.history["impulse"][-1] - one.history["impulse"][-1]).max() < 2e-6
    assert np.abs(both.position - one.position).max() < 2e-6 * 0.1
    assert both.history["gap_min"].min() > -1e-10 * 0.1


@pytest.mark.parametrize("scheme", SCHEMES, ids=lambda scheme: scheme.name)
@pytest.mark.parametrize("angle", [2e-6, 1.2e-5, 1e-4, 1e-3, 1e-2])
def test_nodes_in_a_flat_groove_are_held_as_on_a_plane(angle, scheme):
    """A block with nodes just above the line where two planes meet lands on both alike, its ends a little earlier."""
    velocity, height = (0.0, 0.0, -3.0), 1e-3 + 0.025 * angle  # halfway between the ends and the middle of the groove
    flat = landed([tc.Plane()], scheme(dt=5e-5), -0.05, velocity, height).history["impulse"][-1]
    groove = landed([leaning(-angle / 2.0), leaning(angle / 2.0)], scheme(dt=5e-5), -0.05, velocity, height)
    assert flat[2] > 0.1
    assert groove.history["gap_min"].min() > -1e-10 * 0.1
    assert np.abs(groove.history["impulse"][-1, :2]).max() < 1e-6 * flat[2]
    assert abs(groove.history["impulse"][-1, 2] / flat[2] - 1.0) < 1e-5 + 4.0 * angle
