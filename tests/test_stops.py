"""Functions that fail late, folders that go away, signals: a run ends with a name for it and what was kept."""

import json
import os
import shutil
import signal
import threading

import numpy as np
import pytest
from scenes import ROOT, python
from stopped_runs import SCENES, quietly, same, same_files, scene, signalled

import tcontact as tc
from tcontact.base.errors import FunctionError
from tcontact.commands.cli import main
from tcontact.planning.body_plan import SMALL
from tcontact.results.files.vtkhdf import ResultData, ResultFile
from tcontact.run.checkpoint import store
from tcontact.run.interrupts import Terminated, interrupts, terminations
from tcontact.run.loop import Run
from tcontact.show import render

FINE = tc.CentralDifference(cfl=0.3)
LATE = 6.1e-4


@pytest.fixture(autouse=True)
def hangups():
    """SIGHUP has its usual effect here, also where all tests run under nohup."""
    before = signal.signal(signal.SIGHUP, signal.SIG_DFL)
    yield
    signal.signal(signal.SIGHUP, before)


def rising(time):
    """Velocity of a wall that pushes [m/s]."""
    return np.array([0.0, 0.0, 0.1])


WRONG = {
    "nan": lambda t: [0.0, 0.0, np.nan],
    "complex": lambda t: np.array([0.0, 0.0, 1j]),
    "shape": lambda t: [1.0, 2.0],
    "exception": lambda t: 1 / 0,
    "text": lambda t: "fast",
}


def pushed(velocity, bodies=1):
    """Blocks above a wall that moves."""
    return scene(wall=tc.Plane(velocity=velocity, name="ram"), bodies=bodies)


@pytest.mark.parametrize(("small", "bodies"), [(False, 1), (False, 2), (True, 1)])
def test_a_function_that_fails_late_ends_the_run_with_all_rows_before(small, bodies, monkeypatch, tmp_path):
    if small:
        for kind in SMALL:
            monkeypatch.setitem(SMALL, kind, 10**6)
    good = quietly(tc.simulate, pushed(rising, bodies), FINE)
    for name, wrong in WRONG.items():
        place = tmp_path / name
        physics = pushed(lambda t, wrong=wrong: rising(t) if t < LATE else wrong(t), bodies)
        result = quietly(tc.simulate, physics, FINE, out=place, frames=8, checkpoint={"every_steps": 5})
        assert (result.ok, result.reason) == (False, "function-failed")
        assert "Plane.velocity of 'ram'" in result.message
        assert f"t = {result.time:.6g} s; everything up to then is kept" in result.message
        assert result.time < LATE < result.time + 1.01 * result.dt
        rows = len(result.history["time"])
        for column, values in result.history.items():
            if column != "energy_error":  # over the largest energy of the whole run
                np.testing.assert_array_equal(values[: rows - 1], good.history[column][: rows - 1], err_msg=column)
        # no step starts at the last row: its forces and places are those of the good run, not its velocities
        np.testing.assert_array_equal(result.history["contact_force"][-1], good.history["contact_force"][rows - 1])
        np.testing.assert_array_equal(result.history["gap_min"][-1], good.history["gap_min"][rows - 1])
        data = ResultData.open(place / "result.vtkhdf")
        assert data.times[-1] == result.time
        assert data.attributes["reason"] == "function-failed"
        assert json.loads((place / "summary.json").read_text())["reason"] == "function-failed"
        assert not any((place / file).exists() for file in store.FILES)


def test_a_function_that_fails_at_the_start_is_bad_input(tmp_path):
    with pytest.raises(tc.InputError, match="t = 0"):
        quietly(tc.simulate, pushed(lambda t: [np.nan] * 3), FINE, out=tmp_path / "run", frames=2)
    assert not (tmp_path / "run/result.vtkhdf").exists()


def test_a_function_that_fails_between_the_times_of_a_run_costs_no_result(monkeypatch, tmp_path):
    """The result file tells where obstacles were at the frames, by times of its own."""
    from tcontact.run import recorder

    describe = recorder.describe

    def failing(obstacles, times=(), history=None):
        if times:
            raise FunctionError("Plane.velocity", rising, "it gave nan at a time of its own")
        return describe(obstacles)

    monkeypatch.setattr(recorder, "describe", failing)
    assert quietly(tc.simulate, pushed(rising), FINE, out=tmp_path / "run", frames=3).ok
    (plane,) = ResultData.open(tmp_path / "run/result.vtkhdf").attributes["obstacles"]
    assert "motion" not in plane


def removed(monkeypatch, folder, away, when=3):
    """Let the folder go away at a frame."""
    append = ResultFile.append

    def gone(self, moment, *fields):
        if len(self) == when:
            away(folder)
        append(self, moment, *fields)

    monkeypatch.setattr(ResultFile, "append", gone)


@pytest.mark.parametrize("away", [shutil.rmtree, lambda folder: folder.rename(folder.with_name("moved"))])
def test_a_folder_that_goes_away_is_named_and_the_result_is_carried(away, monkeypatch, tmp_path):
    place = tmp_path / "run"
    removed(monkeypatch, place, away)
    with pytest.raises(tc.OutputError, match="the folder was removed or renamed while the run went on") as caught:
        tc.simulate(SCENES["full removal"](), FINE, out=place, frames=8)
    result = caught.value.result
    assert result.reason == "not-written"
    assert 0.0 < result.time < 1.2e-3
    assert result.history["time"][-1] == result.time
    if (tmp_path / "moved").exists():
        assert len(ResultData.open(tmp_path / "moved/result.vtkhdf")) == 3


def test_a_folder_that_goes_away_after_the_last_frame_costs_no_result(monkeypatch, tmp_path):
    place = tmp_path / "run"
    removed(monkeypatch, place, shutil.rmtree, when=-1)
    write = ResultFile.write_history
    monkeypatch.setattr(ResultFile, "write_history", lambda self, history: (shutil.rmtree(place), write(self, history)))
    with pytest.raises(tc.OutputError, match="removed or renamed") as caught:
        tc.simulate(SCENES["full removal"](), FINE, out=place, frames=2)
    assert caught.value.result.ok
    same(caught.value.result, tc.simulate(SCENES["full removal"](), FINE))


def test_the_command_line_says_in_one_line_that_the_folder_is_gone(monkeypatch, tmp_path, capsys):
    tc.save_scene(SCENES["full removal"](), tmp_path / "drop.toml")
    removed(monkeypatch, tmp_path / "run", shutil.rmtree, when=1)
    command = ["run", str(tmp_path / "drop.toml"), "--frames", "3", "--quiet", "--out", str(tmp_path / "run")]
    assert main(command) == 1
    said = capsys.readouterr().err
    assert said.startswith("tcontact: ")
    assert said.count("\n") == 1
    assert "removed or renamed" in said


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_a_signal_stops_after_the_step_with_a_checkpoint(number, monkeypatch, tmp_path):
    physics, place = SCENES["full removal"](), tmp_path / "stopped"
    straight = tc.simulate(physics, FINE, out=tmp_path / "straight", frames=12)
    before = signal.getsignal(number)
    assert before == signal.SIG_DFL
    with monkeypatch.context() as patch:
        signalled(patch, number)
        result = tc.simulate(physics, FINE, out=place, frames=12, checkpoint=3600.0)
    assert signal.getsignal(number) == before
    assert result.reason == "interrupted"
    assert f"stopped by the signal {number.name} at t = " in result.message
    assert f"tcontact resume {place}" in result.message
    same(tc.resume(place, physics, FINE, checkpoint=None), straight)
    same_files(place, tmp_path / "straight")


def test_the_handler_of_a_program_stays_in_charge(monkeypatch, tmp_path):
    seen = []
    signal.signal(signal.SIGTERM, lambda number, frame: seen.append(number))
    try:
        signalled(monkeypatch, signal.SIGTERM)
        result = tc.simulate(SCENES["full removal"](), FINE, out=tmp_path / "run", frames=12)
        assert result.ok
        assert seen == [signal.SIGTERM]
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_DFL)


def test_sighup_stops_no_run_that_ignores_it_as_nohup_does(monkeypatch, tmp_path):
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        signalled(monkeypatch, signal.SIGHUP)
        assert tc.simulate(SCENES["full removal"](), FINE, out=tmp_path / "run", frames=12).ok
        with terminations():
            os.kill(os.getpid(), signal.SIGHUP)
        assert signal.getsignal(signal.SIGHUP) == signal.SIG_IGN
    finally:
        signal.signal(signal.SIGHUP, signal.SIG_DFL)


def test_a_second_sighup_has_no_effect():
    """The shell of a terminal that is closed sends one, and the system another."""
    with terminations():
        with interrupts() as stopped:
            for _ in range(2):
                os.kill(os.getpid(), signal.SIGHUP)
            assert stopped() == "the signal SIGHUP"
            assert signal.getsignal(signal.SIGTERM) == signal.SIG_DFL
        os.kill(os.getpid(), signal.SIGHUP)  # while the command writes what there is
    assert signal.getsignal(signal.SIGHUP) == signal.SIG_DFL
    with terminations():
        with pytest.raises(Terminated, match="SIGHUP"):
            os.kill(os.getpid(), signal.SIGHUP)
        os.kill(os.getpid(), signal.SIGHUP)


CLOSED = """
import os, pty, sys, time
child, terminal = pty.fork()
if child == 0:
    os.execv(sys.executable, [sys.executable, "-c", sys.argv[1], *sys.argv[2:]])
while not os.path.exists(sys.argv[2] + ".now"):
    os.read(terminal, 65536)
os.close(terminal)
print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
"""
IN_A_TERMINAL = """
import os, pathlib, signal, sys, time
from tcontact.commands.cli import main
from tcontact.results.files.vtkhdf import ResultFile
append = ResultFile.append
def waiting(self, moment, *fields):
    if len(self) == 2:
        pathlib.Path(sys.argv[1] + ".now").touch()
        signal.alarm(60)  # ends the process if the terminal is not closed
        try:
            while True:
                os.write(1, b".")  # fails when it is; the signal has come then
                time.sleep(0.05)
        except OSError:
            signal.alarm(0)
    append(self, moment, *fields)
ResultFile.append = waiting
sys.exit(main(["run", sys.argv[2], "--frames", "8", "--out", sys.argv[1]]))
"""


def test_a_run_in_a_terminal_that_is_closed_is_stopped_whole(tmp_path):
    """Neither what it prints nor its progress, which go nowhere then, keep it from its summary and checkpoint."""
    tc.save_scene(SCENES["full removal"](), tmp_path / "drop.toml")
    place = tmp_path / "run"
    done = python(CLOSED, IN_A_TERMINAL, place, tmp_path / "drop.toml", cwd=ROOT)
    assert done.stdout.split() == ["1"], done.stderr
    summary = json.loads((place / "summary.json").read_text())
    assert "stopped by the signal SIGHUP" in summary["message"]
    assert "origin" in summary
    assert any(place.glob("checkpoint-?.npz"))


def test_signals_are_taken_in_the_main_thread_alone_and_the_second_has_its_usual_effect():
    mine = signal.getsignal(signal.SIGINT)
    told = []

    def elsewhere():
        with interrupts() as stopped:
            told.append((stopped(), signal.getsignal(signal.SIGTERM)))

    thread = threading.Thread(target=elsewhere)
    thread.start()
    thread.join()
    assert told == [("", signal.SIG_DFL)]
    with terminations():
        command_line = signal.getsignal(signal.SIGTERM)
        with interrupts() as stopped:
            assert not stopped()
            os.kill(os.getpid(), signal.SIGTERM)
            assert "SIGTERM" in stopped()
            assert signal.getsignal(signal.SIGTERM) == signal.SIG_DFL
            assert signal.getsignal(signal.SIGINT) == mine
        assert signal.getsignal(signal.SIGTERM) == command_line
        with pytest.raises(KeyboardInterrupt):
            os.kill(os.getpid(), signal.SIGTERM)
    assert signal.getsignal(signal.SIGTERM) == signal.SIG_DFL
    assert signal.getsignal(signal.SIGINT) == mine


@pytest.mark.parametrize("options", [["--checkpoint", "0"], []])
def test_sigterm_at_the_command_line_and_resume(options, monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(render, "render_frames", lambda *_, **__: [])
    tc.save_scene(SCENES["full removal"](), tmp_path / "drop.toml")
    command = ["run", str(tmp_path / "drop.toml"), "--frames", "8", "--out"]
    assert main([*command, str(tmp_path / "straight"), "--quiet"]) == 0
    place = tmp_path / "stopped"
    with monkeypatch.context() as patch:
        signalled(patch, signal.SIGTERM, when=2)
        assert main([*command, str(place)]) == 1
    assert "SIGTERM" in capsys.readouterr().out
    with monkeypatch.context() as patch:
        signalled(patch, signal.SIGINT, when=5)
        assert main(["resume", str(place), "--quiet", *options]) == 1
    assert main(["resume", str(place), "--quiet", *options]) == 0
    same_files(place, tmp_path / "straight")


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_a_signal_before_the_first_step_brings_older_files_back(number, monkeypatch, tmp_path, capsys):
    """With --force an older run is set aside until the new one has something."""
    tc.save_scene(SCENES["full removal"](), tmp_path / "drop.toml")
    (tmp_path / "run").mkdir()
    (tmp_path / "run/summary.json").write_text("older")
    monkeypatch.setattr(Run, "__init__", lambda *_: os.kill(os.getpid(), number))
    assert main(["run", str(tmp_path / "drop.toml"), "--quiet", "--force", "--out", str(tmp_path / "run")]) == 1
    assert capsys.readouterr().err == f"tcontact: interrupted by {number.name}\n"
    assert [path.name for path in (tmp_path / "run").iterdir()] == ["summary.json"]
    assert (tmp_path / "run/summary.json").read_text() == "older"


DIES = """
import os, signal, sys, threading
import tcontact as tc
from stopped_runs import SCENES
from tcontact.planning.body_plan import SMALL
from tcontact.results.files.vtkhdf import ResultFile
SMALL.update(dict.fromkeys(SMALL, 0))
append = ResultFile.append
def sent(self, moment, *fields):
    if len(self) == 2:
        os.kill(os.getpid(), signal.SIGTERM)
        os.kill(os.getpid(), signal.SIGTERM)
    append(self, moment, *fields)
ResultFile.append = sent
tc.simulate(SCENES["full removal"](), out=sys.argv[1], frames=5, threads=1)
"""


def test_a_second_sigterm_kills_at_once(tmp_path):
    done = python(DIES, tmp_path / "run")
    assert done.returncode == -signal.SIGTERM, done.stderr
    assert len(ResultData.open(tmp_path / "run/result.vtkhdf")) == 2


def test_a_run_that_was_resumed_without_checkpoints_leaves_none(monkeypatch, tmp_path):
    physics, place = SCENES["full removal"](), tmp_path / "run"
    with monkeypatch.context() as patch:
        signalled(patch, signal.SIGINT, when=2)
        tc.simulate(physics, FINE, out=place, frames=5, checkpoint=3600.0)
    rows = [stored.row for stored in store.read_all(place)[0]]
    saved = []
    with monkeypatch.context() as patch:
        write = store.write
        patch.setattr(store, "write", lambda *arguments: (saved.append(1), write(*arguments)))
        result = tc.resume(place, physics, FINE, checkpoint=None)
    assert rows
    assert not saved
    assert result.ok
    assert not any((place / name).exists() for name in store.FILES)


@pytest.mark.parametrize("cfl", [0.31, 0.34])
def test_frames_change_no_bit_of_a_run_with_a_wall_that_moves(cfl, tmp_path):
    """The times at which the wall is asked are those of the rows, wherever the host stops to write."""
    scheme = tc.CentralDifference(cfl=cfl)
    plain = quietly(tc.simulate, pushed(rising, 2), scheme)
    drawn = quietly(tc.simulate, pushed(rising, 2), scheme, out=tmp_path, frames=8, fields=[])
    for column, values in plain.history.items():
        np.testing.assert_array_equal(drawn.history[column], values, err_msg=column)
