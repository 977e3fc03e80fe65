"""Devices, pipes and sockets in place of files that are written: refused before anything is computed, and they stay."""

import os
import stat

import pytest
from series import written
from stopped_runs import SCENES

import tcontact as tc
from tcontact.commands.cli import main
from tcontact.device import atomic_file
from tcontact.device.atomic_file import AtomicFile, replaced
from tcontact.results.exporting import export
from tcontact.results.report import write_json
from tcontact.show.page import document

pytestmark = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="the system has no pipes")


def device(path):
    """Make a device like /dev/null, which takes a right that not every user has."""
    try:
        os.mknod(path, stat.S_IFCHR | 0o600, os.makedev(1, 3))
    except OSError:
        pytest.skip("no devices can be made here")


def linked(path):
    """Make a link to a pipe, as /dev/stdout may be."""
    os.mkfifo(path.with_name("pipe"))
    path.symlink_to("pipe")


def through_two(path):
    """Make a link to a link to a pipe."""
    linked(path.with_name("between"))
    path.symlink_to("between")


MADE = {"pipe": os.mkfifo, "link": linked, "links": through_two, "device": device}


@pytest.mark.parametrize("made", MADE)
def test_what_is_no_ordinary_file_is_refused_and_stays(made, tmp_path):
    path = tmp_path / "page.html"
    MADE[made](path)
    before = path.lstat()
    result = written(tmp_path)
    calls = (
        lambda: write_json(path, {"a": 1}),
        lambda: AtomicFile(path, "w"),
        lambda: document.write_page([result], path),
    )
    for call in calls:
        with pytest.raises(tc.InputError, match=r"is no ordinary file; name another"):
            call()
    assert main(["report", str(result), "--out", str(path)]) == 2
    assert (path.lstat().st_ino, path.lstat().st_mode) == (before.st_ino, before.st_mode)
    assert not stat.S_ISREG(path.stat().st_mode)
    assert {file.name for file in tmp_path.iterdir()} <= {"page.html", "result.vtkhdf", "pipe", "between"}


def test_it_is_refused_before_anything_is_drawn(monkeypatch, tmp_path):
    from tcontact.show.render import render_frames, render_picture
    from tcontact.show.render.studio import Studio

    monkeypatch.setattr(Studio, "__init__", lambda *given: pytest.fail("it draws"))
    monkeypatch.setattr("tcontact.show.page.document.open_result", lambda run: pytest.fail("it reads"))
    result = written(tmp_path)
    for name in ("animation.gif", "one.png", "page.html", "series.pvd", "series.h5"):
        os.mkfifo(tmp_path / name)
    before = sorted(tmp_path.iterdir())
    for call in (
        lambda: render_frames(result, tmp_path),
        lambda: render_picture(result, tmp_path / "one.png"),
        lambda: document.write_page([result], tmp_path / "page.html"),
        lambda: export(result, tmp_path),
        lambda: export(result, tmp_path, "xdmf"),
    ):
        with pytest.raises(tc.InputError, match="no ordinary file"):
            call()
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.parametrize("name", ["summary.json", "history.csv", "checkpoint-b.npz"])
def test_a_run_beside_a_pipe_is_refused_at_once(name, tmp_path, capsys):
    os.mkfifo(tmp_path / name)
    with pytest.raises(tc.InputError, match="no ordinary file"):
        tc.simulate(SCENES["full removal"](), out=tmp_path)
    for force in ([], ["--force"]):
        assert main(["run", "cube-impact", "--set", "cells=2", "--out", str(tmp_path), *force]) == 2
        assert "no ordinary file" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == [name]


def test_the_bench_looks_at_its_files_first(tmp_path, capsys):
    os.mkfifo(tmp_path / "bench.json")
    assert main(["bench", "--quick", "--out", str(tmp_path)]) == 2
    assert "no ordinary file" in capsys.readouterr().err


def test_nothing_is_replaced_in_the_folder_of_devices(monkeypatch, tmp_path):
    """A link there may lead to an ordinary file: the standard output of a program that writes into one."""
    monkeypatch.setattr(atomic_file, "DEVICES", tmp_path)
    (tmp_path / "file").write_text("kept\n")
    (tmp_path / "stdout").symlink_to("file")
    for name in ("stdout", "new"):
        with pytest.raises(tc.InputError, match="no ordinary file"), replaced(tmp_path / name) as part:
            part.write_text("new\n")
    assert (tmp_path / "stdout").is_symlink()
    assert (tmp_path / "file").read_text() == "kept\n"


def test_ordinary_files_and_links_that_lead_nowhere_are_replaced(tmp_path):
    (tmp_path / "file").write_text("old\n")
    (tmp_path / "link").symlink_to("absent")
    (tmp_path / "circle").symlink_to("circle")
    for name in ("file", "link", "circle", "new"):
        write_json(tmp_path / name, {})
        assert (tmp_path / name).read_text() == "{}\n"
        assert not (tmp_path / name).is_symlink()
