"""The folder of a run is made and locked from the start of a command to its end, pictures included."""

import subprocess
import sys

import pytest
from scenes import ROOT
from test_cli import SMALL

from tcontact.commands import curves
from tcontact.commands.cli import main
from tcontact.run import folder_lock
from tcontact.run.folder_lock import NAME, made_and_locked

ANOTHER = [sys.executable, "-m", "tcontact", "run", "bar-impact", *SMALL, "--force", "--quiet", "--out"]


@pytest.fixture
def looked(monkeypatch):
    """What another run with --force in the folder comes to while curves are drawn there: code and words."""
    found = []
    draw = curves.draw

    def look_and_draw(out, *arguments):
        done = subprocess.run([*ANOTHER, str(out)], cwd=ROOT, capture_output=True, text=True, check=False)
        found.append((done.returncode, done.stderr))
        draw(out, *arguments)

    monkeypatch.setattr(curves, "draw", look_and_draw)
    return found


def refused(found, count):
    """Assert that so many other runs were refused because of the one that goes on."""
    assert [code for code, _ in found] == [2] * count
    assert all("is writing a run there" in text for _, text in found)


def test_a_new_folder_is_locked_while_pictures_are_drawn(tmp_path, looked):
    out = tmp_path / "new" / "run"
    assert main(["run", "bar-impact", *SMALL, "--quiet", "--out", str(out)]) == 0
    refused(looked, 1)
    assert (out / "energy.png").exists()
    assert not (out / NAME).exists(), "the lock ends with the command"


def test_every_run_of_a_comparison_is_locked_while_its_pictures_are_drawn(tmp_path, looked):
    words = ["--set", "compare=true", "--quiet", "--out", str(tmp_path / "run")]
    assert main(["run", "tumbling-block", "--set", "cells=2", "--frames", "0", *words]) in (0, 1)
    refused(looked, len([path for path in (tmp_path / "run").iterdir() if path.is_dir()]))


def test_a_run_that_goes_on_is_locked_while_its_pictures_are_drawn(tmp_path, monkeypatch, looked):
    def full(*_):
        raise OSError("no room")

    with monkeypatch.context() as patch:
        patch.setattr(curves, "draw", full)
        assert main(["run", "bar-impact", *SMALL, "--quiet", "--out", str(tmp_path)]) == 1
    assert main(["resume", str(tmp_path), "--quiet"]) == 0
    refused(looked, 1)


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt])
def test_a_command_that_ends_before_it_wrote_anything_leaves_no_folder(tmp_path, error):
    out = tmp_path / "new" / "run"

    def start(*files):
        with made_and_locked(out):
            assert (out / NAME).exists()
            for name in files:
                (out / name).write_text("mine")
            raise error

    with pytest.raises(error):
        start()
    assert not list(tmp_path.iterdir())
    with pytest.raises(error):
        start("notes.txt")
    assert [path.name for path in out.iterdir()] == ["notes.txt"]


def test_a_folder_that_another_process_makes_and_locks_at_the_same_time_is_refused(tmp_path, monkeypatch):
    """Both find no folder; the second one to lock it is the one to go."""
    out = tmp_path / "run"
    with made_and_locked(out):
        monkeypatch.setattr(folder_lock, "_held", {})  # as another process sees it
        with pytest.raises(folder_lock.InputError, match="is writing a run there"), made_and_locked(out):
            pass
        monkeypatch.undo()
        assert (out / NAME).exists()
