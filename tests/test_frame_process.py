"""Frames that another process writes: the same file, whatever stops the run or that process."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from scenes import ROOT
from stopped_runs import SCENES, same, same_files
from test_faults import FINE, largest_file

import tcontact as tc
from tcontact.results.files import frame_process
from tcontact.results.files.frame_process import FrameProcess
from tcontact.results.files.vtkhdf import ResultData, ResultFile
from tcontact.run.recorder import FILE, Recorder

SCENE = "full removal"


@pytest.fixture
def beside(monkeypatch):
    """Lets small runs write by a process, from their first frame on; a list of those that took over."""
    taken, ready, take_over = [], FrameProcess.ready, FrameProcess.take_over

    def waits(process):
        if process._memory >= 0:
            process._line.poll(60.0)
        return ready(process)

    def noted(process, *arguments):
        taken.append(process)
        take_over(process, *arguments)

    monkeypatch.setattr(frame_process, "LEAST", 0)
    monkeypatch.setattr(frame_process, "_processors", lambda: 2)
    monkeypatch.setattr(FrameProcess, "ready", waits)
    monkeypatch.setattr(FrameProcess, "take_over", noted)
    return taken


@pytest.fixture
def straight(tmp_path):
    """The result and the folder of a run that writes by itself."""
    folder = tmp_path / "straight"
    return tc.simulate(SCENES[SCENE](), FINE, out=folder, frames=20), folder


def test_the_file_is_that_of_a_run_that_writes_by_itself(straight, beside, tmp_path):
    result = tc.simulate(SCENES[SCENE](), FINE, out=tmp_path / "beside", frames=20)
    assert len(beside) == 1
    assert all(process._process.returncode == 0 for process in beside)
    same(result, straight[0])
    same_files(tmp_path / "beside", straight[1])


def test_arrays_may_change_at_once_and_their_types_are_kept(beside, tmp_path):
    points, cells = np.random.default_rng(1).normal(size=(8, 3)), np.arange(8)[None]
    file, process = ResultFile.create(tmp_path / "result.vtkhdf", points, [("hex8", cells)]), FrameProcess.start(1, 20)
    assert process.ready()
    file.append(0.0, {"a": np.zeros((8, 3)), "b": np.zeros(8, bool)})
    process.take_over(file, tmp_path / "result.vtkhdf", {"text": "kept"})
    moving = np.zeros((8, 3))
    for number in range(1, 20):
        moving[:] = number
        process.append(float(number), {"a": moving, "b": np.full(8, number % 2 == 0)})
        moving[:] = np.nan
    process.sync()
    assert len(process) == process.kept == 20
    process.write_history({"time": np.arange(3.0)})
    process.close()
    process.close()
    data = ResultData.open(tmp_path / "result.vtkhdf")
    assert data.times.tolist() == list(range(20))
    assert data.attributes == {"text": "kept"}
    for number in range(1, 20):
        fields = data.frame(number).point_data
        assert (fields["a"] == number).all()
        assert (fields["b"] == (number % 2 == 0)).all()


@pytest.mark.parametrize(("size", "frames", "processors"), [(10**6, 99, 2), (10**9, 7, 2), (10**7, 100, 1)])
def test_it_is_started_only_where_it_pays(size, frames, processors, monkeypatch):
    monkeypatch.setattr(frame_process, "_processors", lambda: processors)
    assert FrameProcess.start(size, frames) is None
    monkeypatch.setattr(frame_process, "_processors", lambda: 2)
    process = FrameProcess.start(max(size, 10**6 + 10**5), max(frames, 100))
    assert process is not None
    process.close()
    assert process._process.returncode is not None


@pytest.mark.parametrize("program", ["", "/nowhere/python", "/bin/false"])
def test_without_it_the_run_writes_by_itself(program, straight, beside, monkeypatch, tmp_path):
    monkeypatch.setattr(sys, "executable", program)
    tc.simulate(SCENES[SCENE](), FINE, out=tmp_path / "alone", frames=20)
    assert not beside
    same_files(tmp_path / "alone", straight[1])


def test_a_signal_to_the_whole_program_does_not_stop_it(straight, beside, monkeypatch, tmp_path):
    append = FrameProcess.append

    def amid(process, *arguments):
        for number in (signal.SIGINT, signal.SIGTERM):
            os.kill(process._process.pid, number)
        append(process, *arguments)

    monkeypatch.setattr(FrameProcess, "append", amid)
    assert tc.simulate(SCENES[SCENE](), FINE, out=tmp_path / "beside", frames=20).ok
    same_files(tmp_path / "beside", straight[1])


@pytest.mark.parametrize("at", [4, 19])
def test_a_process_that_is_killed_ends_the_run_with_what_it_wrote(at, straight, beside, monkeypatch, tmp_path):
    append, place = FrameProcess.append, tmp_path / "killed"

    def killed(process, *arguments):
        append(process, *arguments)
        if len(process) == at + 1:
            process._process.send_signal(signal.SIGSTOP)  # amid anything
            process._process.kill()
            process._process.wait()

    monkeypatch.setattr(FrameProcess, "append", killed)
    with pytest.raises(tc.OutputError, match=r"the frame at t = .*the process that writes it has ended") as caught:
        tc.simulate(SCENES[SCENE](), FINE, out=place, frames=20, checkpoint={"every_steps": 5})
    assert caught.value.result.reason == "not-written"
    assert at + 1 - frame_process.PLACES <= len(ResultData.open(place / "result.vtkhdf")) <= at + 1
    monkeypatch.setattr(FrameProcess, "append", append)
    same(tc.resume(place, SCENES[SCENE](), FINE), straight[0])
    same_files(place, straight[1])


def test_a_full_disk_is_named_and_the_run_goes_on_when_there_is_room(beside, tmp_path):
    place = tmp_path / "full"
    with (
        largest_file(150_000),
        pytest.raises(tc.OutputError, match=r"the frame at t = .*File too large.*make room, then `tcontact resume"),
    ):
        tc.simulate(SCENES[SCENE](), FINE, out=place, frames=30, checkpoint={"every_steps": 5})
    data = ResultData.open(place / "result.vtkhdf")
    assert 3 < len(data) < 30
    assert beside
    whole = tmp_path / "whole"
    same(tc.resume(place, SCENES[SCENE](), FINE), tc.simulate(SCENES[SCENE](), FINE, out=whole, frames=30))
    same_files(place, whole)


SCRIPT = """
import sys, time
import tcontact as tc
from stopped_runs import SCENES
from tcontact.results.files import frame_process
from tcontact.results.files.frame_process import FrameProcess
frame_process.LEAST, frame_process._processors = 0, lambda: 2
ready, append = FrameProcess.ready, FrameProcess.append
FrameProcess.ready = lambda process: process._line.poll(60.0) and ready(process) or ready(process)
def slow(process, *arguments):
    append(process, *arguments)
    print(process._process.pid, len(process), flush=True)
    if len(process) == 9:
        time.sleep(600.0)
FrameProcess.append = slow
tc.simulate(SCENES["full removal"](), tc.CentralDifference(cfl=0.3), out=sys.argv[1], frames=20,
            checkpoint={"every_steps": 5})
"""


def test_a_run_that_is_killed_keeps_the_frames_it_had_sent(straight, tmp_path):
    """The process writes what it was sent and ends; a script needs no guard, and no home folder."""
    script, place = tmp_path / "script.py", tmp_path / "killed"
    script.write_text(SCRIPT)
    environment = {name: value for name, value in os.environ.items() if name != "HOME"}
    environment["PYTHONPATH"] = os.pathsep.join([str(ROOT), str(ROOT / "tests")])
    run = subprocess.Popen(
        [sys.executable, str(script), str(place)], env=environment, stdout=subprocess.PIPE, text=True
    )
    for line in run.stdout:
        writer, count = map(int, line.split()[-2:])
        if count == 9:
            break
    run.kill()
    run.wait()
    ended = time.monotonic() + 60.0
    state = Path(f"/proc/{writer}/stat")
    while state.exists() and " Z " not in state.read_text():
        assert time.monotonic() < ended, "the process outlives its run"
    assert len(ResultData.open(place / "result.vtkhdf")) == 9
    same(tc.resume(place, SCENES[SCENE](), FINE), straight[0])
    same_files(place, straight[1])


def test_an_end_behind_the_last_frame_is_told_without_a_lost_frame(tmp_path):
    """The process ends when it has written every frame and the run has no other one to send."""
    (tmp_path / FILE).touch()
    recorder, file = Recorder.__new__(Recorder), FrameProcess.__new__(FrameProcess)
    file._failed, file._sent, file.kept = OSError(5, "it has ended"), 2, 2
    recorder.file, recorder.folder, recorder.times = file, tmp_path, [0.0, 0.0, 1e-3]
    with pytest.raises(tc.OutputError, match=r"what follows the last frame cannot be written .*the 2 frames before"):
        recorder.settle()
    assert recorder.times == [0.0, 0.0, 1e-3]
