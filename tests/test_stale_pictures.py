"""A folder of pictures holds one series: what an earlier one has left there and the new one has not is removed."""

from __future__ import annotations

import numpy as np
import pytest
import series

import tcontact as tc
from tcontact.commands.cli import main
from tcontact.results.files.vtkhdf import ResultFile
from tcontact.show import render

BOX = tc.box_mesh((1.0, 1.0, 1.0), (2, 2, 2))
PLANE = {"kind": "plane", "point": [0.0, 0.0, 0.0], "normal": [0.0, 0.0, 1.0]}
SIZE = {"size": (160, 160)}
FILM = {"animation.gif", "animation.mp4"}


def touching(folder):
    """Write a run of a box that is pressed on a plane; return its result file."""
    folder.mkdir()
    pressure = np.where(BOX.nodes[:, 2] == 0.0, 1e6, 0.0)
    nodal = {
        "displacement": np.zeros_like(BOX.nodes),
        "contact_pressure": pressure,
        "contact_force": pressure[:, None] * [0.0, 0.0, 0.04],
    }
    with ResultFile.create(folder / "result.vtkhdf", BOX.nodes, [("hex8", BOX.cells)], {"obstacles": [PLANE]}) as file:
        for time in (0.0, 1e-3):
            file.append(time, nodal, {"von_mises": np.arange(8.0)})
    return folder / "result.vtkhdf"


@pytest.fixture
def runs(tmp_path):
    """A run of one body that touches a plane, and one of two bodies without obstacles."""
    (tmp_path / "two").mkdir()
    return touching(tmp_path / "one"), series.written(tmp_path / "two")


def beside(folder):
    """Names of the files beside the frames."""
    return {path.name for path in folder.iterdir() if path.is_file()} - {"result.vtkhdf"}


def test_files_of_the_series_before_go(runs, tmp_path, capsys):
    """The contact face of another run, its bodies and its film; files of other names and of pictures alone stay."""
    one, two = runs
    out = tmp_path / "pictures"
    assert main(["render", str(one), "--out", str(out), "--size", "160x160"]) == 0
    assert beside(out) - FILM == {"contact-face.png"}
    (out / "animation.mp4").write_bytes(b"a film of the series before")
    (out / "notes.txt").write_text("of the user")
    render.render_picture(two, out / "one.png", **SIZE)
    assert "contact-face.png" in beside(out), "one picture is no series"
    written = render.render_frames(two, out, video=False, **SIZE)
    assert beside(out) == {"animation.gif", "bodies.png", "notes.txt", "one.png"}
    assert {path.name for path in written if path.parent == out} == {"animation.gif", "bodies.png"}
    render.render_frames(one, out, clip=[render.Clip((0.5, 0.0, 0.0), (1.0, 0.0, 0.0))], animation=False, **SIZE)
    assert beside(out) == {"notes.txt", "one.png"}


def test_pictures_that_a_series_leaves_out_stay_in_the_folder_of_their_run(runs):
    """They are of this run still; a contact face that the run has not goes."""
    for path, wish in zip(runs, ({"clip": [render.Clip((0.5, 0, 0), (1, 0, 0))]}, {"field": "body"}), strict=True):
        render.render_frames(path, path.parent, video=False, **SIZE)
        known = beside(path.parent)
        assert known == {"animation.gif", "contact-face.png" if path == runs[0] else "bodies.png"}
        render.render_frames(path, path.parent, animation=False, **wish, **SIZE)
        assert beside(path.parent) == known
        other = path.parent / ("bodies.png" if path == runs[0] else "contact-face.png")
        other.write_bytes(b"of the run that stood here")
        render.render_frames(path, path.parent, video=False, **SIZE)
        assert beside(path.parent) == known


def test_a_folder_without_an_earlier_series_keeps_what_is_in_it(runs, tmp_path):
    out = tmp_path / "own"
    out.mkdir()
    for name in ("contact-face.png", "animation.mp4"):
        (out / name).write_bytes(b"of the user")
    render.render_frames(runs[1], out, video=False, **SIZE)
    assert (out / "contact-face.png").read_bytes() == (out / "animation.mp4").read_bytes() == b"of the user"
