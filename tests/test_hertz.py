"""The ball of hertz-impact: its mesh is a ball, its impact that of Hertz, and nearer to it on a finer mesh."""

import numpy as np
import pytest

import tcontact as tc
from tcontact import checks as ck
from tcontact.cases import _round_meshes, hertz_impact


def test_the_quarter_ball_is_one():
    mesh = _round_meshes.quarter_ball(2.0, 0.06, 6)
    assert ck.volume(mesh) == pytest.approx(np.pi / 3 * 8.0, rel=2e-2)
    assert np.linalg.norm(mesh.nodes, axis=1).max() == pytest.approx(2.0, rel=1e-12)
    cap = mesh.nodes[np.unique(mesh.faces_of(["cap"]))]
    np.testing.assert_allclose(np.linalg.norm(cap, axis=1), 2.0, rtol=1e-12)


@pytest.mark.slow
def test_the_impact_is_that_of_hertz_and_nearer_on_a_finer_mesh():
    errors = []
    for cells in (4, 8):
        scene = hertz_impact.scene(cells=cells)
        assert hertz_impact.cells_across(scene) == cells
        found = {check.name: check for check in hertz_impact.checks(tc.simulate(scene))}
        assert all(check.passed for check in found.values()), found
        errors.append(found["largest force, error"].value)
    assert errors[1] < errors[0]
