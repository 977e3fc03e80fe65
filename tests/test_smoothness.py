"""Smoothness of a contact pressure: each number is what its formula says on pressures made up for it."""

from dataclasses import replace

import numpy as np
import pytest
import scenes

import tcontact as tc
from tcontact import report, smoothness
from tcontact.cases import cube_impact
from tcontact.lumped_mass import node_areas


def face(n=5, kind="hex8"):
    """Contact faces, nodes and area weights of the lower side of a cube of n^3 cells."""
    mesh = tc.box_mesh(size=(1, 1, 1), cells=(n, n, n), kind=kind)
    faces = mesh.faces_of("zmin")
    nodes = np.unique(faces)
    return mesh, faces, nodes, node_areas(mesh.nodes, faces)[nodes]


def test_a_force_that_rises_and_falls_once_has_variation_one():
    assert smoothness.force_variation(np.array([0.0, 1.0, 3.0, 3.0, 0.5, 0.0])) == pytest.approx(1.0)
    assert smoothness.force_variation(np.array([0.0, 3.0, 2.0, 3.0, 0.0])) == pytest.approx(8.0 / 6.0)


def test_peak_over_plateau_and_releases():
    force = np.array([0.0, 1.3, 1.0, 1.0, 1.0, 0.1, 0.0, 0.0, 0.5, 0.0])
    assert smoothness.peak_over_plateau(force) == pytest.approx(1.3)  # median of 1.3, 1, 1, 1, 0.5
    assert smoothness.releases(force) == 2


def test_grid_lines_are_the_lines_of_the_grid():
    """Middle nodes have neighbours in line on both sides: n - 1 inner places on each of n + 1 lines, two ways."""
    n = 5
    mesh, faces, nodes, _ = face(n)
    lines = smoothness.grid_lines(faces, nodes)
    assert len(lines) == 2 * (n + 1) * (n - 1)
    before, middle, after = (mesh.nodes[nodes[lines[:, i]]] for i in range(3))
    np.testing.assert_allclose(before + after, 2.0 * middle, atol=1e-14)


def test_triangles_have_no_grid_lines():
    _, faces, nodes, areas = face(3, "tet4")
    assert smoothness.grid_lines(faces, nodes).shape == (0, 3)
    assert np.isnan(smoothness.checkerboard(np.ones((4, len(nodes))), areas, np.zeros((0, 3), dtype=int)))


def test_checkerboard_is_one_for_a_checkerboard_and_zero_for_a_plane():
    mesh, faces, nodes, areas = face(6)
    lines = smoothness.grid_lines(faces, nodes)
    x, y = mesh.nodes[nodes, 0], mesh.nodes[nodes, 1]
    black = np.where(np.round(6 * (x + y)).astype(int) % 2 == 0, 2.0, 0.0)
    plane = 3.0 + 0.5 * x + 0.25 * y
    assert smoothness.checkerboard(np.array([black]), areas, lines) == pytest.approx(1.0, rel=0.05)
    assert smoothness.checkerboard(np.array([plane]), areas, lines) == pytest.approx(0.0, abs=1e-14)


def test_rows_with_little_force_do_not_count_for_the_checkerboard():
    mesh, faces, nodes, areas = face(4)
    lines = smoothness.grid_lines(faces, nodes)
    black = np.where(np.round(4 * mesh.nodes[nodes].sum(axis=1)).astype(int) % 2 == 0, 0.2, 0.0)
    assert smoothness.checkerboard(np.array([np.ones(len(nodes)), black]), areas, lines) == 0.0


def test_nodal_variation_sees_what_the_total_hides():
    """Two nodes that push in turn: their sum is constant, each of them goes up and down three times."""
    turn = np.array([[0, 0], [2, 0], [0, 2], [2, 0], [0, 2], [2, 0], [0, 2], [0, 0]], dtype=float)
    areas = np.array([1.0, 1.0])
    assert smoothness.force_variation(turn @ areas) == pytest.approx(1.0)
    assert smoothness.nodal_variation(turn, areas) == pytest.approx(12.0 / 2.0)


def test_a_record_divides_by_the_area_of_each_node():
    _, faces, nodes, areas = face(4)
    record = smoothness.PressureRecord(nodes, areas, faces)
    for size in (0.0, 5.0, 0.0):
        record.add(size * areas[:, None] * np.array([0.0, 0.6, 0.8]))
    np.testing.assert_allclose(record.pressure[1], 5.0, rtol=1e-6)
    assert record.numbers()["nodal_variation"] == pytest.approx(1.0, rel=1e-6)
    assert record.numbers()["checkerboard"] == pytest.approx(0.0, abs=1e-6)


def test_nothing_is_said_of_a_run_without_contact():
    result = scenes.simulate(cube_impact.scene(cells=2, duration=1e-5))
    assert report.smoothness_of(result) == {}
    assert report.run_attributes(result)["smoothness"] == {}


def test_every_summary_holds_the_numbers_and_they_tell_a_penalty_from_the_massless_method():
    found = {}
    for label in ("massless", "penalty"):
        result = scenes.simulate(cube_impact.scene(cells=6, contact=label))
        data = report.summary(result, case="cube-impact", parameters={}, checks=[])
        assert {"force_variation", "peak_over_plateau", "releases"} <= set(data["smoothness"])
        assert any("force variation" in line for line in report.lines(data))
        found[label] = data["smoothness"]["force_variation"]
    assert found["massless"] < 1.7 < 2.5 < found["penalty"]


def weights(result):
    """Nodes [k] and area weights of the contact faces of every body of a result."""
    found = []
    for body in result.scene.bodies:
        nodes = np.unique(body.contact_faces)
        found.append((nodes, node_areas(body.mesh.nodes, body.contact_faces)[nodes]))
    return found


@pytest.mark.parametrize(
    ("contact", "path"),
    [("massless", "serial"), ("penalty", "serial"), ("impulse", "serial"), ("massless", "parallel_path")],
)
def test_the_pressures_of_every_row_are_those_of_the_history(contact, path, request):
    """Their sum is the contact force of the row, their last row that of the result; the run is the same without."""
    if path != "serial":
        request.getfixturevalue(path)
    scene = cube_impact.scene(cells=3, contact=contact)
    plain, result = scenes.simulate(scene), scenes.simulate(scene, pressures=True)
    assert plain.contact_pressures == ()
    for name, column in plain.history.items():
        np.testing.assert_allclose(column, result.history[name], rtol=1e-7, atol=1e-9 * np.abs(column).max())
    (record,), ((nodes, areas),) = result.contact_pressures, weights(result)
    assert set(record.nodes) == set(nodes)
    assert record.areas.sum() == pytest.approx(areas.sum())
    force = result.history["contact_force"][:, 2]
    np.testing.assert_allclose(record.pressure @ record.areas, force, rtol=1e-5, atol=1e-6 * force.max())
    last = np.linalg.norm(result.contact_node_force[record.nodes], axis=1) / record.areas
    np.testing.assert_allclose(record.pressure[-1], last, rtol=1e-6)


def test_thinned_rows_keep_their_pressures():
    scene = cube_impact.scene(cells=3, duration=1.1e-3)
    full, thin = (scenes.simulate(scene, pressures=True, history_every=every) for every in (1, 7))
    rows = [*range(0, full.steps, 7), full.steps]
    assert full.steps % 7
    assert np.array_equal(thin.contact_pressures[0].pressure, full.contact_pressures[0].pressure[rows])


def test_every_body_that_can_touch_has_a_record():
    one, two = (cube_impact.scene(cells=2, duration=5e-4, size=size).bodies[0] for size in (0.1, 0.08))
    away = replace(two, contact=None, displacement=(1.0, 0.0, 0.0), name="away")
    two = replace(two, displacement=(0.3, 0.0, 0.0), name="other")
    scene = tc.Scene(bodies=[one, away, two], obstacles=[tc.Plane()], duration=5e-4)
    result = scenes.simulate(scene, pressures=True)
    total = sum(record.pressure @ record.areas for record in result.contact_pressures)
    assert len(result.contact_pressures) == 2
    force = result.history["contact_force"][:, 2]
    np.testing.assert_allclose(total, force, rtol=1e-5, atol=1e-6 * force.max())


def test_pressures_is_true_or_false():
    with pytest.raises(tc.InputError, match="pressures"):
        tc.simulate(cube_impact.scene(cells=2), pressures=1)


def test_the_cube_is_pressed_smoothly_by_the_massless_method_and_not_by_a_penalty():
    """16^3 hexes at 10 km/h."""
    result = scenes.simulate(cube_impact.scene(), pressures=True)
    found = report.smoothness_of(result)
    assert found["force_variation"] <= 1.4
    assert found["nodal_variation"] <= 1.6
    assert found["checkerboard"] <= 0.02
    assert found["releases"] == 1
    data = report.summary(result, case="cube-impact", parameters={}, checks=[])
    assert data["smoothness"] == found
    assert any("checkerboard" in line for line in report.lines(data))
    wild = report.smoothness_of(scenes.simulate(cube_impact.scene(contact="penalty"), pressures=True))
    assert wild["nodal_variation"] > 5.0 * found["nodal_variation"]
    assert wild["checkerboard"] > 10.0 * found["checkerboard"]
