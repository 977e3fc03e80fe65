"""Result files that were damaged: every change of a bit that would change what is read is found and named."""

import json
import os
import random
import shutil
import subprocess
import sys

import h5py
import numpy as np
import pytest
from frame_writer import write_run
from series import written
from stopped_runs import SCENES, same_files

import tcontact as tc
from tcontact.commands.cli import main
from tcontact.device import atomic_file
from tcontact.device.atomic_file import AtomicFile, read_undo, undo_path
from tcontact.results.files.vtkhdf import ResultData, ResultFile
from tcontact.show import render

FINE = tc.CentralDifference(cfl=0.3)


def everything(path):
    """All that a program can read of a result file."""
    data = ResultData.open(path)
    frames = [data.frame(index) for index in range(len(data))]
    found = {"points": data.points, "times": data.times} | {f"cells {kind}": cells for kind, cells in data.blocks}
    found |= {f"history {name}": column for name, column in data.history.items()}
    for index, frame in enumerate(frames):
        for part in (frame.point_data, frame.cell_data):
            found |= {f"frame {index} {name}": array for name, array in part.items()}
    return found, json.dumps(data.attributes)


def unlike(one, other):
    """Whether anything read differs."""
    arrays, others = one[0], other[0]
    if one[1] != other[1] or arrays.keys() != others.keys():
        return True
    return not all(np.array_equal(array, others[name], equal_nan=True) for name, array in arrays.items())


def flips(path, number, seed):
    """Turn single bits of the file, one at a time; yields what came of each: named, harmless or silent."""
    data, whole, generator = path.read_bytes(), everything(path), random.Random(seed)
    changed = path.with_name("changed.vtkhdf")
    for _ in range(number):
        damaged = bytearray(data)
        damaged[generator.randrange(len(data))] ^= 1 << generator.randrange(8)
        changed.write_bytes(damaged)
        try:
            yield "silent" if unlike(everything(changed), whole) else "harmless"
        except tc.InputError as error:
            assert str(changed) in str(error)  # noqa: PT017 - whatever else is raised fails the test
            yield "named"


@pytest.mark.parametrize("kind", ["large frames", "small frames"])
def test_no_flipped_bit_goes_by_in_silence(kind, tmp_path):
    """Bits of numbers, of metadata and of the index that leads to the numbers; those of free space change nothing."""
    path = tmp_path / "result.vtkhdf"
    if kind == "large frames":
        write_run(path, 6)
    else:
        path = written(tmp_path)
    found = list(flips(path, 150, 7))
    assert found.count("silent") == 0
    assert found.count("named") > 50


def test_a_flipped_bit_of_any_stored_number_is_found(tmp_path):
    """Change one number of every dataset: every HDF5 program is told by the file, and `ResultData` names the frame."""
    path = written(tmp_path)
    with h5py.File(path) as file:
        names = []
        file.visititems(lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) and item.size else None)
        places = {name: file[name].id.get_chunk_info(0).byte_offset for name in names}
        assert all(file[name].fletcher32 for name in names)
    data = path.read_bytes()
    for name, place in places.items():
        damaged = bytearray(data)
        damaged[place] ^= 4
        path.write_bytes(damaged)
        with h5py.File(path) as file, pytest.raises(OSError, match=r"error detected|filter returned failure"):
            file[name][()]


def test_a_chunk_that_is_missing_or_is_another_one_is_found(tmp_path):
    """What no checksum of HDF5 1.8 sees: the index leads elsewhere, and the numbers there are whole."""
    path = written(tmp_path)
    data = path.read_bytes()
    with h5py.File(path) as file:
        field = file["VTKHDF/PointData/displacement"]
        one, other = (field.id.get_chunk_info(k).byte_offset.to_bytes(8, "little") for k in (1, 2))
    assert data.count(one) == 1
    path.write_bytes(data.replace(one, other))
    assert len(ResultData.open(path)) == 4
    with pytest.raises(tc.InputError, match=r"frame 1 \(t = 0.0001 s\) is damaged.*another one"):
        ResultData.open(path).frame(1)
    for index in (0, 2, 3):
        ResultData.open(path).frame(index)


@pytest.fixture(scope="module")
def stopped(tmp_path_factory):
    """A run of the command line that Ctrl-C stopped, not to be written to."""
    folder = tmp_path_factory.mktemp("damage")
    tc.save_scene(SCENES["full removal"](), folder / "drop.toml")
    append = ResultFile.append

    def pressed(self, moment, *fields):
        if len(self) == 4:
            os.kill(os.getpid(), 2)
        append(self, moment, *fields)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(render, "render_frames", lambda *_, **__: [])
        patch.setattr(ResultFile, "append", pressed)
        assert main(["run", str(folder / "drop.toml"), "--frames", "7", "--quiet", "--out", str(folder / "run")]) == 1
    return folder / "run"


@pytest.mark.parametrize("command", ["render", "export", "info", "resume"])
def test_a_damaged_frame_is_named_by_every_command(command, stopped, tmp_path, capsys):
    place = shutil.copytree(stopped, tmp_path / "run")
    path = place / "result.vtkhdf"
    data = bytearray(path.read_bytes())
    with h5py.File(path) as file:
        start = file["VTKHDF/PointData/velocity"].id.get_chunk_info(2).byte_offset
    data[start + 100] ^= 1
    path.write_bytes(data)
    before = data if command == "resume" else None
    time = ResultData.open(path).times[2]
    assert main([command, str(place)]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert f"frame 2 (t = {time:.6g} s) is damaged" in said
    assert "frames 0 to 1, 3 to 5 are whole" in said
    if before is not None:
        assert path.read_bytes() == before


def test_a_file_of_an_older_version_is_read_but_not_gone_on_with(tmp_path):
    """It had no checksums and its attributes as text."""
    path = written(tmp_path)
    whole = everything(path)
    with h5py.File(path, "a") as file:
        own = file["tcontact"]
        text = own["attributes"][()].tobytes().decode()
        del own.attrs["format"], own["frames"], own["attributes"]
        own.create_dataset("attributes", data=text, dtype=h5py.string_dtype("utf-8"))
    assert not unlike(everything(path), whole)
    with pytest.raises(tc.InputError, match="older version"):
        ResultFile.reopen(path, 2)


def test_the_undo_file_is_on_the_device_before_the_file_changes(monkeypatch, tmp_path):
    """Order of a commit: undo written, synced; pages written, synced; undo emptied. Nothing else is safe."""
    path = tmp_path / "file"
    file = AtomicFile(path, "w")
    file.write(b"a" * 10000)
    file.commit()
    log = []
    for name in ("pwrite", "fsync", "ftruncate"):
        call = getattr(os, name)

        def watched(number, *arguments, name=name, call=call):
            log.append((name, os.readlink(f"/proc/self/fd/{number}").rpartition("/")[2]))
            return call(number, *arguments)

        monkeypatch.setattr(atomic_file.os, name, watched)
    for number in range(2):
        log.clear()
        file.seek(4000)
        file.write(bytes([66 + number]) * 200)
        file.seek(0, os.SEEK_END)
        file.write(b"more")
        file.commit()
        orders = [entry for entry in log if entry[1].startswith("file")]
        assert orders == [
            ("pwrite", "file"),  # beyond the end: nothing refers to it
            ("pwrite", "file.undo"), ("fsync", "file.undo"),
            ("pwrite", "file"), ("pwrite", "file"), ("fsync", "file"),
            ("ftruncate", "file.undo"),
        ]  # fmt: skip
    assert read_undo(path) is None
    file.close()
    assert not undo_path(path).exists()


def test_vtk_finds_a_damaged_frame(tmp_path):
    """ParaView reports an error where it drew wrong numbers before."""
    pytest.importorskip("vtkmodules.vtkIOHDF", exc_type=ImportError)
    path = written(tmp_path)
    data = bytearray(path.read_bytes())
    with h5py.File(path) as file:
        start = file["VTKHDF/PointData/displacement"].id.get_chunk_info(1).byte_offset
    data[start + 9] ^= 64
    path.write_bytes(data)
    code = (
        "import sys\nfrom vtkmodules.vtkIOHDF import vtkHDFReader\nreader = vtkHDFReader()\n"
        "reader.SetFileName(sys.argv[1])\nreader.SetStep(1)\nreader.Update()\n"
    )
    done = subprocess.run([sys.executable, "-c", code, str(path)], capture_output=True, text=True, check=False)
    assert "ERR" in done.stderr
    assert "displacement" in done.stderr or "data" in done.stderr.lower()


def test_a_resumed_run_has_the_checksums_of_one_that_never_stopped(stopped, monkeypatch, tmp_path):
    monkeypatch.setattr(render, "render_frames", lambda *_, **__: [])
    place = shutil.copytree(stopped, tmp_path / "run")
    assert main(["resume", str(place), "--quiet"]) == 0
    scene = str(stopped.parent / "drop.toml")
    assert main(["run", scene, "--frames", "7", "--quiet", "--out", str(tmp_path / "straight")]) == 0
    same_files(place, tmp_path / "straight")
    with h5py.File(place / "result.vtkhdf") as one, h5py.File(tmp_path / "straight/result.vtkhdf") as other:
        np.testing.assert_array_equal(one["tcontact/frames"], other["tcontact/frames"])
