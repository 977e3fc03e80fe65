"""The cylinder of rolling-cylinder: its mesh is one, and sliding ends in rolling at 2/3 of the speed."""

import numpy as np
import pytest
from scenes import simulate

import tcontact as tc
from tcontact.cases import rolling_cylinder
from tcontact.results import checks as ck


def test_a_run_that_ends_while_the_cylinder_slides_is_checked():
    """Its friction too, up to the end: `--set duration=` may stop it there."""
    result = simulate(rolling_cylinder.scene(cells=8, duration=0.02), cfl=0.9)
    assert result.time < 0.7 * rolling_cylinder.sliding_time(result.scene)
    found = {check.name: check for check in rolling_cylinder.checks(result)}
    assert found["friction / (mu pressure), sliding"].passed
    assert "rolling speed, error" not in found


@pytest.mark.parametrize("cells", [4, 11])
def test_the_disc_is_one(cells):
    mesh = tc.cylinder_mesh(2.0, 0.3, cells, axis="y", layers=1)
    sides = 4 * cells
    polygon = sides / 2 * np.sin(2 * np.pi / sides)
    assert ck.volume(mesh) == pytest.approx(polygon * 4.0 * 0.3, rel=1e-12)
    rim = mesh.nodes[np.unique(mesh.faces_of(["rim"]))]
    np.testing.assert_allclose(np.hypot(rim[:, 0], rim[:, 2]), 2.0, rtol=1e-12)
    assert len(rim) == 2 * sides
    assert len(mesh.faces_of(["rim"])) == sides
    assert len(mesh.faces_of(["ymin"])) == len(mesh.faces_of(["ymax"])) == len(mesh.cells)
    corners = mesh.nodes[mesh.cells]
    for corner, (a, b, c) in enumerate(  # the Jacobian is positive in every corner
        [(1, 3, 4), (2, 0, 5), (3, 1, 6), (0, 2, 7), (7, 5, 0), (4, 6, 1), (5, 7, 2), (6, 4, 3)]
    ):
        edges = corners[:, [a, b, c]] - corners[:, [corner]]
        assert np.linalg.det(edges).min() > 0.3 * ck.volume(mesh) / len(mesh.cells)


def test_a_cylinder_that_slides_ends_in_rolling():
    result = simulate(rolling_cylinder.scene(cells=12, friction=0.3), cfl=0.9)
    assert tc.plan(result.scene).bodies[0].contact.removal == "full"
    found = {check.name: check for check in rolling_cylinder.checks(result)}
    assert len(found) == 12
    assert not [check for check in found.values() if not check.passed]
    assert found["friction work, error"].value <= 0.05
    # once it rolls friction takes nothing more
    history, slid = result.history, rolling_cylinder.sliding_time(result.scene)
    work = history["friction_work"]
    assert work[-1] - work[history["time"] > 1.1 * slid][0] <= 1e-2 * work[-1]


@pytest.mark.parametrize("wrong", [{"cells": 2.5}, {"cells": 2}, {"speed": 0.0}, {"friction": 0.0}, {"gravity": -1.0}])
def test_bad_input_names_the_field(wrong):
    with pytest.raises(tc.InputError, match=next(iter(wrong))):
        rolling_cylinder.scene(**wrong)
