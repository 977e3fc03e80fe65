"""The result file gives back what was put in, follows the VTKHDF layout and survives a killed run."""

import shutil

import h5py
import numpy as np
import pytest

from tcontact.base.errors import InputError
from tcontact.device.atomic_file import AtomicFile
from tcontact.results.files.vtkhdf import ResultData, ResultFile

POINTS, CELLS = 12, 5


def _mesh():
    rng = np.random.default_rng(7)
    points = rng.random((POINTS, 3))
    hexes = np.array([[0, 1, 2, 3, 4, 5, 6, 7], [4, 5, 6, 7, 8, 9, 10, 11]])
    tets = np.array([[0, 1, 2, 8], [3, 4, 5, 9], [9, 10, 11, 0]])
    return points, [("hex8", hexes), ("tet4", tets)]


def _fields(seed):
    rng = np.random.default_rng(seed)
    point = {"displacement": rng.normal(size=(POINTS, 3)), "contact_pressure": rng.random(POINTS)}
    return point, {"von_mises": rng.random(CELLS) * 1e6}


def _written(path, frames=4, **options):
    file = ResultFile.create(
        path, *_mesh(), {"title": "a run", "size": np.float64(0.1), "cells": np.array([1, 2])}, **options
    )
    for index in range(frames):
        file.append(0.25 * index, *_fields(index))
    return file


def _same(data, index):
    frame = data.frame(index)
    point, cell = _fields(index)
    assert frame.time == 0.25 * index
    for name, array in point.items():
        np.testing.assert_array_equal(frame.point_data[name], array)
    np.testing.assert_array_equal(frame.cell_data["von_mises"], cell["von_mises"])


def test_everything_comes_back_exactly(tmp_path):
    body = np.array([0, 0, 1, 1, 1])
    with _written(tmp_path / "r.vtkhdf", static_cell_data={"body": body}) as file:
        assert len(file) == 4
    data = ResultData.open(tmp_path / "r.vtkhdf")
    points, blocks = _mesh()
    assert len(data) == 4
    assert data.cells == CELLS
    np.testing.assert_array_equal(data.points, points)
    np.testing.assert_array_equal(data.times, [0.0, 0.25, 0.5, 0.75])
    assert [kind for kind, _ in data.blocks] == ["hex8", "tet4"]
    for (_, found), (_, given) in zip(data.blocks, blocks, strict=True):
        np.testing.assert_array_equal(found, given)
    assert data.attributes == {"title": "a run", "size": 0.1, "cells": [1, 2]}
    for index in range(4):
        _same(data, index)
        np.testing.assert_array_equal(data.frame(index).cell_data["body"], body)
    assert data.frame(-1).time == 0.75


def test_layout_follows_the_specification(tmp_path):
    _written(tmp_path / "r.vtkhdf", static_cell_data={"body": np.arange(CELLS)}).close()
    with h5py.File(tmp_path / "r.vtkhdf") as file:
        root = file["VTKHDF"]
        assert list(root.attrs["Version"]) == [2, 0]
        kind = root.attrs.get_id("Type")
        assert root.attrs["Type"] == b"UnstructuredGrid"
        assert kind.get_type().is_variable_str() is False  # readers reject strings of variable length
        ids = 2 * 8 + 3 * 4
        assert [root[n][0] for n in ("NumberOfPoints", "NumberOfCells", "NumberOfConnectivityIds")] == [
            POINTS,
            CELLS,
            ids,
        ]
        np.testing.assert_array_equal(root["Offsets"], [0, 8, 16, 20, 24, 28])
        np.testing.assert_array_equal(root["Types"], [12, 12, 10, 10, 10])
        assert root["Types"].dtype == np.uint8
        assert root["Connectivity"].shape == (ids,)
        steps = root["Steps"]
        assert steps.attrs["NSteps"] == 4
        for name, shape in (
            ("PartOffsets", (4,)),
            ("PointOffsets", (4,)),
            ("CellOffsets", (4, 1)),
            ("ConnectivityIdOffsets", (4, 1)),
        ):
            assert steps[name].shape == shape
            assert not steps[name][()].any()
        np.testing.assert_array_equal(steps["NumberOfParts"], np.ones(4))
        np.testing.assert_array_equal(steps["PointDataOffsets/displacement"], POINTS * np.arange(4))
        np.testing.assert_array_equal(steps["CellDataOffsets/von_mises"], CELLS * np.arange(4))
        np.testing.assert_array_equal(steps["CellDataOffsets/body"], np.zeros(4))
        assert root["PointData/displacement"].shape == (4 * POINTS, 3)
        assert root["CellData/body"].shape == (CELLS,)


def test_a_killed_run_keeps_its_frames(tmp_path):
    file = _written(tmp_path / "r.vtkhdf", frames=3)
    file.write_history({"time": np.arange(5.0)})
    shutil.copy(tmp_path / "r.vtkhdf", tmp_path / "killed.vtkhdf")  # what is on disk when the process dies now
    for index in range(3, 6):
        file.append(0.25 * index, *_fields(index))
    data = ResultData.open(tmp_path / "killed.vtkhdf")
    assert len(data) == 3
    for index in range(3):
        _same(data, index)
    np.testing.assert_array_equal(data.history["time"], np.arange(5.0))
    assert len(ResultData.open(tmp_path / "r.vtkhdf")) == 6  # and a running one can be looked at
    file.close()
    file.close()


def test_places_of_many_frames_are_written_ahead_and_end_with_the_frames(tmp_path):
    """More frames than one write has places for; some are dropped and written again, a part of them together."""
    path, body = tmp_path / "r.vtkhdf", np.array([0, 0, 1, 1, 1])
    _written(path, frames=70, static_cell_data={"body": body}).close()
    with ResultFile.reopen(path, 62) as file:
        for index in range(62, 131):
            file.append(0.25 * index, *_fields(index), commit=index % 3 == 0)
            assert file.kept == (62 if index < 63 else index // 3 * 3 + 1)
    data = ResultData.open(path)
    assert len(data) == 131
    for index in range(131):
        _same(data, index)
    with h5py.File(path) as file:
        steps = file["VTKHDF/Steps"]
        np.testing.assert_array_equal(steps["NumberOfParts"], np.ones(131))
        np.testing.assert_array_equal(steps["PointDataOffsets/displacement"], POINTS * np.arange(131))
        np.testing.assert_array_equal(steps["CellDataOffsets/body"], np.zeros(131))
        assert [steps[name].shape[0] for name in ("PartOffsets", "CellOffsets", "Values")] == [131] * 3


def test_an_unfinished_frame_does_not_count(tmp_path, monkeypatch):
    """After every stage there are at least as many steps as times (else VTK's reader crashes); all frames are whole.

    The copies are without the undo file, as VTK sees the file.
    """
    states = []
    file = _written(tmp_path / "r.vtkhdf", frames=2)
    bring = AtomicFile._bring

    def bring_and_copy(self, *arguments):
        bring(self, *arguments)
        states.append(shutil.copy(tmp_path / "r.vtkhdf", tmp_path / f"{len(states)}.vtkhdf"))

    monkeypatch.setattr(AtomicFile, "_bring", bring_and_copy)
    file.append(0.5, *_fields(2))
    file.close()
    counts = []
    for path in states:
        with h5py.File(path) as copy:
            steps = copy["VTKHDF/Steps"]
            assert len(steps["Values"]) <= steps.attrs["NSteps"] <= len(steps["NumberOfParts"])
        data = ResultData.open(path)
        counts.append(len(data))
        for index in range(len(data)):
            _same(data, index)
    assert counts == [2, 2, 3, 3]  # the last when it is closed


def test_history_grows_shrinks_and_changes_columns(tmp_path):
    with _written(tmp_path / "r.vtkhdf") as file:
        for rows in (10, 9000, 20):
            history = {"time": np.arange(float(rows)), "force": np.ones((rows, 3)) * rows, "sweeps": np.arange(rows)}
            file.write_history(history)
            found = ResultData.open(tmp_path / "r.vtkhdf").history
            assert found.keys() == history.keys()
            for name in history:
                np.testing.assert_array_equal(found[name], history[name])
        file.write_history({"time": np.zeros((4, 2))})
    found = ResultData.open(tmp_path / "r.vtkhdf").history
    assert list(found) == ["time"]
    assert found["time"].shape == (4, 2)


def test_attributes_can_be_replaced(tmp_path):
    with _written(tmp_path / "r.vtkhdf") as file:
        file.write_attributes({"reason": "finished", "path": tmp_path})
    assert ResultData.open(tmp_path / "r.vtkhdf").attributes == {"reason": "finished", "path": str(tmp_path)}


def test_a_bad_frame_is_refused_and_leaves_no_trace(tmp_path):
    point, cell = _fields(9)
    with _written(tmp_path / "r.vtkhdf", frames=2) as file:
        wrong = [
            ({"displacement": point["displacement"]}, cell),
            ({**point, "displacement": point["displacement"][:-1]}, cell),
            ({**point, "displacement": point["displacement"][:, :2]}, cell),
            ({**point, "contact_pressure": np.array(["a"] * POINTS)}, cell),
            (point, {**cell, "extra": np.zeros(CELLS)}),
            (point, {"a/b": np.zeros(CELLS)}),
        ]
        for frame in wrong:
            with pytest.raises(InputError):
                file.append(1.0, *frame)
        file.append(0.5, *_fields(2))
    data = ResultData.open(tmp_path / "r.vtkhdf")
    assert len(data) == 3
    _same(data, 2)


@pytest.mark.parametrize(
    ("points", "blocks"),
    [
        (np.zeros((3, 2)), [("tet4", np.zeros((1, 4), int))]),
        (np.zeros((4, 3)), []),
        (np.zeros((4, 3)), [("wedge", np.zeros((1, 6), int))]),
        (np.zeros((4, 3)), [("tet4", np.zeros((1, 8), int))]),
        (np.zeros((4, 3)), [("tet4", np.array([[0, 1, 2, 4]]))]),
    ],
)
def test_a_bad_mesh_is_refused_before_the_file_exists(tmp_path, points, blocks):
    with pytest.raises(InputError):
        ResultFile.create(tmp_path / "r.vtkhdf", points, blocks)
    assert not list(tmp_path.iterdir())


def test_files_that_are_no_results_are_refused(tmp_path):
    _written(tmp_path / "whole.vtkhdf", frames=6).close()
    content = (tmp_path / "whole.vtkhdf").read_bytes()
    (tmp_path / "cut.vtkhdf").write_bytes(content[: len(content) // 2])
    (tmp_path / "empty.vtkhdf").write_bytes(b"")
    (tmp_path / "text.vtkhdf").write_text("no result\n" * 100)
    with h5py.File(tmp_path / "foreign.vtkhdf", "w") as file:
        file["something"] = np.arange(3)
    for name in ("cut", "empty", "text", "foreign", "absent"):
        with pytest.raises(InputError, match="a run wrote"):
            ResultData.open(tmp_path / f"{name}.vtkhdf")


@pytest.mark.parametrize("options", [{}, {"locking": True}, {"locking": False}, {"mode": "r+"}])
def test_a_file_that_the_program_has_open_is_read(tmp_path, options):
    """HDF5 opens a file a second time only with the locking of the first."""
    path = tmp_path / "r.vtkhdf"
    _written(path).close()
    with h5py.File(path, **({"mode": "r"} | options)):
        _same(ResultData.open(path), 3)


def test_frames_outside_the_series_are_refused(tmp_path):
    _written(tmp_path / "r.vtkhdf", frames=2).close()
    data = ResultData.open(tmp_path / "r.vtkhdf")
    for index in (2, -3, 1.5, "0"):
        with pytest.raises(InputError, match="2 frames"):
            data.frame(index)
