"""A crushed cell is told with its det F when it was crushed, and with a remedy that ends in a finished run."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scenes import block, material, wall

import tcontact as tc
from tcontact.planning.body_plan import SMALL

SAID = re.compile(r"cell (\d+) of body-0 .* has det F = (\S+) at t")


def crash(kind="hex8", share=0.8, cells=(3, 3, 6), scheme=None, **options):
    """A bar thrown end on at a wall with that share of its dilatational wave speed."""
    mesh, mat = block(kind, cells, (0.1, 0.1, 0.2), shake=0.0), material("neo")
    c = mat.wave_speed
    body = tc.Body(mesh, mat, velocity=(0.0, 0.0, -share * c), contact="zmin")
    scene = tc.Scene([body], [wall(mesh, (0, 0, 1.0), 1e-3)], duration=0.3 / c, **options)
    return tc.simulate(scene, scheme or tc.CentralDifference())


@pytest.mark.parametrize("kind", ["hex8", "tet4"])
@pytest.mark.parametrize("small", [0, 10**6])
def test_the_value_is_that_of_the_first_bad_row(kind, small, monkeypatch):
    """Not of the position after it, where the body has blown up to det F of 1e20."""
    for name in SMALL:
        monkeypatch.setitem(SMALL, name, small)
    result = crash(kind)
    assert result.reason == "inverted-cell"
    value = float(SAID.search(result.message)[2])
    assert -10.0 < value <= 0.0


def test_the_cell_and_its_value_are_those_of_the_oracle(monkeypatch):
    """The run is made again up to the bad row, with the same steps; det F by hand of a tetrahedron there."""
    bad = crash("tet4", 0.85)
    cell, value = int(SAID.search(bad.message)[1]), float(SAID.search(bad.message)[2])
    scene = bad.scene
    end = tc.simulate(tc.Scene(scene.bodies, scene.obstacles, duration=bad.time), tc.CentralDifference())
    assert end.steps == bad.steps
    corners = scene.bodies[0].mesh.cells[cell]
    edges = [np.diff(x[corners[[0, 0, 0, 1, 2, 3]]].reshape(2, 3, 3), axis=0)[0] for x in
             (scene.bodies[0].mesh.nodes, end.position)]  # fmt: skip
    assert np.linalg.det(edges[1]) / np.linalg.det(edges[0]) == pytest.approx(value, rel=2e-3, abs=1e-6)


@pytest.mark.parametrize("kind", ["hex8", "tet4"])
def test_the_remedy_ends_in_a_finished_run(kind):
    """A lower cfl does not help hexahedra at 0.8 of the wave speed; bulk viscosity does, as the message says."""
    advice = crash(kind).message
    assert "viscosity=tc.BulkViscosity()" in advice
    if kind == "hex8":
        assert crash(kind, scheme=tc.CentralDifference(cfl=0.3)).reason == "inverted-cell"
    assert crash(kind, viscosity=tc.BulkViscosity()).ok


def test_implicit_schemes_take_no_viscosity_and_are_not_told_to():
    result = crash("hex8", 6.0, contact=tc.PenaltyContact(1e12), scheme=tc.Trapezoidal(cfl=1.0))
    if result.reason == "inverted-cell":
        assert "central-difference" in result.message


@pytest.mark.parametrize("frames", [0, 1, 3])
def test_a_start_with_an_inverted_cell_is_the_state_in_which_the_run_stops(frames, tmp_path):
    """Not the one after a step, however many frames are written."""
    mesh = tc.box_mesh((0.1, 0.1, 0.1), (4, 4, 4))
    moved = np.stack([3.0 * mesh.nodes[:, 0], -0.5 * mesh.nodes[:, 1], 20.0 * mesh.nodes[:, 0] ** 2], axis=1)
    body = tc.Body(mesh, material("neo"), displacement=moved - 1.4 * mesh.nodes * [0.0, 0.0, 1.0])
    result = tc.simulate(tc.Scene([body], duration=1e-5), frames=frames, out=tmp_path / "run" if frames else None)
    assert (result.reason, result.steps) == ("inverted-cell", 0)
    assert np.allclose(result.position, body.initial_nodes, rtol=0.0, atol=1e-15)
    assert not result.velocity.any()
    again = tc.simulate(tc.Scene([replace(body, displacement=None)], duration=1e-5), initial=result)
    assert np.array_equal(again.position, result.position)  # also where another run has given the start
    if frames:
        shown = result.frames.frame(-1 % len(result.frames.times)).point_data["displacement"]
        assert np.allclose(shown, body.initial_displacement, rtol=1e-6, atol=1e-9)
