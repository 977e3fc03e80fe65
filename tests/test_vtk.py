"""VTK itself reads what a run leaves: steps, times, mesh, every field of every frame, exactly (package vtk)."""

from __future__ import annotations

import numpy as np
import pytest

from tcontact.errors import InputError
from tcontact.export import export
from tcontact.vtkhdf import ResultData, ResultFile

hdf = pytest.importorskip("vtkmodules.vtkIOHDF", exc_type=ImportError)
model = pytest.importorskip("vtkmodules.vtkCommonExecutionModel", exc_type=ImportError)
common = pytest.importorskip("vtkmodules.vtkCommonDataModel", exc_type=ImportError)
xml = pytest.importorskip("vtkmodules.vtkIOXML", exc_type=ImportError)
support = pytest.importorskip("vtkmodules.util.numpy_support", exc_type=ImportError)
POINTS = np.random.default_rng(3).random((12, 3))
HEXES = np.array([[0, 1, 2, 3, 4, 5, 6, 7], [4, 5, 6, 7, 8, 9, 10, 11]])
TETS = np.array([[0, 1, 2, 8], [3, 4, 5, 9], [9, 10, 11, 0]])
TIMES = [0.0, 1e-4, 3e-4, 7e-4]


def fields(index: int) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """What frame `index` holds."""
    rng = np.random.default_rng(index)
    return {"displacement": rng.normal(size=(12, 3)), "contact_pressure": rng.random(12)}, {"von_mises": rng.random(5)}


@pytest.fixture
def path(tmp_path):
    """A series of hexahedra and tetrahedra, of two bodies."""
    body = {"body": np.array([0, 0, 1, 1, 1])}
    with ResultFile.create(tmp_path / "result.vtkhdf", POINTS, [("hex8", HEXES), ("tet4", TETS)], {}, body) as file:
        for index, time in enumerate(TIMES):
            file.append(time, *fields(index))
        file.write_history({"time": np.array(TIMES)})
    return tmp_path / "result.vtkhdf"


def check(grid, index: int) -> None:
    """The grid VTK holds is frame `index`."""
    array = support.vtk_to_numpy
    cells = grid.GetCells()
    np.testing.assert_array_equal(array(cells.GetConnectivityArray()), [*HEXES.ravel(), *TETS.ravel()])
    np.testing.assert_array_equal(array(cells.GetOffsetsArray()), [0, 8, 16, 20, 24, 28])
    assert [grid.GetCellType(cell) for cell in range(5)] == [12, 12, 10, 10, 10]
    np.testing.assert_array_equal(array(grid.GetPoints().GetData()), POINTS)
    nodal, cellwise = fields(index)
    for data, expected in ((grid.GetPointData(), nodal), (grid.GetCellData(), cellwise)):
        for name, values in expected.items():
            np.testing.assert_array_equal(array(data.GetArray(name)), values, err_msg=name)
    np.testing.assert_array_equal(array(grid.GetCellData().GetArray("body")), [0, 0, 1, 1, 1])


def test_vtk_reads_steps_times_and_fields_of_a_result_exactly(path):
    reader = hdf.vtkHDFReader()
    assert reader.CanReadFile(str(path))
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    assert reader.GetNumberOfSteps() == len(TIMES)
    found = reader.GetOutputInformation(0).Get(model.vtkStreamingDemandDrivenPipeline.TIME_STEPS())
    np.testing.assert_array_equal(found, TIMES)
    for index in (0, 3, 1, 2):
        reader.UpdateTimeStep(TIMES[index])  # as ParaView asks for it
        check(reader.GetOutputDataObject(0), index)
        assert reader.GetOutputDataObject(0).GetInformation().Get(common.vtkDataObject.DATA_TIME_STEP()) == TIMES[index]


def test_vtk_reads_a_file_whose_run_was_killed(path):
    """What a kill may leave: the next frame's fields without its time."""
    import h5py

    with h5py.File(path, "a") as file:
        steps = file["VTKHDF/Steps"]
        steps["Values"].resize(len(TIMES) - 1, axis=0)
    reader = hdf.vtkHDFReader()
    reader.SetFileName(str(path))
    reader.SetStep(2)
    reader.Update()
    check(reader.GetOutputDataObject(0), 2)


@pytest.mark.parametrize("ending", ["vtu", "xdmf"])
def test_an_exported_series_is_the_same(path, tmp_path, ending):
    import meshio

    written = export(ResultData.open(path), tmp_path / "out", ending)
    if ending == "vtu":
        for index, file in enumerate(written[:-1]):
            reader = xml.vtkXMLUnstructuredGridReader()
            reader.SetFileName(str(file))
            reader.Update()
            check(reader.GetOutput(), index)
        return
    (index_file,) = (file for file in written if file.suffix == ".xdmf")
    with meshio.xdmf.TimeSeriesReader(index_file) as series:
        points, cells = series.read_points_cells()
        np.testing.assert_array_equal(points, POINTS)
        assert [block.type for block in cells] == ["hexahedron", "tetra"]
        for index in range(len(TIMES)):
            time, nodal, cellwise = series.read_data(index)
            assert time == TIMES[index]
            for name, values in fields(index)[0].items():
                np.testing.assert_array_equal(nodal[name], values)
            np.testing.assert_array_equal(np.concatenate(cellwise["von_mises"]), fields(index)[1]["von_mises"])


def test_export_refuses_what_it_cannot_do(path, tmp_path):
    data = ResultData.open(path)
    with pytest.raises(InputError, match="vtu, xdmf"):
        export(data, tmp_path / "out", "stl")
    with pytest.raises(InputError, match="von_mises"):
        export(data, tmp_path / "out", "vtu", fields=["heat"])
    with pytest.raises(InputError, match="frames"):
        export(data, tmp_path / "out", "vtu", every=0)
    assert not (tmp_path / "out").exists()
