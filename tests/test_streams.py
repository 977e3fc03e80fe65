"""The standard streams of a command closed, full or read by nobody; a checkpoint whose origin is nonsense."""

import io
import os
import subprocess
import sys

import numpy as np
import pytest
from scenes import ROOT
from stopped_runs import SCENES

import tcontact as tc
from tcontact.commands.cli import main
from tcontact.commands.streams import Output
from tcontact.results.files.vtkhdf import ResultData, ResultFile
from tcontact.run.checkpoint import store


@pytest.fixture(scope="module")
def drop(tmp_path_factory):
    """A scene file."""
    path = tmp_path_factory.mktemp("drop") / "drop.toml"
    tc.save_scene(SCENES["full removal"](), path)
    return path


CODE = """
import sys
from tcontact.planning.body_plan import SMALL
SMALL.update(dict.fromkeys(SMALL, 0))
from tcontact import render
render.render_frames = lambda *a, **b: []
from tcontact.commands.cli import main
sys.exit(main(sys.argv[1:]))
"""


def shell(line, *arguments, folder):
    """Run a line of sh; "$@" is the command; returns code, output and errors."""
    command = ["bash", "-c", line, "bash", sys.executable, "-W", "ignore", "-c", CODE, *map(str, arguments)]
    seen = os.environ | {"PYTHONPATH": str(ROOT)}
    return subprocess.run(command, capture_output=True, text=True, timeout=300, cwd=folder, env=seen, check=False)


@pytest.mark.parametrize(
    "line",
    [
        '"$@" | head -1 >/dev/null; exit ${PIPESTATUS[0]}',
        '"$@" >&- 2>&- <&-',
    ],
)
def test_a_run_whose_words_nobody_reads_is_done_all_the_same(line, drop, tmp_path):
    done = shell(line, "run", drop, "--frames", "3", "--out", tmp_path / "run", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    names = {"contact-force.png", "energy.png", "gap.png", "history.csv", "result.vtkhdf", "summary.json"}
    assert {path.name for path in (tmp_path / "run").iterdir()} == names
    data = ResultData.open(tmp_path / "run/result.vtkhdf")
    assert [data.frame(index).time for index in range(3)] == data.times.tolist()


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="there is no /dev/full here")
def test_a_full_device_is_named_and_the_exit_code_is_1(tmp_path):
    done = shell('"$@" > /dev/full', "list", folder=tmp_path)
    assert done.returncode == 1
    assert done.stderr == "tcontact: standard output cannot be written (No space left on device)\n"


def test_an_output_goes_silent_once():
    class Broken:
        calls = 0

        def write(self, text):
            self.calls += 1
            raise BrokenPipeError(32, "Broken pipe")

        def fileno(self):
            raise ValueError("none")

    stream = Broken()
    output = Output(stream)
    for _ in range(3):
        print("words", file=output, flush=True)
    assert stream.calls == 1
    assert output.silent
    assert output.error is None


def test_letters_that_a_stream_lacks_become_question_marks():
    raw = io.BytesIO()
    stream = io.TextIOWrapper(raw, encoding="cp1252", write_through=True)
    print("ü in ▁▂", file=Output(stream))
    assert raw.getvalue() == b"\xfc in ??\n"


def test_a_reader_that_is_gone_needs_no_letters():
    class Gone:
        def write(self, text):
            text.encode("ascii")
            raise BrokenPipeError(32, "Broken pipe")

        def fileno(self):
            raise ValueError("none")

    output = Output(Gone())
    print("ü", file=output)
    assert output.silent


ORIGINS = [
    {"case": 5},
    {"case": "cube-impact", "set": "cells=4"},
    {"case": "cube-impact", "set": [4]},
    {"case": "cube-impact", "set": [], "label": 3},
    {"case": "no-such-case", "set": []},
    {"case": "cube-impact", "set": ["cells=many"]},
    {"case": "cube-impact", "set": ["nonsense"]},
    {"case": "cube-impact", "set": [], "label": "no such label"},
    {"case": "bar-impact", "set": [], "label": "massless"},
    {"case": "friction-layer", "set": []},
    {"case": "absent.toml", "set": []},
    {"other": 1},
    [1, 2],
    None,
    "text",
]


@pytest.mark.parametrize("origin", ORIGINS, ids=str)
def test_an_origin_that_is_nonsense_is_named(origin, tmp_path, capsys):
    cells = np.arange(8).reshape(1, 8)
    ResultFile.create(tmp_path / "result.vtkhdf", np.random.default_rng(1).random((8, 3)), [("hex8", cells)]).close()
    store.write(tmp_path, {"physics": {}, "row": 0, "frames": 0, "origin": origin}, {"course.frames": 0}, {})
    assert main(["resume", str(tmp_path)]) == 2
    said = capsys.readouterr().err
    assert said.startswith("tcontact: ")
    assert said.count("\n") == 1


def test_an_origin_that_is_no_plain_data_is_refused_before_the_run():
    for origin in (5, {"case": {1, 2}}, {"case": object()}):
        with pytest.raises(tc.InputError, match="plain data"):
            tc.Checkpoint(every_steps=1, origin=origin)
