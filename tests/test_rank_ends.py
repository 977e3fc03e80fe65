"""How runs on several ranks end: killed, interrupted, or by an error of one rank; never by waiting for ever."""

import os
import random
import re
import shlex
import signal
import subprocess
import sys
import threading
import time

import h5py
import numpy as np
import pytest
from rank_scenes import block
from test_ranks import HERE, MPIEXEC, mpiexec, pytestmark  # noqa: F401 - skips these tests where MPI is missing

import tcontact as tc
from tcontact.device.ranks import passed_on
from tcontact.results.files import checkpoint_heads

RANKS = 3


def started(folder, *words):
    """Start the script of rank_ends.py on several ranks."""
    environment = os.environ | {"OMP_NUM_THREADS": "1", "PYTHONPATH": str(HERE.parent)}
    command = [MPIEXEC, "-n", str(RANKS), sys.executable, "rank_ends.py", str(folder), *words]
    return subprocess.Popen(
        command, cwd=HERE, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )


def until(folder, name, process, seconds=300.0):
    """Wait until a file of the run is there; return its text."""
    end = time.monotonic() + seconds
    wait = threading.Event()
    while not (folder / name).exists() or not (text := (folder / name).read_bytes()):
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < end
        wait.wait(0.02)
    return text


def kill_at(folder, seconds):
    """Kill the second rank so many seconds after its start; return the process that has ended."""
    process = started(folder)
    number = int(until(folder, "pid-1", process))
    threading.Event().wait(seconds)
    os.kill(number, signal.SIGKILL)
    process.communicate(timeout=120)
    return process


@pytest.mark.parametrize("seconds", [0.3, 6.0])
def test_a_run_ends_when_a_rank_is_killed(tmp_path, seconds):
    """While the ranks start, and while they step; `communicate` raises `TimeoutExpired` if the others wait for it."""
    assert kill_at(tmp_path, seconds).returncode != 0


@pytest.mark.slow
@pytest.mark.parametrize("number", range(20))
def test_a_run_ends_when_a_rank_is_killed_at_any_moment(tmp_path, number):
    assert kill_at(tmp_path, random.Random(number).uniform(0.0, 12.0)).returncode != 0


def test_a_signal_to_one_rank_stops_all_with_everything_kept(tmp_path):
    process = started(tmp_path)
    number = int(until(tmp_path, "pid-2", process))
    end = time.monotonic() + 300.0
    while time.monotonic() < end:
        threading.Event().wait(0.5)
        file = tmp_path / "run" / "result.vtkhdf"
        if file.exists() and file.stat().st_size > 50_000:
            break
    os.kill(number, signal.SIGTERM)
    output, errors = process.communicate(timeout=300)
    assert output.count("interrupted") == RANKS, errors
    assert process.returncode == 0
    with h5py.File(tmp_path / "run" / "result.vtkhdf") as file:
        assert len(file["VTKHDF/Steps/Values"]) >= 1
    assert (tmp_path / "run" / "history.csv").exists()


def test_an_error_of_one_rank_ends_all_and_names_it(tmp_path):
    process = started(tmp_path, "fails")
    _, errors = process.communicate(timeout=300)
    assert process.returncode != 0
    assert errors.count("Traceback") == 1
    assert "rank 1 of 3 failed, which ends all ranks" in errors
    assert "this rank alone" in errors


@pytest.mark.parametrize(("rank", "moment"), [(0, "before"), (1, "before"), (1, "after")])
def test_an_error_of_one_rank_outside_a_run_is_told_and_ends_all(rank, moment):
    """`mpiexec` raises `TimeoutExpired` if the others go on waiting for it."""
    done = mpiexec(2, "rank_lone.py", rank, moment, timeout=60)
    assert done.returncode != 0
    assert done.stderr.count("Traceback") == 1
    assert "this rank alone" in done.stderr
    assert f"rank {rank} of 2 failed, which ends all ranks" in done.stderr


@pytest.mark.parametrize(("rank", "moment"), [(1, "exits"), (0, "resume")])
def test_a_rank_that_leaves_python_while_scenes_are_compared_ends_all(tmp_path, rank, moment):
    """`mpiexec` raises `TimeoutExpired` if the others go on waiting for it."""
    done = mpiexec(2, "rank_lone.py", rank, moment, tmp_path, timeout=60)
    assert done.returncode != 0
    assert done.stderr.count("Traceback") == 1
    assert "SystemExit: 3" in done.stderr
    assert f"tcontact: rank {rank} of 2 failed, which ends all ranks" in done.stderr


def test_a_signal_to_one_rank_before_the_steps_is_told_in_a_line():
    done = mpiexec(2, "rank_lone.py", 1, "stopped", timeout=60)
    assert done.returncode == 1
    assert "tcontact: rank 1 of 2 was interrupted before the first step, which ends all ranks\n" in done.stderr
    assert "Traceback" not in done.stderr
    assert done.stderr.count("tcontact: ") == 1


def test_different_errors_of_all_ranks_are_told_once_each():
    done = mpiexec(3, "rank_lone.py", 2, "everyone", timeout=60)
    assert done.returncode != 0
    assert done.stderr.count("size = -1") == 1
    assert done.stderr.count("size = -2") == 1
    assert "ends all ranks" not in done.stderr


@pytest.mark.parametrize(
    ("rank", "moment", "said"),
    [
        (0, "idle", "rank 0 has come to the end of its script; rank 1 starts a run"),
        (1, "idle", "rank 0 starts a run; rank 1 has come to the end of its script"),
        (1, "scene", "bodies[0].velocity = "),
        (1, "load", "gravity.function = "),
        (0, "out", "out = 'False': rank 1 has that and the first rank True"),
        (1, "step", "scheme.cfl = '0.5': rank 1 has that and the first rank 0.6"),
    ],
)
def test_ranks_that_do_not_do_the_same_are_told_so_once_and_write_nothing(tmp_path, rank, moment, said):
    done = mpiexec(2, "rank_lone.py", rank, moment, tmp_path / "run", timeout=60)
    assert done.returncode != 0
    assert done.stderr.count(said) == 1
    assert done.stderr.count("Traceback") == 1
    assert not (tmp_path / "run").exists()


def test_a_file_that_one_rank_alone_does_not_find_is_told_and_ends_all(tmp_path):
    (tmp_path / "here").mkdir()
    (tmp_path / "there").mkdir()
    scene = tc.Scene([block(contact="zmin")], [tc.Plane()], 1e-4)
    tc.save_scene(scene, tmp_path / "here" / "scene.toml")
    command = f"{shlex.quote(sys.executable)} -m tcontact run scene.toml --frames 0 --out {tmp_path / 'run'}"
    place = f"if [ ${{PMI_RANK:-$OMPI_COMM_WORLD_RANK}} = 1 ]; then cd {tmp_path / 'there'}; fi; {command}"
    environment = os.environ | {"OMP_NUM_THREADS": "1", "PYTHONPATH": str(HERE.parent)}
    words = [MPIEXEC, "-n", "2", "sh", "-c", place]
    given = {"cwd": tmp_path / "here", "env": environment, "capture_output": True, "text": True, "timeout": 60}
    done = subprocess.run(words, check=False, **given)
    assert done.returncode != 0
    assert done.stderr.count("path = 'scene.toml': no such file") == 1
    assert "rank 1 of 2 failed, which ends all ranks" in done.stderr


def test_a_rank_waits_until_its_last_lines_are_read_but_not_for_ever():
    reading, writing = os.pipe()
    with open(writing, "w", encoding="utf-8") as stream, open(reading, "rb") as other_end:
        stream.write("last line")
        begun = time.monotonic()
        passed_on(stream, seconds=0.2)
        assert time.monotonic() - begun >= 0.2
        threading.Timer(0.3, other_end.read, [9]).start()
        begun = time.monotonic()
        passed_on(stream, seconds=30.0)
        assert 0.2 < time.monotonic() - begun < 20.0


WHOLE = ("normal", "sensed", "walls", "varied")
STOPPED = [("killed", "walls"), ("signalled", "normal"), ("killed", "sensed"), ("signalled", "varied")]


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Runs on two ranks that never stopped, by scene."""
    folder = tmp_path_factory.mktemp("whole")
    done = mpiexec(2, "rank_resumed.py", folder, "whole", *WHOLE)
    assert done.returncode == 0, done.stderr
    assert not list(folder.rglob("checkpoint*"))
    return {name: np.load(folder / name / "whole.npz") for name in WHOLE}


@pytest.mark.parametrize(("stop", "name"), STOPPED)
def test_a_run_on_two_ranks_goes_on_with_the_bits_of_one_that_never_stopped(whole, tmp_path, stop, name):
    first = mpiexec(2, "rank_resumed.py", tmp_path, stop, name)
    assert (first.returncode == 0) == (stop == "signalled")
    done = mpiexec(2, "rank_resumed.py", tmp_path, "resumed", name)
    assert done.returncode == 0, done.stderr
    found = np.load(tmp_path / name / "resumed.npz")
    assert str(found["reason"]) == "finished"
    assert [key for key in found.files if whole[name][key].tobytes() != found[key].tobytes()] == []
    assert not list(tmp_path.rglob("checkpoint*"))
    with h5py.File(tmp_path / name / "result.vtkhdf") as file:
        assert len(file["VTKHDF/Steps/Values"]) == 5


def test_two_kills_at_one_checkpoint_leave_the_one_before_it(whole, tmp_path):
    """Both times the first rank alone has written the second one: the run still goes on from row 3."""
    for stop in ("torn", "torn-again"):
        assert mpiexec(2, "rank_resumed.py", tmp_path, stop, "normal").returncode != 0
        rows = [checkpoint_heads.head_of(tmp_path / "normal" / name)["row"] for name in checkpoint_heads.FILES]
        assert min(rows) == 3
        assert max(rows) > 3
    done = mpiexec(2, "rank_resumed.py", tmp_path, "resumed", "normal")
    assert done.returncode == 0, done.stderr
    found = np.load(tmp_path / "normal" / "resumed.npz")
    assert [key for key in found.files if whole["normal"][key].tobytes() != found[key].tobytes()] == []


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """What rank_kept.py prints."""
    done = mpiexec(2, "rank_kept.py", tmp_path_factory.mktemp("kept"), timeout=60)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


def test_a_checkpoint_that_all_ranks_have_stays_until_the_next_one_is_complete(kept):
    """One rank fails at rows 9 and 12; then one is killed three times at the same row."""
    assert [int(line.split()[1]) for line in kept if line.startswith("full")] == [3, 6, 6, 6, 15, 18]
    assert [int(line.split()[1]) for line in kept if line.startswith("killed")] == [6, 6, 6]


def test_a_checkpoint_that_fails_on_one_rank_is_warned_about_at_once_on_all(kept):
    first, other = kept[-2:]
    assert "checkpoint-ranks/1 (No space left on device) on rank 1; free some space there" in first
    assert first.count("no checkpoint") == 1
    assert first == other


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    """What each of two ranks was told (rank_told.py)."""
    folder = tmp_path_factory.mktemp("told")
    done = mpiexec(2, "rank_told.py", folder, timeout=600)
    assert done.returncode == 0, done.stderr
    lines = [(folder / f"told.{rank}").read_text(encoding="utf-8").splitlines() for rank in range(2)]
    return [dict(line.split(": ", 1) for line in one) for one in lines]


def test_all_ranks_have_the_warnings_of_the_first(told):
    """It alone looks at whole bodies."""
    assert "turn" in told[0]["kept"]
    assert told[0]["kept"] == told[1]["kept"]


@pytest.mark.parametrize(
    ("when", "text"), [("at once", "turn"), ("at the end", "energy error"), ("in time", "above the stable")]
)
def test_a_warning_that_is_an_error_can_be_caught_on_all_ranks(told, when, text):
    """And the script goes on, with further runs."""
    assert text in told[0][when]
    assert told[0][when] == told[1][when]


def test_ranks_that_start_from_different_results_are_told(told):
    assert all("rank 1 starts from another result than the first rank" in one["start"] for one in told)


def test_a_run_that_has_ended_is_not_to_be_run_again(told):
    assert all("the run there has ended; there is nothing to go on with" in one["ended"] for one in told)


def test_a_rank_that_alone_cannot_write_checkpoints_is_named(told):
    assert "no checkpoint could be written into" in told[0]["full"]
    assert "checkpoint-ranks/1 (No space left on device)" in told[0]["full"]
    assert told[0]["full"] == told[1]["full"]


def test_all_ranks_name_the_folder_to_go_on_with(told):
    assert re.search(r"`tcontact resume \S+/stopped` goes on from there", told[0]["message"])
    assert told[0]["message"] == told[1]["message"]


def test_a_damaged_checkpoint_of_a_rank_is_named_once_and_the_one_before_it_taken(told):
    assert "checkpoint-ranks/1/checkpoint-" in told[0]["damaged"]
    assert told[0]["damaged"].count("is damaged and passed over") == 1
    assert told[1]["damaged"] == ""
    assert all(one["resumed"] == "finished" for one in told)


def test_a_checkpoint_of_one_rank_with_a_value_that_the_run_does_not_have_is_refused_on_all(told):
    assert "checkpoint-ranks/1/checkpoint-" in told[0]["unheard"]
    assert "it holds domains.0.unheard, which a run of this version does not have; resume it with" in told[0]["unheard"]
    assert told[0]["unheard"] == told[1]["unheard"]
