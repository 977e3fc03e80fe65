"""The command line: lists, help, bad usage, values of --set."""

from __future__ import annotations

import re
import subprocess
import sys

import pytest
from test_cli import ROOT, names

import tcontact as tc
from tcontact import cases
from tcontact.cases import cube_impact
from tcontact.commands import settings
from tcontact.commands.cli import main, parser
from tcontact.commands.words import joined


def test_list_names_every_case(capsys):
    assert main(["list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    files = sorted(path.stem.replace("_", "-") for path in (ROOT / "cases").glob("[a-z]*.py"))
    assert [line.split()[0] for line in lines] == files
    assert {"bar-impact", "cube-impact", "friction-layer", "sliding-block"} <= set(files)


def test_list_verbose_shows_parameters_with_their_choices(capsys):
    assert main(["list", "-v"]) == 0
    text = capsys.readouterr().out
    assert "massless | penalty | impulse" in text
    assert "10 / 3.6" in text
    assert "compare " in text


@pytest.mark.parametrize("name", cases.names())
def test_types_and_defaults_are_in_words_of_a_user(name):
    """Neither names of the source nor Python's notation for choices: each default is a number or one of the words."""
    for key, (kind, default) in cases.parameters(name).items():
        words = kind.split(" | ")
        assert all(re.fullmatch(r"[a-z][a-z0-9-]*|None", word) for word in words), (key, kind)
        value = eval(default, {})
        named = words == ["str"] or set(words) == {"str", "None"}
        assert not isinstance(value, str) or named or value in words, (key, kind, default)


def test_list_verbose_explains_every_case_and_its_parameters(capsys):
    """What a case is about and what its parameters mean stands in the list, not only their names."""
    for name in cases.names():
        assert main(["list", "-v", name]) == 0
        text = capsys.readouterr().out
        assert cases.about(name).partition("\n")[0] in text
        assert len(cases.about(name)) > 200, f"{name}: a case says what happens and what is checked"
        assert len(cases.about_parameters(name)) > 100, f"{name}: its scene explains its parameters"
    assert main(["list", "no-such-case"]) == 2
    assert "cube-impact" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "COMMAND"),
        (["fly"], "invalid choice"),
        (["run"], "CASE"),
        (["list", "cube-impact", "no-such-case"], f"use one of {', '.join(cases.names())}"),
        (["run", "cube"], f"use one of {', '.join(cases.names())}"),
        (["run", "cube-impact", "--set", "cell=4"], "it knows cells, kind"),
        (["run", "cube-impact", "--set", "cells"], "KEY=VALUE"),
        (["run", "cube-impact", "--set", "cells=four"], "a whole number"),
        (["run", "cube-impact", "--set", "cells=4.5"], "a whole number"),
        (["run", "cube-impact", "--set", "speed=fast"], "a number"),
        (["run", "cube-impact", "--set", "kind=hex20"], "hex8, tet4"),
        (["run", "cube-impact", "--set", "compare=perhaps"], "true or false"),
        (["run", "cube-impact", "--set", "density=-1"], "density = -1.0: must be greater than 0"),
        (["run", "cube-impact", "--set", "cfl=.5", "--set", "dt=1e-6"], "one of them"),
        (["run", "cube-impact", "--set", "scheme=euler"], "central-difference"),
        (["run", "cube-impact", "--set", "cfl=-1"], "cfl"),
        (["run", "bar-impact", "--set", "compare=true"], "no such parameter"),
        (["run", "hertz-impact", "--set", "radius=0"], "radius = 0.0: must be greater than 0"),
        (["run", "tumbling-block", "--set", "size=inf"], "size = inf: give a finite number"),
        (["run", "sliding-block", "--set", "damping=nan"], "damping = nan: give a finite number"),
        (["run", "sliding-block", "--set", "viscosity=-1"], "viscosity = -1.0: give a number of at least 0"),
        (["run", "ball-drop", "--set", "speed=1e-300"], "give values nearer to the defaults"),
        (["run", "bouncing-bar", "--set", "length=1e300"], "give values nearer to the defaults"),
        (["run", "cube-impact", "--threads", "0"], "--threads: '0': give whole numbers, 1 or more"),
        (["run", "cube-impact", "--threads", "two"], "--threads: 'two': give whole numbers, 1 or more"),
        (["run", "cube-impact", "--frames", "-1"], "--frames: '-1': give a whole number, 0 or more"),
        (["run", "cube-impact", "--frames", "2.5"], "--frames: '2.5': give a whole number, 0 or more"),
        (["run", "cube-impact", "--checkpoint", "soon"], "--checkpoint: 'soon': give a number, 0 or more"),
        (["run", "bar-impact", "--out", ""], "--out: '': give the name of a folder"),
        (["study", "bar-impact", "--out", ""], "--out: '': give the name of a folder"),
        (["resume", "nowhere", "--threads", "0"], "--threads: '0': give whole numbers, 1 or more"),
        (["resume", "nowhere", "--checkpoint", "-1"], "--checkpoint: '-1': give a number, 0 or more"),
        (["resume", "nowhere"], "no such folder"),
        (["render", "nowhere", "--scale", "nan"], "--scale: 'nan': give a number"),
        (["render", "nowhere", "--fps", "0"], "--fps: '0': give numbers above 0"),
        (["export", "nowhere", "--every", "0"], "--every: '0': give whole numbers, 1 or more"),
        (["study", "bar-impact", "--steps", "0.9,x"], "--steps: 'x': give numbers above 0"),
        (["study", "bar-impact", "--budget", "0"], "--budget: '0': give numbers above 0"),
        (["run", "cube-impact", "--arch", "abacus"], "--arch"),
        (["info", "nowhere"], "no such file"),
        (["render", "nowhere"], "no such file"),
        (["render", "nowhere", "--size", "big"], "--size"),
        (["render", "nowhere", "--clip", "x=0"], "x>0.05"),
        (["render", "nowhere", "--camera", "1,2"], "give 3 numbers"),
        (["render", "nowhere", "--range", "low,high"], "give 2 numbers"),
        (["render", "nowhere", "--range", "-1,1"], "no such file"),
        (["render", "nowhere", "--camera", "-1,-2,1", "--up", "-.5,0,1", "--time", "-1e-3"], "no such file"),
        (["render", "nowhere", "--camera", "-1,-2"], "--camera: give 3 numbers"),
        (["render", "nowhere", "--fps", "-1e0"], "--fps: '-1e0': give numbers above 0"),
        (["study", "bar-impact", "--steps", "-1,2"], "--steps: '-1': give numbers above 0"),
        (["render", "nowhere", "--range", "--view"], "--range: expected one argument"),
        (["render", "nowhere", "--time", "0", "--mp4"], "--mp4 = True: --time draws one frame only"),
        (["render", "nowhere", "--time", "0", "--fps", "5"], "--fps = 5.0: --time draws one frame only"),
        (["render", "nowhere", "--time", "0", "--plots"], "--time = 0.0: --plots draws curves only"),
        (["render", "nowhere", "--mp4", "--plots"], "--mp4 = True: --plots draws curves only"),
        (["export", "nowhere"], "no such file"),
        (["export", "nowhere", "--to", "stl"], "--to"),
        (["run", "cube-impact", "--set", "cells=2", "--fields", "heat"], "von_mises"),
    ],
)
def test_bad_usage_ends_with_2_and_says_what_to_do(arguments, message, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 2
    captured = capsys.readouterr()
    assert message in captured.err
    assert not captured.out
    assert not names(tmp_path), "bad usage must not leave files"
    assert not (tmp_path / "runs").exists()


def test_help_ends_with_0(capsys):
    assert main(["--help"]) == 0
    assert main(["run", "--help"]) == 0
    assert main(["--version"]) == 0
    assert tc.__version__ in capsys.readouterr().out


@pytest.mark.parametrize(
    ("key", "text", "expected"),
    [
        ("cells", "8", 8),
        ("speed", "1e1", 10.0),
        ("penalty", "none", None),
        ("penalty", "1e4", 1e4),
        ("kind", "tet4", "tet4"),
        ("duration", "None", None),
    ],
)
def test_values_are_read_by_their_declared_type(key, text, expected):
    found = settings.read("cube-impact", cube_impact, [f"{key}={text}"]).scene[key]
    assert found == expected
    assert type(found) is type(expected)


def test_keys_go_to_scene_scheme_or_comparison():
    wanted = settings.read("cube-impact", cube_impact, ["cells=4", "cfl=0.8", "compare=true"])
    assert (wanted.scene, wanted.scheme, wanted.compare) == ({"cells": 4}, {"cfl": 0.8}, True)


def test_an_error_of_a_case_with_its_defaults_is_no_bad_usage():
    def wrong():
        return 1.0 / 0.0

    with pytest.raises(ZeroDivisionError):
        settings.built(wrong, {})


HHT = {"scheme": "hilber-hughes-taylor", "dt": 1e-4, "alpha": -0.2}


@pytest.mark.parametrize(
    ("own", "given", "expected"),
    [
        (HHT, {}, tc.HilberHughesTaylor(dt=1e-4, alpha=-0.2)),
        (HHT, {"dt": 5e-5}, tc.HilberHughesTaylor(dt=5e-5, alpha=-0.2)),
        (HHT, {"cfl": 2.0}, tc.HilberHughesTaylor(cfl=2.0, alpha=-0.2)),
        (HHT, {"alpha": -0.05}, tc.HilberHughesTaylor(dt=1e-4, alpha=-0.05)),
        (HHT, {"scheme": "discrete-gradient"}, tc.DiscreteGradient(dt=1e-4)),
        (HHT, {"scheme": "central-difference"}, tc.CentralDifference()),
        ({}, {"cfl": 0.5}, tc.CentralDifference(cfl=0.5)),
        ({"scheme": "central-difference", "cfl": 0.2}, {"dt": 1e-6}, tc.CentralDifference(dt=1e-6)),
    ],
)
def test_options_change_a_scheme_and_keep_the_others(own, given, expected):
    assert settings.changed(own, given) == expected
    assert settings.changed(settings.options_of(expected), {}) == expected


def test_python_m_is_the_command_line():
    done = subprocess.run(
        [sys.executable, "-m", "tcontact", "list"], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert "cube-impact" in done.stdout


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["render", "r", "--range", "-1,1", "--mp4"], ["render", "r", "--range=-1,1", "--mp4"]),
        (["--camera", "-.5,0,1", "--time", "-1e-3"], ["--camera=-.5,0,1", "--time=-1e-3"]),
        (["--scale", "-inf", "--scale=2", "-3"], ["--scale=-inf", "--scale=2", "-3"]),
        (["--set", "speed=-3", "--view", "-x", "--", "-1"], ["--set", "speed=-3", "--view", "-x", "--", "-1"]),
    ],
)
def test_numbers_with_a_minus_sign_belong_to_the_option_before_them(words, expected):
    assert joined(words) == expected


def test_a_range_and_a_camera_with_minus_signs_are_read():
    words = joined(["render", "r", "--range", "-1,1", "--camera", "-1,-2,1", "--time", "-1e-3", "--scale", "-2"])
    read = parser("render").parse_args(words)
    assert (read.range, read.camera, read.time, read.scale) == ((-1.0, 1.0), (-1.0, -2.0, 1.0), -1e-3, -2.0)
