"""Any value in any place of what surrounds a run: schemes, checkpoints, scene files, export, pictures, resume."""

from __future__ import annotations

import dataclasses
import traceback

import numpy as np
import pytest
from test_fuzz_input import MESH, SCALARS, SCENE, Hung, called, in_any_place, name_of

import tcontact as tc
from tcontact.checkpoint.options import checked
from tcontact.export import export
from tcontact.render import Camera, Clip, render_frames, render_picture
from tcontact.schemes import IMPLICIT
from tcontact.vtkhdf import ResultData, ResultFile

SMALLEST = (160, 160)  # pixels of a picture


def of_scheme(scheme):
    """Its own arguments, with a step."""
    return {field.name: field.default for field in dataclasses.fields(scheme)} | {"dt": 1e-6}


GOOD = {scheme: of_scheme(scheme) for scheme in IMPLICIT} | {
    tc.MooneyRivlin: {"c1": 1e6, "c2": 1e5, "bulk": 1e7, "density": 1e3},
    tc.MooneyRivlin.of: {"young": 1e7, "poisson": 0.3, "density": 1e3, "second": 0.2},
    tc.ImpulseContact: {field.name: field.default for field in dataclasses.fields(tc.ImpulseContact)},
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


def unnamed(value):
    return not isinstance(value, str)


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
