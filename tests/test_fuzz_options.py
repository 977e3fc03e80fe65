"""Any value in any place of what surrounds a run: schemes, checkpoints, scene files, export, pictures, resume."""

from __future__ import annotations

import contextlib
import copy
import dataclasses
import io
import traceback

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from test_fuzz_input import (
    MAT,
    MESH,
    SCALARS,
    SCENE,
    Hung,
    called,
    fuzz,
    in_any_place,
    limited,
    name_of,
    refused_runs,
)

import tcontact as tc
from tcontact.checkpoint.options import checked
from tcontact.cli import main
from tcontact.export import export
from tcontact.render import Camera, Clip, render_frames, render_picture
from tcontact.scene_files.toml import to_toml
from tcontact.schemes import IMPLICIT
from tcontact.vtkhdf import ResultData, ResultFile

SMALLEST = (160, 160)  # pixels of a picture


def of_scheme(scheme):
    """Its own arguments, with a step."""
    return {field.name: field.default for field in dataclasses.fields(scheme)} | {"dt": 1e-6}


GOOD = {scheme: of_scheme(scheme) for scheme in IMPLICIT} | {
    tc.MooneyRivlin: {"c1": 1e6, "c2": 1e5, "bulk": 1e7, "density": 1e3},
    tc.MooneyRivlin.of: {"young": 1e7, "poisson": 0.3, "density": 1e3, "second": 0.2},
    tc.Ogden: {"mu": (1e6, -1e3), "alpha": (1.3, -2.0), "poisson": 0.3, "density": 1e3},
    tc.Checkpoint: {"every_seconds": 1.0, "every_steps": None, "origin": {}},
    checked: {"value": 60.0, "out": "folder"},
    Clip: {"point": (0, 0, 0), "normal": (0, 0, 1)},
    Camera: {"direction": (1, -1, 1), "up": (0, 0, 1)},
    ResultData.open: {"path": "nowhere.vtkhdf"},
    tc.save_scene: {"scene": SCENE, "path": "scene.toml", "scheme": "central-difference", "frames": 3, "threads": 1},
}


def faults(build, good, values=SCALARS):
    """What goes wrong otherwise than by `InputError`, for each argument with each awkward value."""
    wrong = []
    for key in good:
        for value in values:
            try:
                called(build, {**good, key: value})
            except (Exception, Hung) as error:
                last = traceback.extract_tb(error.__traceback__)[-1]
                at = f"{last.filename}:{last.lineno}"
                wrong.append(f"{key} = {value!r:.60}: {type(error).__name__} {error!s:.80} ({at})")
    return wrong


@pytest.mark.parametrize("build", GOOD, ids=name_of)
def test_every_listed_value_in_every_place(build, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    wrong = faults(build, GOOD[build])
    assert not wrong, "\n" + "\n".join(wrong)


@pytest.mark.slow
@pytest.mark.parametrize("build", GOOD, ids=name_of)
def test_anything_in_a_place_is_taken_or_refused(build, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    in_any_place(build, GOOD[build], 400)


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    """A small result of two frames."""
    path, rng = tmp_path_factory.mktemp("stored") / "result.vtkhdf", np.random.default_rng(0)
    with ResultFile.create(path, MESH.nodes, [("hex8", MESH.cells)], {"title": "fuzz"}) as file:
        for time in (0.0, 1.0):
            nodal = {"displacement": 0.01 * rng.normal(size=(27, 3)), "contact_pressure": rng.random(27)}
            file.append(time, nodal, {"von_mises": rng.random(8)})
    return path


def test_export_takes_or_refuses_anything(stored, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    good = {"data": ResultData.open(stored), "out": "out", "format": "vtu", "fields": None, "every": 1}
    wrong = faults(export, good)
    assert not wrong, "\n" + "\n".join(wrong)


LOOK = {
    "field": "von_mises", "size": SMALLEST, "camera": None, "deformation_scale": 1.0, "obstacles": None,
    "range": None, "view": "above", "title": None, "colours": None, "clip": (),
}  # fmt: skip
PICTURE = {"path": "picture.png", "time": None} | LOOK
FRAMES = {"out": "out", "fps": None, "animation": False, "video": False} | LOOK


@pytest.mark.parametrize(("draw", "good"), [(render_picture, PICTURE), (render_frames, FRAMES)], ids=["one", "all"])
def test_pictures_take_or_refuse_anything(draw, good, stored, tmp_path, monkeypatch):
    """Values that are taken are drawn, so that what breaks later shows too."""
    monkeypatch.chdir(tmp_path)
    data = ResultData.open(stored)
    only = good if draw is render_picture else {key: good[key] for key in good if key not in LOOK}
    wrong = faults(lambda **changes: draw(data, **{**good, **changes}), only)
    assert not wrong, "\n" + "\n".join(wrong)
    with pytest.raises(tc.InputError):
        draw(3, **good)


WRONG = {
    "folder": "nowhere", "scene": 3, "scheme": "none", "threads": 0, "arch": "abacus", "progress": 2,
    "checkpoint": -1.0,
}  # fmt: skip


@pytest.mark.parametrize("examples", [60, pytest.param(1000, marks=pytest.mark.slow)])
def test_resume_refuses_what_is_wrong(examples, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "empty").mkdir()
    refused_runs(tc.resume, WRONG, {"folder": "empty", "scene": SCENE}, examples)
    wrong = faults(tc.resume, {"folder": "empty", "scene": SCENE})
    assert not wrong, "\n" + "\n".join(wrong)
    assert [path.name for path in tmp_path.rglob("*")] == ["empty"]


@pytest.mark.parametrize("key", ["checkpoint", "fields"])
def test_what_a_run_leaves_is_taken_or_refused(key, tmp_path, monkeypatch):
    """A scheme that is wrong ends the call before it runs; it is checked last."""
    monkeypatch.chdir(tmp_path)
    good = {"out": "out", "scheme": tc.Midpoint(dt=1e-6)}
    rubbing = dataclasses.replace(SCENE, friction=tc.Coulomb(0.1))
    wrong = faults(lambda **changes: tc.simulate(rubbing, **{**good, **changes}), {key: None})
    assert not wrong, "\n" + "\n".join(wrong)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize(
    ("scheme", "how"),
    [
        (tc.Midpoint, {"iterations": 1}),
        (tc.DiscreteGradient, {"cfl": 1e6, "dt": None}),
        (tc.PaperImplicit, {"rtol": 5e-324}),
        *[
            pytest.param(scheme, how, marks=pytest.mark.slow)
            for scheme in IMPLICIT
            for how in ({"rtol": 0.9}, {"rtol": 5e-324}, {"cfl": 1e6, "dt": None}, {"iterations": 1})
        ],
    ],
)
def test_implicit_runs_end_with_numbers_or_with_a_reason(scheme, how):
    """Steps that Newton's method cannot do, and tolerances that nothing meets or everything."""
    body = tc.Body(MESH.translated((0, 0, 1e-3)), MAT, velocity=(0, 0, -50.0), contact="zmin")
    scene = tc.Scene([body], [tc.Plane()], 1e-3)
    with limited():
        result = tc.simulate(scene, scheme=scheme(**{"dt": 2e-4, **how}))
    assert result.ok == (result.reason == "finished")
    assert result.ok or len(result.message.split()) > 3
    if result.ok:
        assert np.isfinite(result.position).all()
        assert np.isfinite(result.velocity).all()
        assert all(np.isfinite(result.history[name]).all() for name in ("kinetic", "elastic", "energy_error"))


TOML = {
    "duration": 1e-6,
    "gravity": [0.0, 0.0, -9.81],
    "contact": {"type": "MasslessContact", "removal": "full", "sweeps": 10},
    "friction": {"type": "Coulomb", "coefficient": 0.3},
    "damping": {"rate": 1.0},
    "run": {"scheme": {"cfl": 0.9}, "frames": 2, "threads": 1, "arch": "cpu", "history_every": 1, "history_rows": 9},
    "bodies": [
        {
            "mesh": {"box": [1.0, 1.0, 1.0], "cells": [2, 2, 2], "kind": "hex8"},
            "material": {"type": "NeoHookean", "young": 1e7, "poisson": 0.3, "density": 1e3},
            "velocity": [0.0, 0.0, -1.0],
            "contact": "zmin",
            "supports": [{"set": "xmin", "axes": "x", "velocity": 0.0}],
        }
    ],
    "obstacles": [{"type": "Plane", "normal": [0.0, 0.0, 1.0]}, {"type": "Sphere", "center": [0, 0, -9], "radius": 1}],
}
PLAIN = st.recursive(
    st.one_of(
        st.sampled_from(["", "zmin", "none", "auto", "NeoHookean", "Sdf", "nowhere.npz", "é", "nan", True, [], {}]),
        st.sampled_from([0, -1, 1, 2**31, 2**63 - 1, 0.0, -0.5, 1e308, 5e-324, float("nan"), float("inf")]),
        st.floats(),
        st.text(max_size=3),
    ),
    lambda inner: st.one_of(
        st.lists(inner, max_size=3),
        st.dictionaries(st.sampled_from(["type", "file", "array", "box", "a b", "velocity", "x"]), inner, max_size=3),
    ),
    max_leaves=5,
)


def places(table, at=()):
    """Every place of a nested table."""
    for key, value in table.items() if isinstance(table, dict) else enumerate(table):
        yield (*at, key)
        if isinstance(value, (dict, list)):
            yield from places(value, (*at, key))


@pytest.mark.parametrize("examples", [150, pytest.param(2000, marks=pytest.mark.slow)])
def test_scene_files_with_anything_anywhere_are_read_or_refused(examples, tmp_path, monkeypatch):
    """What is read can be planned, or is refused there; a key too many and one too few as well."""
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "scene.toml"

    def read():
        scene, options = tc.load_scene(file)
        assert isinstance(scene, tc.Scene)
        if np.isfinite(scene.duration):
            tc.plan(scene)
        return options

    @fuzz(examples)
    @given(st.sampled_from(list(places(TOML))), PLAIN, st.sampled_from(["set", "drop", "add"]))
    def run(place, value, how):
        data = copy.deepcopy(TOML)
        table = data
        for key in place[:-1]:
            table = table[key]
        if how == "drop":
            del table[place[-1]]
        elif how == "add" and isinstance(table, dict):
            table["type" if "type" not in table else "x"] = value
        else:
            table[place[-1]] = value
        try:
            file.write_text(to_toml(data), encoding="utf-8")
        except (tc.InputError, TypeError, ValueError):
            return  # not TOML at all
        called(read, {})

    run()
    file.write_text(to_toml(TOML), encoding="utf-8")
    assert read()["frames"] == 2


@pytest.mark.parametrize("examples", [60, pytest.param(1000, marks=pytest.mark.slow)])
def test_scene_files_of_any_bytes_are_refused(examples, tmp_path):
    file, good = tmp_path / "scene.toml", to_toml(TOML).encode()

    @fuzz(examples)
    @given(st.binary(max_size=8), st.integers(0, len(good)), st.integers(0, 60))
    def run(new, start, length):
        file.write_bytes(good[:start] + new + good[start + length :])
        called(tc.load_scene, {"path": file})

    run()


LONG = "a" * 300
TOLD = st.sampled_from(
    [
        "--field", "--colours", "--range", "--size", "--view", "--camera", "--up", "--scale", "--clip", "--time",
        "--fps", "--to", "--fields", "--every", "--out", "von_mises", "heat", "above", "0,0,1", "0,0,0", "1,2", "2,1",
        "nan", "inf", "-1", "0", "1e999", "x>0.5", "x>9", "x<9", "z>nan", "160x160", "1x1", "99999x99999", "xdmf", "",
        LONG, "\0", "viridis",
    ]
)  # fmt: skip


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("examples", [60, pytest.param(600, marks=pytest.mark.slow)])
@pytest.mark.parametrize("command", ["render", "export"])
def test_options_of_pictures_and_export_end_with_0_or_2(command, examples, stored, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    first = ["--size", "160x160", "--time", "0"] if command == "render" else []

    @fuzz(examples)
    @given(st.lists(TOLD, max_size=4))
    def run(words):
        said = io.StringIO()
        with limited(), contextlib.redirect_stderr(said), contextlib.redirect_stdout(said):
            code = main([command, str(stored), *first, "--out", "out", *words])
        assert code in (0, 2), (words, code, said.getvalue())
        assert said.getvalue()

    run()


@pytest.mark.parametrize("command", ["render", "export", "info", "resume", "run"])
def test_names_that_no_file_can_have_are_refused(command, capsys):
    for name in (LONG, LONG + ".toml", "a\0b"):
        assert main([command, name]) == 2
        assert "Traceback" not in capsys.readouterr().err
