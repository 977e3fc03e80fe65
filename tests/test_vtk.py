"""VTK itself reads what a run leaves: steps, times, mesh, every field of every frame, exactly (package vtk)."""

from __future__ import annotations

import shutil

import numpy as np
import pytest
from series import HEXES, POINTS, TETS, TIMES, fields, written

from tcontact.results.exporting import export
from tcontact.results.files.vtkhdf import ResultData, ResultFile

hdf = pytest.importorskip("vtkmodules.vtkIOHDF", exc_type=ImportError)
model = pytest.importorskip("vtkmodules.vtkCommonExecutionModel", exc_type=ImportError)
common = pytest.importorskip("vtkmodules.vtkCommonDataModel", exc_type=ImportError)
xml = pytest.importorskip("vtkmodules.vtkIOXML", exc_type=ImportError)
support = pytest.importorskip("vtkmodules.util.numpy_support", exc_type=ImportError)


@pytest.fixture
def path(tmp_path):
    """A series of two bodies."""
    return written(tmp_path)


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


def test_vtk_reads_a_file_whose_run_was_killed(path, tmp_path):
    """What a kill may leave: the next frame's fields without its time; places of frames that are not there yet."""
    import h5py

    with ResultFile.reopen(path, len(TIMES) - 1) as file:
        file.append(TIMES[-1], *fields(len(TIMES) - 1))
        shutil.copy(path, tmp_path / "killed.vtkhdf")
    with h5py.File(tmp_path / "killed.vtkhdf", "a") as file:
        steps = file["VTKHDF/Steps"]
        assert len(steps["NumberOfParts"]) > len(TIMES)
        steps["Values"].resize(len(TIMES) - 1, axis=0)
    reader = hdf.vtkHDFReader()
    reader.SetFileName(str(tmp_path / "killed.vtkhdf"))
    for index in (2, 3):
        reader.SetStep(index)
        reader.Update()
        check(reader.GetOutputDataObject(0), index)


def test_vtk_reads_an_exported_series_exactly(path, tmp_path):
    files = export(ResultData.open(path), tmp_path / "out", "vtu")
    assert len(files) == len(TIMES) + 1
    for index, file in enumerate(files[:-1]):
        reader = xml.vtkXMLUnstructuredGridReader()
        reader.SetFileName(str(file))
        reader.Update()
        check(reader.GetOutput(), index)
