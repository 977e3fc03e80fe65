"""Exported series hold what the result file holds, bit for bit; meshio reads them."""

from __future__ import annotations

from xml.etree import ElementTree

import meshio
import numpy as np
import pytest
from series import POINTS, TIMES, fields, written

from tcontact.base.errors import InputError
from tcontact.results.exporting import export
from tcontact.results.files.vtkhdf import ResultData


@pytest.fixture
def data(tmp_path) -> ResultData:
    """A series of two bodies."""
    return ResultData.open(written(tmp_path))


def test_a_vtu_series_is_the_same_and_has_its_times(data, tmp_path):
    *files, collection = export(data, tmp_path / "out", "vtu")
    for index, file in enumerate(files):
        grid = meshio.read(file)
        np.testing.assert_array_equal(grid.points, POINTS)
        assert [block.type for block in grid.cells] == ["hexahedron", "tetra"]
        nodal, cellwise = fields(index)
        for name, values in nodal.items():
            np.testing.assert_array_equal(grid.point_data[name], values)
        np.testing.assert_array_equal(np.concatenate(grid.cell_data["von_mises"]), cellwise["von_mises"])
    rows = ElementTree.parse(collection).getroot().iter("DataSet")
    assert [(float(row.get("timestep")), row.get("file")) for row in rows] == [
        (time, file.name) for time, file in zip(TIMES, files, strict=True)
    ]


def test_an_xdmf_series_is_the_same(data, tmp_path):
    *_, index_file = export(data, tmp_path / "out", "xdmf")
    with meshio.xdmf.TimeSeriesReader(index_file) as series:
        points, cells = series.read_points_cells()
        np.testing.assert_array_equal(points, POINTS)
        assert [block.type for block in cells] == ["hexahedron", "tetra"]
        assert series.num_steps == len(TIMES)
        for index in range(len(TIMES)):
            time, nodal, cellwise = series.read_data(index)
            assert time == TIMES[index]
            for name, values in fields(index)[0].items():
                np.testing.assert_array_equal(nodal[name], values)
            np.testing.assert_array_equal(np.concatenate(cellwise["von_mises"]), fields(index)[1]["von_mises"])


def test_a_shorter_series_leaves_nothing_of_a_longer_one(data, tmp_path):
    export(data, tmp_path / "out", "vtu")
    (tmp_path / "out" / "notes.txt").write_text("mine", encoding="utf-8")
    *files, _ = export(data, tmp_path / "out", "vtu", fields=["displacement"], every=3)
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert names == {"frame-0000.vtu", "frame-0001.vtu", "series.pvd", "notes.txt"}
    assert set(meshio.read(files[1]).point_data) == {"displacement"}
    np.testing.assert_array_equal(meshio.read(files[1]).point_data["displacement"], fields(3)[0]["displacement"])
    rows = ElementTree.parse(tmp_path / "out" / "series.pvd").getroot().iter("DataSet")
    assert [float(row.get("timestep")) for row in rows] == list(TIMES[::3])


def test_export_refuses_what_it_cannot_do(data, tmp_path):
    for wrong, word in (
        ({"format": "stl"}, "'vtu', 'xdmf'"),
        ({"fields": ["heat"]}, "von_mises"),
        ({"every": 0}, "whole number"),
        ({"every": True}, "whole number"),
    ):
        with pytest.raises(InputError, match=word):
            export(data, tmp_path / "out", **wrong)
    assert not (tmp_path / "out").exists()
    (tmp_path / "taken").write_text("mine", encoding="utf-8")
    with pytest.raises(InputError, match="another folder"):
        export(data, tmp_path / "taken")
