"""The largest contact force of a run is that of one obstacle or pair, not of the sum in which they cancel."""

import json

import numpy as np
import pytest
from scenes import material

import tcontact as tc
from tcontact.commands.info import contents
from tcontact.planning.measured import Layout
from tcontact.results import report
from tcontact.results.acting_force import acting_force
from tcontact.results.files.vtkhdf import ResultData, ResultFile
from tcontact.run.peaks import Peaks
from tcontact.show import notebook, plots
from tcontact.show.page.facts import ledger_rows
from tcontact.show.render.key_frame import key_frame

RUBBER = tc.NeoHookean(1e7, 0.3, 1000.0)


def squeezed():
    """Return a block between two planes, of which the upper one comes down."""
    mesh = tc.box_mesh((0.02, 0.02, 0.01), (2, 2, 2))
    planes = [tc.Plane(name="low"), tc.Plane((0, 0, 0.01), (0, 0, -1), velocity=(0, 0, -1.0), name="up")]
    return tc.Scene([tc.Body(mesh, RUBBER, contact=["zmin", "zmax"])], planes, duration=5e-4)


def hammered():
    """Return a hammer on an anvil that is held, and a pebble that falls on a floor."""
    anvil = tc.Body(tc.box_mesh((0.1, 0.1, 0.05), (2, 2, 1)), RUBBER, contact="zmax", name="anvil",
                    supports=[tc.Support("zmin", "xyz")])  # fmt: skip
    mesh = tc.box_mesh((0.05, 0.05, 0.05), (1, 1, 1), origin=(0.025, 0.025, 0.0501))
    hammer = tc.Body(mesh, RUBBER, (0, 0, -3.0), contact="zmin", name="hammer")
    pebble = tc.box_mesh((0.005, 0.005, 0.005), (1, 1, 1), origin=(0.2, 0.0, 0.0))
    bodies = [anvil, hammer, tc.Body(pebble, RUBBER, (0, 0, -0.1), contact="zmin", name="pebble")]
    return tc.Scene(bodies, [tc.Plane((0, 0, -1e-5), name="floor")], duration=5e-4)


@pytest.mark.parametrize(
    ("scene", "column", "partner"),
    [
        (squeezed, "obstacle_force:up", "on up"),
        (hammered, "pair_force:anvil-hammer", "of pair anvil-hammer"),
    ],
)
def test_the_largest_force_is_that_of_one_partner_and_names_it(scene, column, partner, tmp_path):
    """Summary, smoothness, info, web page and notebook judge by the partner with the largest force."""
    result = tc.simulate(scene(), out=tmp_path / "run", frames=2)
    size = np.linalg.norm(result.history[column], axis=1)
    assert size.max() > 4.0 * np.linalg.norm(result.history["contact_force"], axis=1).max()
    summary = json.loads((tmp_path / "run/summary.json").read_text(encoding="utf-8"))
    assert summary["contact_force_max"] == size.max()
    assert summary["contact_force_of"] == column
    loaded = size[size > 0.2 * size.max()]
    assert summary["smoothness"]["peak_over_plateau"] == pytest.approx(size.max() / np.median(loaded), rel=1e-12)
    assert any(f"of the force {partner}" in line for line in report.lines(summary | {"case": "run", "checks": []}))
    words = f"{report.si(size.max(), 'N')} at most {partner}"
    assert notebook.rows(result)["contact force"] == words
    assert any(f"at most {report.si(size.max(), 'N')} {partner}" in line for line in contents(result.file))
    stored = tc.open_result(tmp_path / "run")
    rows = dict(ledger_rows(stored))
    assert rows["contact force, largest"] == f"{report.si(size.max(), 'N', 4)} {partner}"
    walls = [np.array([0.0, 0.0, sign]) for sign in (1.0, -1.0)]
    np.testing.assert_array_equal(plots.force_component(result.history, walls), size)


def test_a_single_partner_has_the_contact_force_of_all_bodies():
    """One obstacle, at rest or moving, and one pair alone keep their numbers and are not named."""
    total, zero = np.array([[0.0, 0.0, 3.0]]), np.zeros((1, 3))
    assert acting_force({"contact_force": total}).force is total
    moving = acting_force({"contact_force": total, "obstacle_force:ram": -total})
    assert (moving.force is total, moving.partner, moving.largest) == (True, "", 3.0)
    pair = acting_force({"contact_force": 1e-12 * total, "pair_force:a-b": total})
    assert (pair.force is total, pair.partner) == (True, "")
    both = acting_force({"contact_force": 2.0 * total, "pair_force:a-b": total})
    assert (both.largest, both.partner) == (6.0, " on the obstacle")
    assert acting_force({"contact_force": zero, "obstacle_force:a": zero, "obstacle_force:b": zero}).largest == 0.0


@pytest.fixture(scope="module")
def pressed(tmp_path_factory):
    """A cube in three frames: squeezed most in the second one, pushed by one plane alone in the third one."""
    mesh, path = tc.box_mesh((1.0, 1.0, 1.0), (2, 2, 2)), tmp_path_factory.mktemp("pressed") / "result.vtkhdf"
    planes = [{"kind": "plane", "point": [0, 0, z], "normal": [0, 0, 1 - 2 * z]} for z in (0, 1)]
    low, up = (mesh.nodes[:, 2] == z for z in (0, 1))
    with ResultFile.create(path, mesh.nodes, [("hex8", mesh.cells)], {"obstacles": planes}) as file:
        for time, below, above in ((0.0, 0.0, 0.0), (1e-3, 900.0, 890.0), (2e-3, 90.0, 0.0)):
            force = np.zeros_like(mesh.nodes)
            force[low, 2], force[up, 2] = below / 9.0, -above / 9.0
            nodal = {"displacement": 0 * force, "contact_force": force, "contact_pressure": np.abs(force[:, 2])}
            file.append(time, nodal, {"von_mises": np.zeros(mesh.cell_count)})
    return path


def test_the_contact_face_is_of_the_frame_with_the_largest_force_of_a_partner(pressed, tmp_path):
    """The net force of a squeezed block is largest where it is squeezed least; the caption says force and time."""
    data = ResultData.open(pressed)
    found = key_frame(data, data.frame, alone=False)
    assert found.frame.time == 1e-3
    assert found.note == "contact force in this frame at 1 ms"  # without a history no partner is known
    whole = tmp_path / "result.vtkhdf"
    whole.write_bytes(pressed.read_bytes())
    up = np.array([0.0, 0.0, 1.0])
    history = {
        "time": np.array([0.0, 0.5e-3, 1e-3, 2e-3]),
        "contact_force": np.outer([0.0, 5.0, 10.0, 90.0], up),
        "obstacle_force:low": np.outer([0.0, -1200.0, -900.0, -90.0], up),
        "obstacle_force:up": np.outer([0.0, 1195.0, 890.0, 0.0], up),
    }
    with ResultFile.reopen(whole, 3) as file:
        file.write_history(history)
    data = ResultData.open(whole)
    found = key_frame(data, data.frame, alone=False)
    assert found.note == "contact force in this frame: 900 N on low at 1 ms"
    np.testing.assert_array_equal(found.push, up)


@pytest.mark.parametrize("kept", [{"history_every": 3}, {"history_every": 7}, {"history_rows": 2}])
def test_the_largest_values_count_every_step(kept):
    """Summary and result have the bits of a run that keeps all rows, also where rows are dropped as the run goes on."""

    def scene():
        mesh = tc.box_mesh((0.1, 0.1, 0.1), (3, 3, 3))
        body = tc.Body(mesh, material(), (0, 0, -2.7778), contact="zmin")
        return tc.Scene([body], [tc.Plane((0, 0, -1e-3))], duration=2e-3)

    full, thin = (tc.simulate(scene(), **options) for options in ({}, kept))
    assert len(thin.history["time"]) < len(full.history["time"])
    size = np.linalg.norm(full.history["contact_force"], axis=1)
    assert thin.peaks == full.peaks
    assert full.peaks == {"energy_error": full.history["energy_error"].max(), "contact_force": size.max()}
    assert np.linalg.norm(thin.history["contact_force"], axis=1).max() < size.max()
    for name in ("energy_error_max", "contact_force_max"):
        assert report.run_attributes(thin)[name] == report.run_attributes(full)[name]
    assert f"energy error {full.peaks['energy_error']:.2g}" in repr(thin)


def test_largest_values_of_a_checkpoint_are_taken_over_with_or_without_their_time():
    """Checkpoints of earlier versions hold the start, the change and the forces, without the time of the change."""
    peaks = Peaks(Layout())
    forces = np.arange(1.0, 1.0 + len(peaks.names))
    for saved, when in ((np.array([2.0, 0.5, *forces]), 0.0), (np.array([2.0, 0.5, 1e-3, *forces]), 1e-3)):
        peaks.restore(saved)
        assert (peaks.change, peaks.when) == (0.5, when)
        assert peaks.columns(1.0) == {"energy_error": 0.5} | dict(zip(peaks.names, forces, strict=True))
        assert np.array_equal(peaks.checkpoint(), [2.0, 0.5, when, *forces])
