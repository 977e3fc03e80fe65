"""Result files that show parts, written by hand: two hexahedra side by side, each the part of a rank."""

import shutil

import numpy as np
import pytest

from tcontact.errors import InputError
from tcontact.mesh.box import box_mesh
from tcontact.results.files.joined_file import join_parts
from tcontact.results.files.master_file import MasterFile, PartSize
from tcontact.results.files.part_file import PartFile, PartMesh
from tcontact.results.files.part_places import PartPlace, part_path
from tcontact.results.files.vtkhdf import ResultData

WHOLE = box_mesh((2.0, 1.0, 1.0), (2, 1, 1))
TIMES = (0.0, 0.5)


def part_of(rank):
    """The part of a rank: the first one owns the nodes between the cells."""
    cell = WHOLE.cells[rank]
    owned = np.setdiff1d(cell, WHOLE.cells[0]) if rank else np.sort(cell)
    nodes = np.concatenate([owned, np.setdiff1d(cell, owned)])
    shown = np.concatenate([np.sort(WHOLE.cells[0]), np.setdiff1d(WHOLE.cells[1], WHOLE.cells[0])])
    place = {node: at for at, node in enumerate(nodes)}
    blocks = [("hex8", np.array([[place[node] for node in cell]]))]
    numbers = np.array([int(np.flatnonzero(shown == node)[0]) for node in nodes])
    return PartMesh(PartPlace(nodes, len(owned), np.array([rank])), WHOLE.nodes[nodes], blocks, numbers, 8 * rank)


def written(folder, factor=1.0):
    """Write a result with a field at nodes and one of cells; return its file."""
    path, parts = folder / "result.vtkhdf", [part_of(rank) for rank in (0, 1)]
    part_path(path, 0).parent.mkdir(parents=True)
    files = [PartFile.start(part_path(path, rank), part, {}, {}) for rank, part in enumerate(parts)]
    sizes = [PartSize(len(part.points), part.place.owned, 1, 8) for part in parts]
    with MasterFile.start(path, sizes, {}, ()) as master:
        for time in TIMES:
            for part, file in zip(parts, files, strict=True):
                nodes = factor * (time + 1.0) * part.place.nodes
                file.append(time, {"number": nodes}, {"cell": factor * part.place.cells.astype(float)})
            master.add(time, np.array([file.check for file in files]), files[0].fields)
    for file in files:
        file.close()
    return path


def test_parts_are_read_as_the_mesh_of_the_user(tmp_path):
    data = ResultData.open(written(tmp_path))
    assert np.array_equal(data.points, WHOLE.nodes)
    assert np.array_equal(data.blocks[0][1], WHOLE.cells)
    for index, time in enumerate(TIMES):
        frame = data.frame(index)
        assert np.array_equal(frame.point_data["number"], (time + 1.0) * np.arange(12))
        assert np.array_equal(frame.cell_data["cell"], [0.0, 1.0])


def test_a_whole_part_of_another_run_is_refused(tmp_path):
    """It has the same mesh and times, and its own checksums are right."""
    path, other = written(tmp_path / "one"), written(tmp_path / "other", factor=2.0)
    shutil.copy(part_path(other, 1), part_path(path, 1))
    with pytest.raises(InputError, match="its parts are not those of one frame"):
        ResultData.open(path).frame(0)


def test_parts_become_one_file_with_the_frames_that_are_kept(tmp_path):
    path = written(tmp_path)
    known = ResultData.open(path).frame(0)
    join_parts(path, 1)
    data = ResultData.open(path)
    assert (len(data), data.parts) == (1, ())
    assert not part_path(path, 0).exists()
    assert np.array_equal(data.frame(0).point_data["number"], known.point_data["number"])
    assert [one.name for one in tmp_path.iterdir() if "joined" in one.name] == []
