"""The web page of a run: whole in itself, true to the files of the run, and alive in a browser."""

from __future__ import annotations

import base64
import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest

import tcontact as tc
from tcontact.commands import report_page
from tcontact.commands.cli import main
from tcontact.commands.folder import our_files
from tcontact.results.files.vtkhdf import ResultFile
from tcontact.scene.obstacles.description import describe
from tcontact.show.page import curves, document, surface
from tcontact.show.page.packed import packed

KINDS = {"f8": "<f8", "i4": "<i4", "u2": "<u2"}


def numbers(text: str, kind: str) -> np.ndarray:
    return np.frombuffer(base64.b64decode(text), KINDS[kind])


def data_of(path: Path) -> dict:
    """What the script of a page reads."""
    text = path.read_text(encoding="utf-8")
    (found,) = re.findall(r'<script type="application/json" id="data">(.*?)</script>', text, flags=re.DOTALL)
    return json.loads(found)


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """A run of the command line with pictures: a small cube that strikes a plane, in 6 frames."""
    place = tmp_path_factory.mktemp("page") / "run"
    settings = ["--set", "cells=3", "--set", "pitch=20", "--frames", "6", "--quiet", "--out", str(place)]
    assert main(["run", "cube-impact", *settings]) in (0, 1)
    return place


@pytest.fixture(scope="module")
def page(folder) -> Path:
    assert main(["report", str(folder)]) == 0
    return folder / "report.html"


def test_the_page_needs_no_other_file_and_no_network(page):
    text = page.read_text(encoding="utf-8")
    assert page.stat().st_size < 3e6
    assert not re.findall(r"""(?:src|href)=["'](?!data:|%)[^"']*["']""", text.split('id="data"')[0])
    assert not re.findall(r"url\(\s*['\"]?http|@import|<link[^>]+stylesheet|import\s*\(", text)
    assert "MIT" in (Path(document.__file__).parent / "assets" / "LICENSE-three.txt").read_text(encoding="utf-8")
    assert [path.name for path in page.parent.glob(".*.part")] == []


def test_curves_are_those_of_the_history(page, folder):
    (run,) = data_of(page)["runs"]
    history = tc.open_result(folder).history
    figures = {group["title"]: {line["name"]: line for line in group["lines"]} for group in run["figures"]}
    assert set(figures) == {"Contact force", "Energies", "Energy error", "Smallest gap"}
    force = figures["Contact force"]["computed"]
    np.testing.assert_array_equal(numbers(force["x"], "f8"), history["time"])
    np.testing.assert_array_equal(numbers(force["y"], "f8"), history["contact_force"][:, 2])
    np.testing.assert_array_equal(numbers(figures["Energies"]["elastic"]["y"], "f8"), history["elastic"])
    shown = {group["title"]: group for group in run["columns"]}
    momentum = [numbers(line["y"], "f8") for line in shown["momentum"]["lines"]]
    np.testing.assert_array_equal(momentum, history["momentum"].T)
    assert shown["momentum"]["unit"] == "kg m/s"


def test_surface_and_fields_are_those_of_the_frames(page, folder):
    (run,) = data_of(page)["runs"]
    stored, shown = tc.open_result(folder), run["surface"]
    np.testing.assert_array_equal(run["times"], stored.frames.times)
    studio = surface.studio_of(stored)
    fields = {field["name"]: field for field in shown["fields"]}
    assert next(iter(fields)) == "Von Mises stress"
    corners = numbers(shown["corners"], "i4").reshape(-1, 3)
    for index, place in enumerate(shown["positions"]):
        frame = stored.frames.frame(index)
        x = numbers(place, "u2").reshape(-1, 3) / 32767.5 - 1.0
        exact = (stored.frames.points + frame.point_data["displacement"])[studio.surface.nodes]
        found = np.array(shown["middle"]) + shown["reach"] * x
        assert np.abs(found - exact).max() <= 1.6e-5 * shown["reach"]
        stress = fields["Von Mises stress"]
        span = stress["high"] - stress["low"]
        values = stress["low"] + span * numbers(stress["frames"][index], "u2") / 65535.0
        known = np.clip(frame.cell_data["von_mises"][studio.surface.owner], stress["low"], stress["high"])
        assert np.abs(values - known).max() <= 1e-5 * span
        a, b, c = (exact[corners[:, k]] for k in range(3))
        volume = np.einsum("ni,ni->n", a, np.cross(b, c)).sum() / 6.0  # outward faces that close the body
        assert volume == pytest.approx(0.1**3, rel=0.2)
    assert fields["Von Mises stress"]["peaks"][-1] == pytest.approx(stored.frames.frame(5).cell_data["von_mises"].max())
    assert numbers(shown["edges"], "i4").reshape(-1, 2).shape == (2 * 6 * 9, 2)
    (plane,) = shown["obstacles"]
    height = numbers(plane["points"], "f8").reshape(-1, 3)[:, 2] * shown["reach"] + shown["middle"][2]
    np.testing.assert_allclose(height, 0.0, atol=1e-12)


def test_verdict_checks_and_tables_are_those_of_the_summary(page, folder):
    (run,) = data_of(page)["runs"]
    summary = json.loads((folder / "summary.json").read_text())
    assert [one["name"] for one in run["checks"]] == [check["name"] for check in summary["checks"]]
    assert [one["passed"] for one in run["checks"]] == [check["passed"] for check in summary["checks"]]
    assert run["verdict"]["good"] == summary["passed"]
    rows = {title: dict(map(tuple, rows)) for title, rows in run["tables"]}
    assert set(rows) == {"Ledger", "Scene", "Run"}
    assert "27 hex8" in rows["Scene"]["cells"]
    assert rows["Scene"]["obstacles"] == "plane"
    assert f"{summary['energy_error_max']:.2g}" in rows["Ledger"]["energy error, largest"]


def moving(tmp_path, **options) -> Path:
    """A block that a lid, which moves and turns, presses onto a plane."""
    law = tc.LinearElastic(1e6, 0.3, 1000.0)
    block = tc.Body(tc.box_mesh((0.1, 0.1, 0.1), (2, 2, 2)), law, contact=["zmin", "zmax"], name="block")
    lid = tc.Plane(
        (0.0, 0.0, 0.1001), (0.0, 0.0, -1.0), name="lid", velocity=(0, 0, -0.1), angular_velocity=(0, 0.5, 0)
    )
    scene = tc.Scene([block], [tc.Plane(), lid], duration=0.01, contact=tc.MasslessContact())
    tc.simulate(scene, out=tmp_path / "moving", **options)
    return tmp_path / "moving"


def test_an_obstacle_is_where_it_was(tmp_path):
    place = moving(tmp_path, frames=4)
    stored, shown = tc.open_result(place), document.run_of(tc.open_result(place))["surface"]
    pose = stored.frames.attributes["obstacles"][1]["motion"]
    lid = shown["obstacles"][1]
    assert len(lid["places"]) == len(stored.frames)
    for matrix, point, frame in zip(lid["places"], pose["point"], pose["frame"], strict=True):
        points = numbers(lid["points"], "f8").reshape(-1, 3) @ np.array(matrix).reshape(4, 4)[:3, :3].T
        points = (points + np.array(matrix).reshape(4, 4)[:3, 3]) * shown["reach"] + shown["middle"]
        np.testing.assert_allclose((points - point) @ np.array(frame)[2], 0.0, atol=1e-12)
        corners = points[numbers(lid["corners"], "i4").reshape(-1, 3)]
        outward = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        assert (outward @ np.array(frame)[2] > 0).all(), "it is seen from the side of the bodies"


def test_a_name_cannot_break_the_page(tmp_path):
    place = moving(tmp_path, frames=1)
    summary = json.loads((place / "summary.json").read_text()) | {"case": "</script><b>bad"}
    (place / "summary.json").write_text(json.dumps(summary))
    path = document.write_page([place], tmp_path / "page.html")
    assert "<b>bad" not in path.read_text(encoding="utf-8")
    assert data_of(path)["runs"][0]["title"] == "</script><b>bad"


def test_a_page_shows_a_name_that_has_no_encoding(tmp_path):
    place = moving(tmp_path, frames=1)
    summary = json.loads((place / "summary.json").read_text()) | {"case": "caf\udce9"}
    (place / "summary.json").write_text(json.dumps(summary))
    assert "<title>caf?" in document.write_page([place], tmp_path / "page.html").read_text(encoding="utf-8")


def test_a_summary_that_cannot_be_read_leaves_its_checks_unknown(tmp_path):
    place = moving(tmp_path, frames=1)
    for spoil in (
        lambda path: path.write_text("[1,2"),
        lambda path: path.write_text('{"case": "a", "checks": "all passed"}'),
        Path.unlink,
    ):
        spoil(place / "summary.json")
        (run,) = data_of(document.write_page([place], tmp_path / "page.html"))["runs"]
        assert "checks unknown" in run["verdict"]["text"]


def test_a_run_without_frames_and_one_that_stopped_say_so(tmp_path):
    place = moving(tmp_path, frames=0)
    (run,) = data_of(document.write_page([place], tmp_path / "page.html"))["runs"]
    assert (run["surface"], run["film"], run["times"]) == (None, [], [])
    assert "no frames" in run["without"]
    mesh, law = tc.box_mesh((1.0, 1.0, 1.0), (2, 2, 2)), tc.NeoHookean(1e3, 0.3, 1000.0)
    scene = tc.Scene([tc.Body(mesh, law, (0, 0, -40.0), contact="zmin")], [tc.Plane()], 0.1)
    stopped = tc.simulate(scene, out=tmp_path / "stopped", frames=10)
    assert not stopped.ok
    (run,) = data_of(document.write_page([tmp_path / "stopped"], tmp_path / "page.html"))["runs"]
    assert run["verdict"] == {"good": False, "text": f"stopped: {stopped.reason}", "message": stopped.message}
    assert len(run["film"]) == len(run["surface"]["positions"]) > 0


def test_a_frame_of_a_body_blown_up_does_not_spoil_the_others(tmp_path):
    mesh, obstacles = tc.box_mesh((1.0, 1.0, 1.0), (2, 2, 2)), [tc.Plane()]
    frames = [np.zeros_like(mesh.nodes), np.full_like(mesh.nodes, np.nan), 1e30 * (mesh.nodes - 0.5)]
    path = tmp_path / "result.vtkhdf"
    with ResultFile.create(path, mesh.nodes, [("hex8", mesh.cells)], {"obstacles": describe(obstacles, ())}) as file:
        for time, moved in enumerate(frames):
            file.append(float(time), {"displacement": moved}, {"von_mises": np.full(8, np.nan if time == 1 else 1.0)})
    studio = surface.studio_of(tc.open_result(path))
    shown = surface.surface_of(studio, [0, 1, 2])
    assert (shown["middle"], shown["reach"]) == ([0.5, 0.5, 0.5], 0.5)
    x = numbers(shown["positions"][0], "u2").reshape(-1, 3) / 32767.5 - 1.0
    np.testing.assert_allclose(0.5 + 0.5 * x, mesh.nodes[studio.surface.nodes], atol=1e-5)
    assert len(shown["fields"][0]["frames"]) == 3


def test_runs_stand_side_by_side_and_a_comparison_is_all_of_them(folder, tmp_path):
    shutil.copytree(folder, tmp_path / "second")
    path = tmp_path / "both.html"
    assert main(["report", str(folder), str(tmp_path / "second"), "--out", str(path)]) == 0
    assert len(data_of(path)["runs"]) == 2
    own = tmp_path / "second" / "report.html"
    own.write_text("of one run")
    assert main(["report", str(tmp_path / "second"), str(folder)]) == 0
    assert len(data_of(tmp_path / "second" / "side-by-side.html")["runs"]) == 2
    assert own.read_text() == "of one run"
    assert tmp_path / "second" / "side-by-side.html" in our_files(tmp_path / "second")
    whole = tmp_path / "comparison"
    shutil.copytree(folder, whole / "one")
    shutil.copytree(folder, whole / "two")
    (whole / "summary.json").write_text(json.dumps({"runs": ["one", "two"], "labels": ["One", "Two"]}))
    assert main(["report", str(whole)]) == 0
    assert len(data_of(whole / "report.html")["runs"]) == 2


def test_a_study_is_a_table_with_its_figure(tmp_path):
    rows = [{"method": "massless", "error": 0.0123456, "ok": True, "sizes": [1]}, {"method": "penalty", "wall_s": 2.0}]
    (tmp_path / "study.json").write_text(json.dumps({"case": "bar-impact", "rows": rows}))
    (tmp_path / "study.png").write_bytes(b"picture")
    assert main(["report", str(tmp_path)]) == 0
    (study,) = data_of(tmp_path / "report.html")["studies"]
    assert study["title"] == "study bar-impact"
    assert study["head"] == ["method", "error", "ok", "wall s"]
    assert study["rows"] == [["massless", "0.01235", "yes", ""], ["penalty", "", "", "2"]]
    assert base64.b64decode(study["picture"]) == b"picture"
    (tmp_path / "study.json").write_text("{")
    with pytest.raises(tc.InputError, match=r"study\.json"):
        document.write_page([tmp_path], tmp_path / "page.html")


def test_what_has_no_page_is_refused(folder, tmp_path, capsys):
    assert main(["report", str(tmp_path / "absent")]) == 2
    assert main(["report", *[str(folder)] * 5]) == 2
    assert "up to 4" in capsys.readouterr().err
    (tmp_path / "file").write_text("")
    assert main(["report", str(folder), "--out", str(tmp_path / "file" / "page.html")]) == 2
    assert main(["run", "friction-layer", "--open", "--out", str(tmp_path / "layer")]) == 2
    assert "--open" in capsys.readouterr().err
    assert not (tmp_path / "layer").exists()


@pytest.mark.parametrize(("display", "opened"), [(":0", 1), ("", 0)])
def test_the_page_opens_where_there_is_a_display(display, opened, folder, monkeypatch, capsys, tmp_path):
    shown = []
    monkeypatch.setattr(report_page.webbrowser, "open", lambda address: shown.append(address) or True)
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("DISPLAY", display)
    monkeypatch.setattr(report_page.sys, "platform", "linux")
    assert main(["report", str(folder), "--open", "--out", str(tmp_path / "a page.html")]) == 0
    assert len(shown) == opened
    assert ("by hand" in capsys.readouterr().out) == (not opened)


def test_a_long_history_keeps_every_peak():
    time = np.linspace(0.0, 1.0, 200_000)
    values = np.sin(40.0 * time)
    values[123_457], values[77] = 9.0, -8.0
    x, y = curves.thinned(time, values)
    assert len(x) <= 4 * curves.PIECES
    assert (np.diff(x) > 0).all()
    assert (y.max(), y.min()) == (9.0, -8.0)
    np.testing.assert_array_equal(y, values[np.searchsorted(time, x)])
    assert (x[0], x[-1]) == (0.0, 1.0)


def test_a_large_run_shows_fewer_frames(folder, monkeypatch):
    studio = surface.studio_of(tc.open_result(folder))
    assert surface.chosen_frames(studio) == [0, 1, 2, 3, 4, 5]
    monkeypatch.setattr(surface, "ROOM", 2000)
    assert surface.chosen_frames(studio) == [0, 5]
    monkeypatch.setattr(surface, "FACES", 10)
    assert surface.surface_of(studio, [0, 5]) is None


def test_numbers_of_16_bits_keep_ends_and_what_is_not_finite():
    found = packed(np.array([1.0, np.nan, 3.0, np.inf, 2.0]))
    assert (found["low"], found["high"]) == (1.0, 3.0)
    np.testing.assert_array_equal(numbers(found["data"], "u2"), [0, 0, 65535, 0, 32768])
    assert packed(np.zeros(3))["data"] == packed(np.zeros(3), 0.0, 1.0)["data"]
