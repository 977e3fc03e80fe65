"""The result file of several ranks shows the parts of all of them: other programs, moved folders, what is missing."""

import shutil

import h5py
import numpy as np
import pytest
from rank_scenes import SCENES
from test_ranks import mpiexec, pytestmark  # noqa: F401 - skips these tests where MPI is missing

import tcontact as tc
from tcontact.commands.cli import main as command
from tcontact.errors import InputError
from tcontact.results.files.vtkhdf import ResultData

RANKS = 3


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """Runs of three ranks that have ended, and one that a signal has stopped, in folders of their own."""
    folder = tmp_path_factory.mktemp("kept")
    done = mpiexec(RANKS, "rank_results.py", folder, "mixed", "halves", timeout=300)
    assert done.returncode == 0, done.stderr
    mpiexec(RANKS, "rank_resumed.py", folder / "stopped", "signalled", "walls", timeout=300)
    return folder


@pytest.fixture
def moved(kept, tmp_path):
    """A copy of all that in another place."""
    return shutil.copytree(kept, tmp_path / "moved")


def shown(data):
    """Return the nodes and cells of the user in the order in which other programs see them."""
    nodes = np.concatenate([part.place.nodes[: part.place.owned] for part in data.parts])
    return nodes, np.concatenate([part.place.cells for part in data.parts])


@pytest.mark.parametrize("name", ["mixed", "halves"])
def test_vtk_reads_the_frames_of_all_ranks_as_one_grid_from_a_moved_folder(moved, name):
    vtk = pytest.importorskip("vtk")
    numpy_of = pytest.importorskip("vtk.util.numpy_support").vtk_to_numpy
    path = moved / name / "result.vtkhdf"
    data, reader = ResultData.open(path), vtk.vtkHDFReader()
    nodes, cells = shown(data)
    corners = [row for _, rows in data.blocks for row in rows]
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    assert reader.GetNumberOfSteps() == len(data)
    for index, time in enumerate(data.times):
        reader.SetStep(index)
        reader.Update()
        assert reader.GetTimeValue() == time
        grid, frame = reader.GetOutputDataObject(0), data.frame(index)
        assert np.array_equal(numpy_of(grid.GetPoints().GetData()), data.points[nodes])
        ends, flat = (numpy_of(getattr(grid.GetCells(), f"Get{one}Array")()) for one in ("Offsets", "Connectivity"))
        for number, cell in enumerate(cells):
            assert np.array_equal(nodes[flat[ends[number] : ends[number + 1]]], corners[cell])
        for field, values in frame.point_data.items():
            assert np.array_equal(numpy_of(grid.GetPointData().GetArray(field)), values[nodes], equal_nan=True)
        for field, values in frame.cell_data.items():
            assert np.array_equal(numpy_of(grid.GetCellData().GetArray(field)), values[cells], equal_nan=True)


def test_no_rank_has_all_nodes_and_the_file_itself_has_no_values_of_them(kept):
    path = kept / "halves" / "result.vtkhdf"
    data = ResultData.open(path)
    assert sum(part.place.owned for part in data.parts) == len(data.points)
    assert max(len(part.points) for part in data.parts) < 0.8 * len(data.points)
    with h5py.File(path) as file:
        for group in ("PointData", "CellData"):
            assert all(array.is_virtual for array in file["VTKHDF"][group].values())
        assert all(file["VTKHDF"][name].is_virtual for name in ("Points", "Connectivity", "Offsets", "Types"))


def test_a_missing_part_is_named(moved, capsys):
    folder = moved / "mixed"
    lost = folder / "result-parts" / "1.vtkhdf"
    lost.unlink()
    with pytest.raises(InputError, match=r"result-parts.1.vtkhdf is missing"):
        ResultData.open(folder / "result.vtkhdf")
    (folder / "summary.json").unlink()
    assert command(["info", str(folder)]) == 2
    assert str(lost) in capsys.readouterr().err
    with h5py.File(folder / "result.vtkhdf") as file:
        assert np.isnan(file["VTKHDF/Points"][()]).any()  # other programs see no nodes at the origin


def test_parts_of_another_run_are_refused(moved):
    part = "result-parts/1.vtkhdf"
    shutil.copy(moved / "halves" / part, moved / "mixed" / part)
    with pytest.raises(InputError, match="parts of another run"):
        ResultData.open(moved / "mixed" / "result.vtkhdf")


def test_a_part_with_other_values_is_refused(moved):
    path = moved / "mixed" / "result-parts" / "1.vtkhdf"
    with h5py.File(path, "r+") as file:
        values = file["VTKHDF/PointData/velocity"]
        values[...] = 2.0 * values[()]
    with pytest.raises(InputError, match=r"frame 1 .* is damaged"):
        ResultData.open(moved / "mixed" / "result.vtkhdf").frame(1)


def test_ranks_that_find_a_damaged_result_file_all_end(moved):
    """Not the one that read it alone; `mpiexec` raises `TimeoutExpired` if the others wait for it."""
    path = moved / "stopped" / "walls" / "result.vtkhdf"
    path.write_bytes(path.read_bytes()[:3000])
    done = mpiexec(RANKS, "rank_resumed.py", moved / "stopped", "resumed", "walls", timeout=120)
    assert done.returncode != 0
    assert "result.vtkhdf" in done.stderr
    assert "ends all ranks" not in done.stderr  # all know why


@pytest.mark.parametrize("ranks", [RANKS, 2, 1])
def test_a_run_goes_on_with_its_parts_or_as_one_file(kept, moved, ranks):
    """On as many ranks the parts go on; other ranks, or one process, make one file of them first."""
    folder = moved / "stopped" / "walls"
    before = ResultData.open(folder / "result.vtkhdf")
    assert len(before.parts) == RANKS
    frames = [before.frame(index) for index in range(2)]
    if ranks > 1:
        done = mpiexec(ranks, "rank_resumed.py", moved / "stopped", "resumed", "walls", timeout=300)
        assert done.returncode == 0, done.stderr
    else:
        with pytest.warns(RuntimeWarning, match="3 ranks"):
            tc.resume(folder, SCENES["walls"](), progress=False)
    data = ResultData.open(folder / "result.vtkhdf")
    assert len(data.parts) == (RANKS if ranks == RANKS else 0)
    assert (folder / "result-parts").exists() == (ranks == RANKS)
    assert len(data) == 5
    assert data.attributes["reason"] == "finished"
    for index, known in enumerate(frames):
        for field, values in known.point_data.items():
            assert np.array_equal(values, data.frame(index).point_data[field])
    assert not [path.name for path in folder.iterdir() if "joined" in path.name]


@pytest.mark.parametrize(("rank", "which"), [(1, "part"), (0, "part"), (0, "full"), (0, "file")])
def test_a_frame_that_one_rank_cannot_write_stops_all_and_keeps_those_before(tmp_path, rank, which):
    done = mpiexec(2, "rank_unwritten.py", tmp_path / "run", rank, which, timeout=200)
    assert done.returncode == 0, done.stderr
    told = [(tmp_path / f"run.{one}").read_text(encoding="utf-8") for one in range(2)]
    assert all(text.startswith("not-written: ") and "No space left on device" in text for text in told)
    data = ResultData.open(tmp_path / "run" / "result.vtkhdf")
    assert len(data) == 1
    assert np.isfinite(data.frame(0).point_data["velocity"]).all()


def test_a_new_run_takes_the_place_of_the_parts_of_an_old_one(moved):
    from tcontact.commands.folder import our_files

    ours = {str(path.relative_to(moved / "mixed")) for path in our_files(moved / "mixed")}
    assert {f"result-parts/{rank}.vtkhdf" for rank in range(RANKS)} <= ours
