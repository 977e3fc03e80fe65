"""What a command tells while it works: its stages, on a terminal with their time, and nothing anywhere else."""

from __future__ import annotations

import logging
import os
import pty
import subprocess
import sys
from pathlib import Path

import pytest

import tcontact as tc
from tcontact.base import stages
from tcontact.commands import ticker
from tcontact.commands.cli import main
from tcontact.device import kernel_counts

ROOT = Path(__file__).resolve().parent.parent


class Terminal:
    """A terminal with a Python program on it."""

    def __init__(self, code: str) -> None:
        self.ours, theirs = pty.openpty()
        command = [sys.executable, "-c", code]
        self.process = subprocess.Popen(command, cwd=ROOT, stdin=subprocess.PIPE, stdout=theirs, stderr=theirs)
        os.close(theirs)
        self.text = ""

    def say(self, line: str) -> None:
        """Give the program a line to read."""
        assert self.process.stdin is not None
        self.process.stdin.write(f"{line}\n".encode())
        self.process.stdin.flush()

    def until(self, words: str) -> None:
        """Read until the program has written these words, "" = until it has ended."""
        while not words or words not in self.text:
            try:
                piece = os.read(self.ours, 65536)
            except OSError:  # it has ended, and all of its own
                piece = b""
            if not piece:
                assert not words, self.text
                break
            self.text += piece.decode(errors="replace")

    def end(self) -> str:
        """Close what the program reads; return all that it wrote."""
        assert self.process.stdin is not None
        self.process.stdin.close()
        self.until("")
        os.close(self.ours)
        assert self.process.wait() == 0
        return self.text


def test_a_terminal_shows_the_stage_and_its_time():
    terminal = Terminal(ticker.WRITER)
    terminal.say("planning")
    terminal.until("planning, 1 s")
    terminal.say("drawing")
    terminal.until("drawing\r")
    terminal.text = ""
    terminal.say("")
    terminal.until("\x1b[2K")  # the line is gone before others write
    assert terminal.end().endswith("\r\x1b[2K")


WORK = """
from tcontact.base import stages
from tcontact.commands.ticker import ticking
with ticking({enabled}):
    stages.say("planning")
    {wait}
print("done")
"""


@pytest.mark.parametrize("enabled", [True, False])
def test_a_command_shows_its_stages_where_it_is_asked_to(enabled):
    terminal = Terminal(WORK.format(enabled=enabled, wait="input()" if enabled else ""))
    if enabled:
        terminal.until("planning")
        terminal.say("go on")
    text = terminal.end()
    assert text.rstrip().endswith("done")
    assert ("planning" in text) == enabled


def test_nothing_is_shown_where_there_is_no_terminal(capfd):
    with ticker.ticking(True):
        stages.say("planning")
    assert capfd.readouterr() == ("", "")


def test_a_run_tells_its_stages(tmp_path, capsys):
    told: list[str] = []
    with stages.heard(told.append):
        assert main(["run", "cube-impact", "--set", "cells=3", "--frames", "3", "--out", str(tmp_path / "run")]) in (
            0,
            1,
        )
    assert "planning" in told
    assert "drawing picture 3 of 3" in told
    assert told.index("planning") < told.index("drawing curves") < told.index("drawing picture 3 of 3")
    assert "planning" not in capsys.readouterr().err


def test_each_kernel_is_told_once():
    told: list[str] = []
    mesh = tc.box_mesh((1, 1, 1), (2, 1, 1))
    scene = tc.Scene([tc.Body(mesh, tc.MooneyRivlin(1e5, 1e4, 1e6, 1000.0))], duration=1e-3)
    with stages.heard(told.append):
        tc.simulate(scene)
        first = [stage for stage in told if stage.startswith("compiling")]
        tc.simulate(scene)
    assert len(set(first)) == len(first) > 0
    assert [stage for stage in told if stage.startswith("compiling")] == first


COUNTED = """
import sys
import tcontact as tc
from tcontact.base import stages
cells = int(sys.argv[1])
scene = tc.Scene([tc.Body(tc.box_mesh((1, 1, 1), (cells, 1, 1)), tc.LinearElastic(1e5, 0.3, 1000.0))], duration=1e-3)
with stages.heard(lambda stage: print(stage) if stage.startswith("compiling") else None):
    tc.simulate(scene, out=sys.argv[2] + "/first", frames=2)
    print("again")
    tc.simulate(scene, out=sys.argv[2] + "/second", frames=2)
"""


def test_the_second_run_of_a_kind_knows_how_many_kernels_there_will_be(tmp_path):
    """The number is that of the run before, whatever the size of the mesh; what is no number of runs is no harm."""
    told = []
    for number, cells in enumerate(("2", "3", "3", "3")):
        if len(told) == 2:
            (tmp_path / "tcontact" / kernel_counts.FILE).write_text("[broken")
        environment = os.environ | {"XDG_CACHE_HOME": str(tmp_path)}
        command = [sys.executable, "-c", COUNTED, cells, str(tmp_path / f"run-{number}")]
        done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=True)
        lines = [line for line in done.stdout.splitlines() if not line.startswith("[Taichi]")]
        assert lines[-1] == "again"  # its kernels are there
        told.append([line.partition(":")[0] for line in lines[:-1]])
    count = len(told[0])
    assert count > 1
    assert told[0] == told[2] == [f"compiling kernel {k + 1}" for k in range(count)]
    assert told[1] == told[3] == [f"compiling kernel {k + 1} of {count}" for k in range(count)]


def test_a_listener_hears_only_inside():
    told: list[str] = []
    with stages.heard(told.append):
        stages.say("in")
    stages.say("out")
    with pytest.raises(ZeroDivisionError), stages.heard(told.append):
        raise ZeroDivisionError
    stages.say("out")
    assert told == ["in"]


def test_stages_and_residuals_go_to_the_log(caplog, capfd):
    mesh = tc.box_mesh((1, 1, 1), (1, 1, 1))
    body = tc.Body(mesh, tc.NeoHookean(1e5, 0.3, 1000.0), velocity=lambda x: 0.1 * x)
    with caplog.at_level(logging.INFO, logger="tcontact"):
        tc.simulate(tc.Scene([body], duration=2e-3), tc.Midpoint(dt=1e-3, verbose=True))
    said = [record.getMessage() for record in caplog.records if record.name == "tcontact"]
    assert "planning" in said
    assert any(text.startswith("newton 0: residual") for text in said)
    assert capfd.readouterr() == ("", "")
