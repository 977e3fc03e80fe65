"""Kills, full disks, folders that cannot be written, two runs at once: nothing complete is lost or damaged."""

import errno
import json
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import threading
from contextlib import contextmanager
from pathlib import Path

import h5py
import numpy as np
import pytest
from frame_writer import DROPPED, ROWS, frame, write_run
from scenes import ROOT, python
from stopped_runs import SCENES, copied, quietly, same, same_files

import tcontact as tc
from tcontact.commands.cli import main
from tcontact.device import atomic_file
from tcontact.results import frame_fields
from tcontact.results.files.vtkhdf import ResultData, ResultFile
from tcontact.run.checkpoint import store

FRAMES = 6
FINE = tc.CentralDifference(cfl=0.3)


def whole(path):
    """The frames in a file; each must be what was written."""
    data = ResultData.open(path)
    for index in range(len(data)):
        assert data.times[index] == 0.5 * index
        for name, values in data.frame(index).point_data.items():
            assert np.array_equal(values, frame(index)[name])
    history = data.history
    if history:
        assert np.array_equal(history["time"], np.arange(float(len(history["time"]))))
        assert len(history["time"]) in ROWS
    return len(data)


class Disk:
    """Calls `look` before everything that changes the disk, and in the middle of every write."""

    def __init__(self, monkeypatch, look):
        self.look = look
        for name in ("pwrite", "ftruncate"):
            monkeypatch.setattr(atomic_file.os, name, self._watched(getattr(os, name), name == "pwrite"))
        for name in ("unlink", "replace"):
            monkeypatch.setattr(Path, name, self._watched(getattr(Path, name), False))
        write_bytes = Path.write_bytes

        def torn(path, data):
            for end in (0, len(data) // 2, len(data)):
                look()
                write_bytes(path, data[:end])

        monkeypatch.setattr(Path, "write_bytes", torn)

    def _watched(self, call, torn):
        def watched(*arguments, **options):
            self.look()
            if torn and len(arguments[1]) > 1:
                call(arguments[0], bytes(arguments[1][: len(arguments[1]) // 2]), arguments[2])
                self.look()
            return call(*arguments, **options)

        return watched


def test_a_result_file_is_whole_at_every_instant(monkeypatch, tmp_path):
    """A kill between any two operations on the disk, or amid a write, leaves every frame that was ever whole."""
    path, counts, sure, seen = tmp_path / "result.vtkhdf", [], [0], set()

    def look():
        if not path.exists() or path.stat().st_size == 0:
            assert sure[0] == 0
            return
        state = hash((path.read_bytes(), undo.read_bytes() if undo.exists() else None))
        if state in seen:
            return
        seen.add(state)
        try:
            counts.append(whole(path))
        except tc.InputError:
            assert sure[0] == 0  # the mesh was being written
            return
        assert sure[0] <= counts[-1] <= sure[0] + 1 or counts[-1] == FRAMES  # those dropped may still be there
        repaired = tmp_path / "repaired"  # as a resume does it
        shutil.copy(path, repaired)
        if undo.exists():
            shutil.copy(undo, atomic_file.undo_path(repaired))
        with monkeypatch.context() as patch:
            patch.undo()
            atomic_file.roll_back(repaired)
        with h5py.File(repaired) as file:
            steps = file["VTKHDF/Steps"]
            assert len(steps["Values"]) <= steps.attrs["NSteps"]

    def done(count):
        sure[0] = count

    undo = atomic_file.undo_path(path)
    with monkeypatch.context() as patch:
        Disk(patch, look)
        write_run(path, FRAMES, done)
    look()
    assert whole(path) == FRAMES
    assert len(seen) > 5 * FRAMES
    assert not undo.exists()


def test_one_whole_checkpoint_is_there_at_every_instant(monkeypatch, tmp_path):
    sure, looks = [-1], []

    def look():
        good, _ = store.read_all(tmp_path)
        looks.append([stored.row for stored in good])
        assert sure[0] < 0 or looks[-1][0] >= sure[0]
        for stored in good:
            assert np.array_equal(stored.found["u"], np.full(500, float(stored.row)))

    with monkeypatch.context() as patch:
        Disk(patch, look)
        for row in range(8):
            store.write(tmp_path, {"row": row}, {"x": row}, {"u": np.full(500, float(row))})
            sure[0] = row
    look()
    assert looks[-1] == [7, 6]


def kills(folder, number, seed):
    """Kill a writer at random moments; returns how many frames were checked."""
    generator, checked = random.Random(seed), 0
    for kill in range(number):
        place = folder / str(kill)
        place.mkdir()
        command, seen = [sys.executable, str(ROOT / "tests/frame_writer.py"), str(place)], {"PYTHONPATH": str(ROOT)}
        writer = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=os.environ | seen)
        first = writer.stdout.readline()
        threading.Event().wait(generator.uniform(0.0, 0.25))
        writer.send_signal(signal.SIGKILL)
        said = [first, *writer.stdout.readlines()]
        writer.wait()
        last = [int(word) for word in said[-1].split()] if said[-1].endswith("\n") else None
        for path in place.glob("*.vtkhdf"):
            try:
                count = whole(path)
            except tc.InputError:
                assert last is None or int(path.stem) > last[0], "a file with frames cannot be read"
                continue
            if last is not None and int(path.stem) == last[0]:
                assert count >= min(last[1], 14 - DROPPED)
                checked += count
            atomic_file.roll_back(path)
            with h5py.File(path) as file:
                assert file["VTKHDF/Steps"].attrs["NSteps"] >= count
    return checked


def test_kills_at_random_moments(tmp_path):
    assert kills(tmp_path, 6, 3) > 0


@pytest.mark.slow
def test_two_hundred_kills(tmp_path):
    assert kills(tmp_path, 200, 4) > 200


RUN = """
import os, sys, threading, tcontact as tc
from tcontact.run.checkpoint.keeper import Keeper
from stopped_runs import SCENES, quietly
saves, save = [0], Keeper.save
def counted(self, run, row):
    save(self, run, row)
    saves[0] += 1
    if saves[0] == 2:  # dies soon, in the middle of something
        threading.Timer(float(sys.argv[2]), os.kill, (os.getpid(), 9)).start()
Keeper.save = counted
fine, options = tc.CentralDifference(cfl=0.04), {"every_steps": 20}
physics = SCENES["full removal"]()
if len(sys.argv) > 3:
    quietly(tc.resume, sys.argv[1], physics, fine, threads=1, checkpoint=options)
else:
    quietly(tc.simulate, physics, fine, out=sys.argv[1], frames=60, threads=1, checkpoint=options)
"""


def test_a_run_that_is_killed_again_and_again_ends_with_the_same_bits(tmp_path):
    physics, fine = SCENES["full removal"](), tc.CentralDifference(cfl=0.04)
    straight = quietly(tc.simulate, physics, fine, out=tmp_path / "straight", frames=60)
    place = tmp_path / "killed"
    for delay, again in ((0.0, []), (0.03, ["again"])):
        done = python(RUN, place, delay, *again)
        assert done.returncode == -signal.SIGKILL, done.stderr
        assert len(ResultData.open(place / "result.vtkhdf")) > 0
        assert main(["info", str(place)]) == 0
    same(quietly(tc.resume, place, physics, fine), straight)
    same_files(place, tmp_path / "straight")


@contextmanager
def largest_file(size):
    """No file can grow beyond this many bytes: what a full disk does, without one."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_a_full_disk_keeps_the_frames_and_the_run_goes_on_when_there_is_room(tmp_path):
    physics = SCENES["full removal"]()
    straight = tc.simulate(physics, FINE, out=tmp_path / "straight", frames=30)
    place = tmp_path / "full"
    with (
        largest_file(150_000),
        pytest.raises(tc.OutputError, match=r"File too large.*make room, then `tcontact resume"),
    ):
        tc.simulate(physics, FINE, out=place, frames=30, checkpoint={"every_steps": 5})
    data, all_frames = (ResultData.open(folder / "result.vtkhdf") for folder in (place, tmp_path / "straight"))
    assert 3 < len(data) < 30
    for index in range(len(data)):
        mine, theirs = data.frame(index).point_data, all_frames.frame(index).point_data
        assert all(np.array_equal(mine[name], theirs[name]) for name in mine)
    same(tc.resume(place, physics, FINE), straight)
    same_files(place, tmp_path / "straight")


def test_a_full_disk_before_the_first_checkpoint_keeps_the_rows_too(tmp_path):
    with largest_file(150_000), pytest.raises(tc.OutputError, match=r"run again; history\.csv has the rows") as caught:
        tc.simulate(SCENES["full removal"](), FINE, out=tmp_path, frames=30)
    result, rows = caught.value.result, np.genfromtxt(tmp_path / "history.csv", delimiter=",", names=True)
    assert result.reason == "not-written"
    assert np.array_equal(rows["time"], result.history["time"])
    assert np.array_equal(rows["energy_error"], result.history["energy_error"])
    assert json.loads((tmp_path / "summary.json").read_text())["reason"] == "not-written"
    stored = tc.open_result(tmp_path)
    with pytest.raises(tc.InputError, match=r"cannot be written.*history\.csv has its rows"):
        _ = stored.history
    assert main(["info", str(tmp_path)]) == 0


def test_a_disk_that_is_full_when_pictures_are_drawn_costs_no_run(tmp_path, monkeypatch, capsys):
    from tcontact.show import plots

    def full(*_, **__):
        raise OSError(errno.ENOSPC, "No space left on device")

    words = ["run", "bar-impact", "--set", "cells=4", "--frames", "2", "--quiet", "--out", str(tmp_path)]
    with monkeypatch.context() as patch:
        patch.setattr(plots, "_save", full)
        assert main(words) == 1
    text = capsys.readouterr().err
    assert "the run has ended and is kept; make room, then `tcontact resume" in text
    assert not (tmp_path / "contact-force.png").exists()
    assert main(["resume", str(tmp_path), "--quiet"]) == 0
    assert (tmp_path / "contact-force.png").exists()


def test_a_full_file_system(tmp_path, monkeypatch):
    """A run whose 300 kB file system fills up says so and keeps its frames; skipped where none can be mounted."""
    monkeypatch.setattr(frame_fields, "check_room", lambda *_: None)
    disk = tmp_path / "disk"
    disk.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=300k", "tmpfs", str(disk)]
    if not shutil.which("mount") or subprocess.run(mount, capture_output=True, check=False).returncode:
        pytest.skip("no file system can be mounted here")
    try:
        with pytest.raises(tc.OutputError, match=r"No space left on device.*run again"):
            tc.simulate(SCENES["full removal"](), FINE, out=disk / "run", frames=60)
        count = len(ResultData.open(disk / "run/result.vtkhdf"))
        assert "run again" in tc.open_result(disk / "run").message, "there is no checkpoint to go on from"
        assert count > 3
        with pytest.raises((tc.InputError, tc.OutputError), match="make room"):
            tc.simulate(SCENES["full removal"](), FINE, out=disk / "next", frames=60)
        assert len(ResultData.open(disk / "run/result.vtkhdf")) == count
    finally:
        subprocess.run(["umount", str(disk)], check=True)


def test_a_checkpoint_that_finds_no_room_is_only_a_warning(tmp_path, monkeypatch):
    physics, place = SCENES["full removal"](), tmp_path / "run"
    write = store.write

    def full(*arguments):
        with largest_file(10_000):
            return write(*arguments)

    monkeypatch.setattr(store, "write", full)
    with pytest.warns(RuntimeWarning, match="no checkpoint could be written") as caught:
        result = tc.simulate(physics, FINE, out=place, frames=3, checkpoint={"every_steps": 5})
    assert result.ok
    assert sum("no checkpoint" in str(warning.message) for warning in caught) == 1
    assert sorted(path.name for path in place.iterdir()) == ["history.csv", "result.vtkhdf", "summary.json"]


def test_a_command_that_cannot_write_says_so(tmp_path, capsys):
    (tmp_path / "file").write_text("")
    for out in (tmp_path / "file", tmp_path / "file/below", Path("/proc/here")):
        assert main(["run", "cube-impact", "--set", "cells=4", "--frames", "0", "--out", str(out)]) == 2
        said = capsys.readouterr().err
        assert said.startswith("tcontact: ")
        assert "Traceback" not in said
        assert "folder" in said


READ_ONLY = """
import os, sys, tcontact as tc
from stopped_runs import SCENES
from tcontact.device import runtime
runtime.start("cpu", 1)
if os.getuid() == 0:
    os.setuid(65534)  # nobody: a folder that is not writable stops root only as somebody else
try:
    tc.simulate(SCENES["full removal"](), out=sys.argv[1])
except tc.InputError as error:
    print(error, flush=True)
os._exit(0)  # the cache of kernels is not ours either
"""


def closed_to_others(path):
    """Whether somebody who is not root cannot read below a folder."""
    return any(not folder.stat().st_mode & 0o001 for folder in (path, *path.parents))


@pytest.mark.skipif(
    os.getuid() == 0
    and any(closed_to_others(Path(place)) for place in (sys.prefix, sys.base_prefix, Path(__file__).resolve().parent)),
    reason="root may write everywhere, and nobody else can read this installation",
)
def test_a_folder_that_is_not_ours(tmp_path):
    place = tmp_path / "theirs"
    place.mkdir(mode=0o555)
    for folder in (tmp_path, *tmp_path.parents):
        if folder != Path("/tmp") and str(folder).startswith("/tmp"):
            folder.chmod(0o755)
    done = python(READ_ONLY, place)
    assert done.returncode == 0, done.stderr
    assert "Permission denied" in done.stdout
    assert "another folder" in done.stdout
    assert not list(place.iterdir())


def test_ctrl_c_amid_a_frame_keeps_everything_and_can_be_resumed(tmp_path, monkeypatch):
    physics = SCENES["full removal"]()
    straight = tc.simulate(physics, FINE, out=tmp_path / "straight", frames=12)
    append = ResultFile.append

    def pressed(self, moment, *fields):
        if len(self) == 5:
            os.kill(os.getpid(), signal.SIGINT)
        append(self, moment, *fields)

    place = tmp_path / "stopped"
    with monkeypatch.context() as patch:
        patch.setattr(ResultFile, "append", pressed)
        result = tc.simulate(physics, FINE, out=place, frames=12, checkpoint=3600.0)
    assert result.reason == "interrupted"
    assert f"tcontact resume {place}" in result.message
    data = ResultData.open(place / "result.vtkhdf")
    assert len(data) == 7  # the one where it stopped is a frame too
    assert data.times[-1] == result.time
    same(tc.resume(place, physics, FINE), straight)
    same_files(place, tmp_path / "straight")


HOLDER = """
import sys, time
from pathlib import Path
from tcontact.run.folder_lock import locked
with locked(Path(sys.argv[1])):
    print("held", flush=True)
    sys.stdin.read()
"""


def test_one_run_at_a_time_in_a_folder(tmp_path, monkeypatch, capsys):
    physics = SCENES["full removal"]()
    _, copies = copied(monkeypatch, tmp_path, physics, FINE, 30, frames=2)
    place = copies[min(copies)]
    code = f"import sys; sys.path[:0] = [{str(ROOT)!r}]\n" + HOLDER
    other = subprocess.Popen(
        [sys.executable, "-c", code, str(place)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert other.stdout.readline() == "held\n"
    before = {path.name: path.read_bytes() for path in place.iterdir()}
    for call in (lambda: tc.resume(place, physics, FINE), lambda: tc.simulate(physics, FINE, out=place)):
        with pytest.raises(tc.InputError, match=f"process {other.pid} is writing"):
            call()
    assert main(["run", "cube-impact", "--out", str(place), "--force"]) == 2
    assert f"process {other.pid}" in capsys.readouterr().err
    assert {path.name: path.read_bytes() for path in place.iterdir()} == before
    other.kill()
    other.wait()
    assert tc.resume(place, physics, FINE).ok  # the lock of a dead process holds nobody up


@pytest.fixture(scope="module")
def content(tmp_path_factory):
    path = tmp_path_factory.mktemp("content") / "result.vtkhdf"
    write_run(path, FRAMES)
    return path.read_bytes()


@pytest.mark.parametrize("command", ["info", "render", "resume"])
def test_damaged_and_foreign_result_files_are_refused(command, content, tmp_path, capsys):
    generator = random.Random(8)
    damaged = [content[: len(content) * part // 7] for part in range(7)]
    damaged += [b"text\n" * 400, bytes(reversed(content)), content[2000:]]
    for _ in range(12):
        changed = bytearray(content)
        for _ in range(300):
            changed[generator.randrange(9000)] = generator.randrange(256)
        damaged.append(bytes(changed))
    for number, data in enumerate(damaged):
        place = tmp_path / str(number)
        place.mkdir()
        (place / "result.vtkhdf").write_bytes(data)
        assert main([command, str(place)]) == 2, number
        said = capsys.readouterr().err
        assert said.startswith("tcontact: ")
        assert "Traceback" not in said
        assert len(list(place.iterdir())) == 1
