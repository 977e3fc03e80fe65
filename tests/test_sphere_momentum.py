"""A ball without friction cannot turn a body about its centre, however the body spins and where it hits (METHOD 1)."""

import numpy as np
import pytest
from scenes import material, simulate

import tcontact as tc

CENTRE, RADIUS, GAP = np.array([0.3, -0.2, 0.1]), 0.5, 1e-3


def spun(contact, inside=False):
    """Result of a spinning block that hits the ball off its middle, or the shell around it."""
    side = -1.0 if inside else 1.0
    low = RADIUS - 0.234 if inside else RADIUS + GAP  # the top corners of the block are 2 mm from the shell
    mesh = tc.box_mesh((0.2, 0.2, 0.2), (4, 4, 4), origin=CENTRE + np.array([-0.07, -0.12, low]))
    spin, middle = np.array([3.0, -2.0, 40.0]), mesh.nodes.mean(axis=0)
    velocity = side * np.array([1.0, 2.0, -6.0]) + np.cross(spin, mesh.nodes - middle)
    body = tc.Body(mesh, material(), velocity=velocity, contact="zmax" if inside else "zmin")
    ball = tc.Sphere(CENTRE, RADIUS, inside=inside)
    return simulate(tc.Scene([body], [ball], duration=4e-3, contact=contact), cfl=0.5)


def drift(result):
    """Largest change of the angular momentum about the centre, over the largest of it."""
    history = result.history
    about = history["angular_momentum"] - np.cross(CENTRE, history["momentum"])
    turned = np.linalg.norm(history["momentum"] - history["momentum"][0], axis=1).max()
    assert turned > 0.3 * np.linalg.norm(history["momentum"][0])  # a hard hit
    assert np.linalg.norm(history["contact_force"], axis=1).max() > 1e4
    return np.linalg.norm(about - about[0], axis=1).max() / np.linalg.norm(about, axis=1).max()


@pytest.mark.parametrize("inside", [False, True], ids=["ball", "shell"])
def test_angular_momentum_about_the_centre_is_kept_to_the_tolerance_of_the_static_solve(inside):
    loose, tight = (drift(spun(tc.MasslessContact("full", tolerance=bound), inside)) for bound in (1e-4, 1e-10))
    assert tight <= 1e-9
    assert drift(spun(tc.MasslessContact("full"), inside)) <= 1e-6
    assert tight < 1e-3 * loose  # it is the solve that errs, nothing else
