"""A disk that fills up amid a picture, a film or an export leaves the older one whole, and the remedy repairs all."""

import errno
import re
import shlex

import numpy as np
import pytest
from PIL import Image
from series import written
from test_cli import names
from test_faults import largest_file

import tcontact as tc
from tcontact.commands import folder
from tcontact.commands.cli import main
from tcontact.friction_layer import figures
from tcontact.results import report
from tcontact.results.exporting import export
from tcontact.results.files.vtkhdf import ResultData
from tcontact.show import plots
from tcontact.show.render import render_frames
from tcontact.show.render.animation import animate, can_film, common_palette, film, is_whole_film
from tcontact.show.render.png import save_picture, write_png

NOISE = np.random.default_rng(0).integers(0, 256, (4, 120, 160, 3), dtype=np.uint8)
TIME = np.linspace(0.0, 1.0, 40)


def filmed(path):
    """A film of noise."""
    with film(path, 10.0, (160, 120)) as add:
        for _ in range(10):
            for picture in NOISE:
                add(picture)


def curves(path):
    """Curves of energies."""
    plots.energy(path, dict.fromkeys(("time", "kinetic", "energy", "energy_error"), TIME))


WRITERS = {
    "a.png": lambda path: write_png(path, NOISE[0]),
    "b.png": lambda path: save_picture(Image.fromarray(NOISE[0]), path),
    "c.jpg": lambda path: save_picture(Image.fromarray(NOISE[0]), path),
    "d.gif": lambda path: animate(iter(NOISE), common_palette(NOISE, "viridis"), path, 10.0),
    "e.mp4": filmed,
    "f.png": curves,
    "g.svg": curves,
    "h.png": lambda path: figures.error_against_cost(path, [{"kind": "accuracy", "velocity": 1.0} | ROW]),
}
ROW = {"method": "m", "grading": 1.0, "points": 5, "dt": 1.0, "wall_s": 1.0, "cells": 1, "temperature_error": 1.0}


@pytest.mark.parametrize("name", WRITERS)
def test_a_picture_that_does_not_fit_leaves_the_older_one(name, tmp_path):
    if name.endswith("mp4") and not can_film():
        pytest.skip("needs imageio-ffmpeg")
    path = tmp_path / name
    with largest_file(2000), pytest.raises(OSError, match=r"File too large|no room for the whole film"):
        WRITERS[name](path)
    assert not list(tmp_path.iterdir()), "nothing half written is left"
    WRITERS[name](path)
    before = path.read_bytes()
    assert len(before) > 2000
    with largest_file(2000), pytest.raises(OSError, match=r"File too large|no room for the whole film"):
        WRITERS[name](path)
    assert path.read_bytes() == before
    assert [item.name for item in tmp_path.iterdir()] == [name]


@pytest.mark.skipif(not can_film(), reason="needs imageio-ffmpeg")
def test_a_film_that_was_cut_anywhere_is_not_whole(tmp_path):
    filmed(tmp_path / "film.mp4")
    whole = (tmp_path / "film.mp4").read_bytes()
    assert is_whole_film(tmp_path / "film.mp4")
    for end in (0, 5, 40, len(whole) // 2, len(whole) - 1):
        (tmp_path / "cut.mp4").write_bytes(whole[:end])
        assert not is_whole_film(tmp_path / "cut.mp4")
    assert not is_whole_film(tmp_path / "none.mp4")


def test_a_series_that_does_not_fit_leaves_the_older_animation(tmp_path):
    data = ResultData.open(written(tmp_path))
    render_frames(data, tmp_path / "out", "von_mises", size=(320, 240))
    before = {path: path.read_bytes() for path in (tmp_path / "out").rglob("*.*")}
    with largest_file(3000), pytest.raises(tc.InputError, match="make room"):
        render_frames(data, tmp_path / "out", "von_mises", size=(320, 240), colours="coolwarm")
    assert {path: path.read_bytes() for path in (tmp_path / "out").rglob("*.*")} == before


@pytest.mark.parametrize("format", ["vtu", "xdmf"])
def test_an_export_that_does_not_fit_says_so_plainly_and_leaves_the_older_one(format, tmp_path):
    data = ResultData.open(written(tmp_path))
    export(data, tmp_path / "out", format)
    before = {path: path.read_bytes() for path in (tmp_path / "out").iterdir()}
    with largest_file(1000), pytest.raises(tc.InputError) as caught:
        export(data, tmp_path / "out", format, fields=["displacement"])
    assert caught.value.remedy == "cannot be written (File too large); make room or name another folder"
    assert {path: path.read_bytes() for path in (tmp_path / "out").iterdir()} == before


def test_what_a_kill_leaves_half_written_is_ours(tmp_path):
    found = ("frames/.frame-0001.png.part", ".energy.png.part", ".animation.mp4.part", ".summary.json.part")
    for name in found:
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        path.write_text("")
    assert {path.relative_to(tmp_path).as_posix() for path in folder.our_files(tmp_path)} == set(found)


def full(*_, **__):
    """Find the disk full."""
    raise OSError(errno.ENOSPC, "No space left on device")


def refused(words, capsys):
    """Run a command that finds no room; return its message, and the commands that this names."""
    capsys.readouterr()
    assert main(words) == 1
    text = capsys.readouterr().err
    return text, [shlex.split(one)[1:] for one in re.findall(r"`(tcontact [^`]*)`", text)]


@pytest.mark.parametrize("options", [("--checkpoint", "0"), ("--checkpoint", "0", "--frames", "0"), ()], ids=str)
@pytest.mark.parametrize("case", [("bar-impact", "--set", "cells=4"), ("sliding-block", "--fields", "displacement")])
def test_the_commands_that_the_message_names_repair_all(case, options, tmp_path, monkeypatch, capsys):
    words = ["run", *case, "--frames", "2", *options, "--quiet", "--out"]
    main([*words, str(tmp_path / "straight")])
    with monkeypatch.context() as patch:
        patch.setattr(plots, "_save", full)
        _, remedies = refused([*words, str(tmp_path / "full")], capsys)
    assert remedies
    for remedy in remedies:
        assert main(remedy) in (0, 1)
    assert names(tmp_path / "full") == names(tmp_path / "straight")
    for name in names(tmp_path / "full"):
        if name.endswith(".png"):
            with Image.open(tmp_path / "full" / name) as picture:
                picture.load()


def test_a_run_whose_checks_were_not_written_has_to_be_run_again(tmp_path, monkeypatch, capsys):
    words = ["run", "bar-impact", "--set", "cells=4", "--frames", "0", "--checkpoint", "0", "--quiet"]
    with monkeypatch.context() as patch:
        patch.setattr(report, "write_json", full)
        text, remedies = refused([*words, "--out", str(tmp_path)], capsys)
    assert "run again with --force: its checks are not written" in text
    assert not remedies
    assert (tmp_path / "result.vtkhdf").exists()


def test_a_comparison_that_finds_no_room_is_drawn_when_there_is_some(tmp_path, monkeypatch, capsys):
    words = ["run", "two-bars", "--set", "compare=true", "--set", "cells=4", "--frames", "0", "--quiet", "--out"]
    with monkeypatch.context() as patch:
        patch.setattr("tcontact.commands.curves.draw_comparison", full)
        _, remedies = refused([*words, str(tmp_path)], capsys)
    for remedy in remedies:
        assert main(remedy) == 0
    assert (tmp_path / "comparison.png").exists()
    again = [words[0], *words[1:], str(tmp_path / "again"), "--checkpoint", "0"]
    with monkeypatch.context() as patch:
        patch.setattr(plots, "_save", full)
        text, remedies = refused(again, capsys)
    assert "the comparison has to be run again, with --force" in text
