"""Friction at nodes that keep mass in some directions alone: one cone for what the kick and the static solve give."""

import numpy as np
from scenes import material, simulate

import tcontact as tc

MU = 0.3


def test_friction_of_the_kick_and_of_the_static_solve_share_one_cone():
    """Normal removal with a wall far away along x: nodes have no mass along x and z, friction along y is in the kick.

    One wall alone is touched, in a slide across the corner of the two directions: the force of the body is in its cone.
    """
    mesh = tc.box_mesh((0.06, 0.06, 0.04), (3, 3, 2), origin=(0.0, 0.0, 1e-4))
    scene = tc.Scene(
        [tc.Body(mesh, material("linear"), (6.0, 6.0, -4.0), contact="zmin")],
        [tc.Plane(), tc.Plane((-1.0, 0.0, 0.0), (1.0, 0.0, 0.0))],
        duration=6e-4,
        contact=tc.MasslessContact(removal="normal"),
        friction=tc.Coulomb(MU),
    )
    force = simulate(scene).history["contact_force"][:-1]  # the last kick is half a kick
    force = force[force[:, 2] > 1e-3 * force[:, 2].max()]
    along, most = np.abs(force[:, :2]), MU * force[:, 2]
    assert len(force) >= 3
    assert (np.linalg.norm(along, axis=1) <= (1.0 + 1e-6) * most).all()
    assert (np.linalg.norm(along, axis=1) >= 0.95 * most).all()  # it slides
    assert (along >= 0.4 * most[:, None]).all()  # along both, so that neither alone shows in the bound
