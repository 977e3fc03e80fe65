"""The command line: exit codes, files, messages of runs."""

from __future__ import annotations

import contextlib
import csv
import dataclasses
import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import meshio
import numpy as np
import pytest

import tcontact as tc
from tcontact.cases import bar_impact
from tcontact.commands import cli, folder, info
from tcontact.commands.cli import main
from tcontact.results.checks import at_most
from tcontact.results.files.vtkhdf import ResultData
from tcontact.results.report import si

ROOT = Path(__file__).resolve().parent.parent
NUMBERS = {"summary.json", "history.csv", "result.vtkhdf", "contact-force.png", "gap.png", "energy.png"}
SMALL = ["--set", "cells=4", "--frames", "0"]


def names(path: Path) -> set[str]:
    """Files below a folder, by their relative names."""
    return {item.relative_to(path).as_posix() for item in path.rglob("*") if item.is_file()}


def read(path: Path) -> dict:
    """A summary."""
    return json.loads(path.read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def cube(tmp_path_factory) -> tuple[Path, str]:
    """A small cube impact with pictures: its folder and what was printed."""
    out = tmp_path_factory.mktemp("cube") / "run"
    command = [
        sys.executable,
        "-m",
        "tcontact",
        "run",
        "cube-impact",
        "--set",
        "cells=4",
        "--frames",
        "5",
        "--out",
        out,
    ]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return out, done.stdout + done.stderr


def test_the_first_line_comes_before_anything_is_compiled(monkeypatch, capsys, tmp_path):
    def stopped(*_, **__):
        raise tc.OutputError("not yet")

    monkeypatch.setattr(tc, "simulate", stopped)
    assert main(["run", "bar-impact", *SMALL, "--out", str(tmp_path / "out")]) == 1
    assert capsys.readouterr().out == "bar-impact: 4 cells, 20 nodes, no frames\n"


def test_what_a_command_leaves_is_not_looked_through_at_its_end():
    """Objects that Python will not look at when the process ends, counted by what is called just before that."""
    count = "atexit.register(lambda: print(gc.get_freeze_count()))"  # after what is registered later
    code = (
        f"import atexit, gc; {count}; from tcontact.commands.cli import main; main(['--version']); main(['--version'])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)
    assert int(done.stdout.split()[-1]) > 10_000


def test_info_draws_a_curve_in_a_line():
    line = info.sparkline(np.concatenate([np.zeros(60), np.linspace(0, 1, 60), np.full(60, np.nan)]), 30)
    assert len(line) == 30
    assert set(line[:10]) == set(line[20:]) == {" "}
    assert list(line[10:20]) == sorted(line[10:20])
    assert line[19] == "█"
    assert info.sparkline(np.zeros(3)) == "   "


def test_run_leaves_numbers_result_and_pictures(cube):
    out, _ = cube
    found = names(out)
    assert found >= NUMBERS
    assert "animation.gif" in found
    assert "contact-face.png" in found
    assert len([name for name in found if name.startswith("frames/")]) == len(ResultData.open(out / "result.vtkhdf"))


def test_summary_holds_scalars_parameters_checks_and_versions(cube):
    data = read(cube[0] / "summary.json")
    assert data["case"] == "cube-impact"
    assert data["parameters"]["cells"] == 4
    assert data["parameters"]["law"] == "neo-hookean"
    assert data["reason"] == "finished"
    assert data["passed"] is True
    for key in (
        "steps",
        "time",
        "dt",
        "dt_limit",
        "wall_s",
        "compile_s",
        "cell_updates_per_s",
        "energy_error_max",
        "threads",
    ):
        assert data[key] > 0, key
    assert {check["name"] for check in data["checks"]} >= {
        "finished",
        "contact pushes",
        "energy error",
        "overlap / size",
    }
    assert set(data["checks"][0]) == {"name", "value", "bound", "passed"}
    assert set(data["versions"]) == {"tcontact", "taichi", "numpy", "python"}
    assert len(data["last_row"]["contact_force"]) == 3


def test_history_csv_is_the_history_of_the_result_file(cube):
    out, _ = cube
    stored = ResultData.open(out / "result.vtkhdf").history
    with (out / "history.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == read(out / "summary.json")["steps"] + 1
    for name in ("time", "energy", "gap_min"):
        np.testing.assert_array_equal([float(row[name]) for row in rows], stored[name])


def test_table_gives_speed_with_error_and_checks_and_no_bar_off_a_terminal(cube):
    text = cube[1]
    assert "cube-impact: finished at" in text
    assert any("Mcell/s" in line and "energy error" in line for line in text.splitlines())
    assert "compile" in text
    assert "pass  finished" in text
    assert "%" not in text
    assert "\x1b" not in text


def test_info_shows_a_run_from_folder_and_from_file(cube, capsys):
    out, _ = cube
    assert main(["info", str(out)]) == 0
    text = capsys.readouterr().out
    assert "cube-impact: finished" in text
    assert "64 hex8" in text
    assert "cells=4" in text
    assert "obstacles plane" in text
    force = np.linalg.norm(ResultData.open(out / "result.vtkhdf").history["contact_force"], axis=1).max()
    assert f"at most {si(force, 'N')}" in text
    assert "von_mises (up to " in text
    alone = out.parent / "copy.vtkhdf"
    alone.write_bytes((out / "result.vtkhdf").read_bytes())
    assert main(["info", str(alone)]) == 0
    text = capsys.readouterr().out
    assert "125 nodes" in text
    assert "energy error" in text


def test_info_names_obstacles(tmp_path, capsys):
    mesh = tc.box_mesh((0.1, 0.1, 0.1), (2, 2, 2), origin=(0.0, 0.0, 1e-3))
    walls = [tc.Plane(name="floor"), tc.Plane((-0.1, 0, 0), (1, 0, 0), velocity=(0.1, 0, 0), name="ram")]
    body = tc.Body(mesh, tc.NeoHookean(1e6, 0.3, 1000.0), contact="zmin")
    tc.simulate(tc.Scene([body], walls, duration=1e-4), out=tmp_path / "run")
    assert main(["info", str(tmp_path / "run")]) == 0
    assert "  obstacles plane 'floor', plane 'ram' (moving)\n" in capsys.readouterr().out


def test_info_shows_what_simulate_left(tmp_path, capsys):
    tc.simulate(bar_impact.scene(cells=4), out=tmp_path / "mine", frames=2)
    assert main(["info", str(tmp_path / "mine")]) == 0
    text = capsys.readouterr().out
    assert "mine: finished at" in text
    assert "2 frames" in text


def test_info_shows_a_case_without_a_scene(tmp_path, capsys):
    data = {
        "case": "layer",
        "parameters": {"velocity": 34.0},
        "figures": {"slow": {"heat": 2.5}},
        "versions": {"a": "1"},
    }
    checks = [{"name": "warm", "value": 1.0, "bound": "<= 2", "passed": True}]
    (tmp_path / "summary.json").write_text(json.dumps(data | {"checks": checks}), encoding="utf-8")
    assert main(["info", str(tmp_path)]) == 0
    text = capsys.readouterr().out
    assert "slow: heat 2.5" in text
    assert "pass  warm" in text
    assert "velocity=34" in text


def test_info_names_the_report_where_the_folder_is_that_of_a_study(tmp_path, capsys):
    """A study has rows and a figure, which the page of `tcontact report` shows."""
    (tmp_path / "study.json").write_text(json.dumps({"case": "bar-impact", "rows": [{"error": 0.1}]}), encoding="utf-8")
    assert main(["info", str(tmp_path)]) == 2
    assert f"holds a study, no run; `tcontact report {tmp_path}` makes a page of it" in capsys.readouterr().err
    assert main(["report", str(tmp_path)]) == 0


def test_info_refuses_what_is_no_run(tmp_path, capsys):
    (tmp_path / "result.vtkhdf").write_bytes(b"no HDF5 at all")
    (tmp_path / "empty").mkdir()
    assert main(["info", str(tmp_path / "result.vtkhdf")]) == 2
    assert main(["info", str(tmp_path / "empty")]) == 2
    assert "holds no run" in capsys.readouterr().err
    damaged = ({"checks": "all passed"}, {"checks": [1]}, {"runs": 3}, {"dt": "short"}, {"figures": {"slow": 1}})
    for part in damaged:
        (tmp_path / "empty" / "summary.json").write_text(json.dumps({"case": "a"} | part), encoding="utf-8")
        assert main(["info", str(tmp_path / "empty")]) == 2
        assert re.search("not the summary|damaged", capsys.readouterr().err)


def test_render_draws_another_field_into_another_folder(cube, tmp_path, capsys):
    out, _ = cube
    stale = tmp_path / "pictures" / "frames" / "frame-9999.png"
    stale.parent.mkdir(parents=True)
    stale.write_bytes(b"an earlier, longer series")
    arguments = ["render", str(out), "--field", "velocity", "--size", "320x240", "--out", str(tmp_path / "pictures")]
    assert main(arguments) == 0
    assert "frames/frame-0000.png" in names(tmp_path / "pictures")
    assert not stale.exists()
    assert main(["render", str(out), "--field", "colour", "--out", str(tmp_path)]) == 2
    assert "velocity" in capsys.readouterr().err


@pytest.mark.parametrize("fields", [[], ["--fields", "displacement,velocity"]])
def test_render_without_options_draws_the_pictures_of_the_run_again(fields, tmp_path):
    """They have the same bits: field, range and title, of a run with settings and of one with other fields."""
    out = tmp_path / "run"
    assert main(["run", "cube-impact", "--set", "cells=2", "--out", str(out), "--frames", "2", "--quiet", *fields]) == 0
    drawn = {path: path.read_bytes() for path in out.rglob("*.png") if path.parent.name == "frames"}
    assert len(drawn) == 2
    assert main(["render", str(out)]) == 0
    assert {path: path.read_bytes() for path in drawn} == drawn
    assert main(["render", str(out), "--field", "displacement"]) == 0
    assert {path: path.read_bytes() for path in drawn} != drawn


def test_render_takes_its_options(cube, tmp_path, capsys):
    out, _ = cube
    look = [
        "--clip",
        "x>0",
        "--clip",
        "y<0",
        "--colours",
        "magma",
        "--range",
        "0,1e5",
        "--scale",
        "3",
        "--size",
        "320x240",
    ]
    wish = ["render", str(out), "--field", "von_mises", "--time", "1e-3", "--out", str(tmp_path), *look]
    assert main([*wish, "--camera", "1,-1,1", "--up", "0,0,1"]) == 0
    (picture,) = names(tmp_path)
    assert re.fullmatch(r"picture-von_mises-0\.000\d+s\.png", picture)
    assert main([*wish[:-2], "--size", "320x240", "--up", "0,0,1"]) == 2
    assert "--camera" in capsys.readouterr().err
    assert main([*wish, "--camera", "1,-1,1", "--view", "below"]) == 2
    assert "--view = 'below': give it or --camera" in capsys.readouterr().err
    assert main(["export", str(out), "--fields", ",", "--out", str(tmp_path / "none")]) == 2
    assert "name at least one field" in capsys.readouterr().err


@pytest.mark.parametrize(("camera", "up"), [("0,0,1", "0,1,0"), ("0,0,-1", "0,1,0"), ("-1,-2,1", "0,0,1")])
def test_a_look_along_the_usual_upward_direction_has_another_one(camera, up, cube, tmp_path, capsys):
    """A look from straight above, z towards the eye, has y upward; any other has z."""
    pictures = []
    for more in ([], ["--up", up]):
        place = tmp_path / str(len(more))
        wish = ["--size", "160x160", "--time", "1e-3", "--out", str(place), "--camera", camera, *more]
        assert main(["render", str(cube[0]), *wish]) == 0
        pictures += [path.read_bytes() for path in place.iterdir()]
    assert pictures[0] == pictures[1]
    for wrong, said in ((["0,0,1", "--up", "0,0,-2"], "--up = (0.0, 0.0, -2.0)"), (["0,0,0"], "--camera = (0.0")):
        assert main(["render", str(cube[0]), "--out", str(tmp_path / "none"), "--camera", *wrong]) == 2
        assert said in capsys.readouterr().err


@pytest.mark.parametrize(("away", "frame"), [(0.3, -1), (0.3, 0), (-0.3, 0)])
def test_a_picture_is_named_after_the_time_of_its_frame(away, frame, cube, tmp_path):
    """Not after the time that was asked for, to which no frame belongs."""
    out, _ = cube
    times = tc.open_result(out).frames.times
    time, asked = times[frame], times[frame] + away * np.diff(times).max()
    wish = ["--field", "von_mises", "--size", "160x160", "--out", str(tmp_path)]
    assert main(["render", str(out), "--time", str(asked), *wish]) == 0
    assert names(tmp_path) == {f"picture-von_mises-{time:g}s.png"}


def test_export_writes_a_series_beside_the_run_that_a_new_run_replaces(cube, tmp_path, capsys):
    out, _ = cube
    assert main(["export", str(out), "--fields", "displacement,von_mises", "--every", "2", "--out", str(tmp_path)]) == 0
    frames = len(ResultData.open(out / "result.vtkhdf"))
    assert f"{(frames + 1) // 2 + 1} files" in capsys.readouterr().out
    files = sorted(names(tmp_path))
    assert files == [*(f"frame-{i:04d}.vtu" for i in range((frames + 1) // 2)), "series.pvd"]
    grid = meshio.read(tmp_path / "frame-0001.vtu")
    frame = ResultData.open(out / "result.vtkhdf").frame(2)
    assert set(grid.point_data) == {"displacement"}
    np.testing.assert_array_equal(grid.point_data["displacement"], frame.point_data["displacement"])
    np.testing.assert_array_equal(grid.cell_data["von_mises"][0], frame.cell_data["von_mises"])
    assert str(frame.time) in (tmp_path / "series.pvd").read_text(encoding="utf-8")
    (tmp_path / "export").mkdir()
    for name in files:
        (tmp_path / name).rename(tmp_path / "export" / name)
    assert {path.parent.name for path in folder.our_files(tmp_path)} == {"export"}


def test_a_failed_check_ends_with_1_and_is_shown_even_when_quiet(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(bar_impact, "checks", lambda result: [at_most("impossible", 2.0, 1.0)])
    assert main(["run", "bar-impact", *SMALL, "--quiet", "--out", str(tmp_path)]) == 1
    assert "FAIL  impossible" in capsys.readouterr().out
    assert read(tmp_path / "summary.json")["passed"] is False


def test_a_diverging_run_ends_with_1_and_keeps_everything(tmp_path, capsys):
    arguments = ["run", "bar-impact", "--set", "cells=20", "--set", "cfl=1.5", "--frames", "3", "--out", str(tmp_path)]
    assert main(arguments) == 1
    text = capsys.readouterr().out
    data = read(tmp_path / "summary.json")
    assert data["reason"] in ("diverged", "inverted-cell")
    assert data["message"] in text
    assert names(tmp_path) >= NUMBERS


def test_comparison_runs_both_and_puts_them_side_by_side(tmp_path, capsys):
    out = tmp_path / "pair"
    arguments = ["run", "cube-impact", *SMALL, "--set", "compare=true", "--out", str(out)]
    assert main(arguments) == 0
    assert "side by side" in capsys.readouterr().out
    data = read(out / "summary.json")
    figures = data["figures"]
    calm, _, ordinary = (figures[label] for label in data["labels"])
    assert calm["force_changes"] < 2.0 < ordinary["force_changes"], "mass on the contact nodes chatters"
    assert calm["energy_error_max"] < ordinary["energy_error_max"]
    assert calm["nodal_variation"] < ordinary["nodal_variation"], "the command keeps the nodal pressures"
    assert calm["checkerboard"] < ordinary["checkerboard"]
    assert data["labels"] == ["massless", "massless + penalty", "ordinary mass + penalty"]
    for part in data["runs"]:
        assert names(out / part) == NUMBERS
    assert (out / "comparison.png").stat().st_size > 20000
    assert main(["info", str(out)]) == 0
    assert capsys.readouterr().out.count("finished at") == 3
    assert main(arguments) == 2
    assert main(["run", "bar-impact", *SMALL, "--quiet", "--force", "--out", str(out)]) == 0
    assert names(out) == NUMBERS, "the runs of the comparison were ours and are gone"


def test_ctrl_c_while_a_command_is_imported_ends_without_a_traceback(monkeypatch, capsys):
    def pressed(_name, _package):
        raise KeyboardInterrupt

    monkeypatch.setattr(cli, "import_module", pressed)
    assert main(["list"]) == 1
    assert capsys.readouterr().err == "tcontact: interrupted\n"


def test_an_interrupted_comparison_stops_there_and_keeps_what_it_has(tmp_path, monkeypatch, capsys):
    def interrupted(*arguments, **options):
        return dataclasses.replace(simulate(*arguments, **options), ok=False, reason="interrupted")

    simulate = tc.simulate
    monkeypatch.setattr(tc, "simulate", interrupted)
    assert main(["run", "cube-impact", *SMALL, "--set", "compare=true", "--out", str(tmp_path)]) == 1
    kept = {*NUMBERS, "checkpoint-a.npz"}  # from which `tcontact resume` goes on
    assert names(tmp_path) == {"summary.json"} | {f"massless/{name}" for name in kept}
    assert read(tmp_path / "summary.json")["passed"] is False
    assert set(folder.our_files(tmp_path)) == {path for path in tmp_path.rglob("*") if path.is_file()}


@pytest.mark.skipif(os.name != "posix", reason="needs POSIX signals")
def test_ctrl_c_keeps_everything_and_ends_with_1(tmp_path):
    out = tmp_path / "run"
    arguments = ["--set", "cells=4", "--set", "duration=1000", "--set", "cfl=0.01", "--frames", "2", "--out", out]
    command = [sys.executable, "-u", "-m", "tcontact", "run", "cube-impact", *arguments]
    process = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    try:
        while process.poll() is None and not first_frame(out / "result.vtkhdf"):
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(timeout=0.1)
        process.send_signal(signal.SIGINT)
        text, _ = process.communicate(timeout=60)
    finally:
        process.kill()
    assert process.returncode == 1, text
    assert read(out / "summary.json")["reason"] == "interrupted"
    assert names(out) >= NUMBERS


def first_frame(path: Path) -> bool:
    """Whether a running computation has stored its first frame."""
    try:
        return len(ResultData.open(path)) > 0
    except tc.InputError:
        return False


def test_doctor_says_that_no_kernels_can_be_kept(monkeypatch, tmp_path, capsys):
    """A file stands where the folder would be made."""
    (tmp_path / "file").touch()
    monkeypatch.setenv("TI_OFFLINE_CACHE_FILE_PATH", str(tmp_path / "file" / "kernels"))
    assert main(["doctor"]) == 0
    assert "kernels cannot be written, so that every run compiles its kernels anew: set" in capsys.readouterr().out
    assert main(["doctor", "--compile"]) == 2
    captured = capsys.readouterr()
    assert not captured.out
    assert "--compile = True: the kernel cache" in captured.err


def test_doctor_finds_this_machine_able(capsys):
    assert main(["doctor"]) == 0
    text = capsys.readouterr().out
    for word in (
        "tcontact",
        "taichi",
        "cores",
        "libX11",
        "kernel cache",
        "CUDA",
        "self test     passed",
        "energy error",
    ):
        assert word in text
