"""What a run writes: frames, history and summary are exactly what it returns."""

import csv
import json

import numpy as np
import oracle
import pytest
from scenes import simulate, thrown, twin

import tcontact as tc
from tcontact.results.files.vtkhdf import ResultData


@pytest.fixture(scope="module", params=["hex8", "tet4"])
def recorded(request, tmp_path_factory):
    scene = thrown("neo", request.param, contact=tc.MasslessContact(removal="full"), duration=1.2)
    out = tmp_path_factory.mktemp("run") / "out"
    result = simulate(scene, out=out, frames=5)
    return scene, result, out, ResultData.open(out / "result.vtkhdf")


def test_the_last_frame_is_the_result(recorded):
    scene, result, _, data = recorded
    mesh = scene.bodies[0].mesh
    frame = data.frame(-1).point_data
    assert np.array_equal(data.points, mesh.nodes)
    assert np.array_equal(frame["displacement"] + mesh.nodes, result.position)
    assert np.array_equal(frame["velocity"], result.velocity)
    assert np.array_equal(frame["contact_force"], result.contact_node_force)
    assert np.abs(frame["contact_force"]).max() > 0.0


def test_pressure_and_stress_are_those_of_the_oracle(recorded):
    scene, result, _, data = recorded
    body, there = scene.bodies[0], twin(scene.bodies[0])
    frame = data.frame(-1)
    area = oracle.face_area_weights(there.nodes, there.contact_faces)
    touching = area > 0.0
    force = np.linalg.norm(result.contact_node_force, axis=1)
    assert np.allclose(frame.point_data["contact_pressure"][touching], (force[touching] / area[touching]), rtol=1e-12)
    assert not frame.point_data["contact_pressure"][~touching].any()
    stress = oracle.von_mises(there.nodes, there.cells, there.kind, there.law, result.position - there.nodes)
    assert np.allclose(frame.cell_data["von_mises"], stress, rtol=1e-9, atol=1e-9 * stress.max())
    assert len(stress) == body.mesh.cell_count


def test_frames_are_spread_over_the_run_first_and_last_included(recorded):
    scene, result, _, data = recorded
    rows = np.round(np.linspace(0, result.steps, 5)).astype(int)
    assert np.array_equal(data.times, result.history["time"][rows])
    assert np.array_equal(data.frame(0).point_data["velocity"], scene.bodies[0].initial_velocity)
    assert np.abs(data.frame(0).point_data["displacement"]).max() <= 1e-15
    for number, row in enumerate(rows):
        force = data.frame(number).point_data["contact_force"].sum(axis=0)
        wanted = result.history["contact_force"][row]
        assert np.allclose(force, wanted, rtol=1e-12, atol=1e-12 * np.abs(result.history["contact_force"]).max())


def test_every_frame_is_a_state_of_the_run(recorded):
    """Elastic energy and momentum of each frame are those of its row."""
    scene, result, _, data = recorded
    there, mass = twin(scene.bodies[0]), tc.plan(scene).bodies[0].mass
    quad = oracle.quadrature(there.nodes, there.cells, there.kind)
    rows = np.round(np.linspace(0, result.steps, 5)).astype(int)
    for number, row in enumerate(rows):
        frame = data.frame(number).point_data
        elastic = oracle.energy(quad, there.law, frame["displacement"])
        assert elastic == pytest.approx(result.history["elastic"][row], rel=1e-10, abs=1e-12)
        momentum = np.einsum("nij,nj->i", mass, frame["velocity"])
        assert np.allclose(momentum, result.history["momentum"][row], rtol=1e-11, atol=1e-10)


def test_history_files_hold_every_digit(recorded):
    _, result, out, data = recorded
    for name, column in result.history.items():
        assert np.array_equal(data.history[name], column), name
    with (out / "history.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == result.steps + 1
    assert np.array_equal([float(row["kinetic"]) for row in rows], result.history["kinetic"])
    assert np.array_equal([float(row["contact_force_z"]) for row in rows], result.history["contact_force"][:, 2])
    summary = json.loads((out / "summary.json").read_text())
    assert summary["steps"] == result.steps
    assert summary["reason"] == "finished"
    assert summary["dt"] == result.dt


def test_writing_changes_nothing(recorded):
    scene, result, _, _ = recorded
    quiet = simulate(scene)
    assert np.array_equal(quiet.position, result.position)
    assert np.array_equal(quiet.velocity, result.velocity)
    for name, column in quiet.history.items():
        assert np.array_equal(result.history[name], column), name


def test_without_out_nothing_is_written(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    simulate(thrown(contact=tc.MasslessContact(), duration=0.3), frames=3)
    assert list(tmp_path.iterdir()) == []
