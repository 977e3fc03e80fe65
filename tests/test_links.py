"""Symbolic links in the folder of a run: nothing behind one is removed, replaced or written to."""

import os
import shutil

import numpy as np
import pytest
from series import written
from stopped_runs import SCENES, copied, same

import tcontact as tc
from tcontact.commands import folder
from tcontact.commands.cli import main
from tcontact.device.atomic_file import part_of, undo_path
from tcontact.results.exporting import export
from tcontact.results.files.vtkhdf import ResultData
from tcontact.run.folder_lock import NAME, check_free, locked
from tcontact.show import plots, render

FINE = tc.CentralDifference(cfl=0.3)


@pytest.fixture
def precious(tmp_path):
    """A file elsewhere, to be left alone."""
    path = tmp_path / "elsewhere" / "precious.txt"
    path.parent.mkdir()
    path.write_text("precious\n")
    return path


def unharmed(path):
    """Whether it is as it was."""
    return path.read_text() == "precious\n" and len(list(path.parent.iterdir())) == 1


@pytest.mark.parametrize("hard", ["link", "dangling", "folder"])
def test_a_lock_that_is_a_link_is_refused_and_stays(hard, precious, tmp_path):
    place = tmp_path / "run"
    place.mkdir()
    target = {"link": precious, "dangling": tmp_path / "absent", "folder": precious.parent}[hard]
    (place / NAME).symlink_to(target)
    for call in (
        lambda: check_free(place),
        lambda: tc.simulate(SCENES["full removal"](), FINE, out=place),
        lambda: locked(place).__enter__(),
        lambda: tc.resume(place, SCENES["full removal"](), FINE),
    ):
        with pytest.raises(tc.InputError, match="no ordinary file"):
            call()
    assert main(["run", "cube-impact", "--out", str(place), "--force"]) == 2
    assert unharmed(precious)
    assert (place / NAME).is_symlink()
    assert not (tmp_path / "absent").exists()


def test_links_at_the_places_of_files_that_a_run_writes_are_replaced(precious, tmp_path):
    place = tmp_path / "run"
    place.mkdir()
    names = ["history.csv", "summary.json", "checkpoint-a.npz", "checkpoint-b.npz"]
    links = [place / name for name in names]
    links += [part_of(link) for link in links] + [undo_path(place / "result.vtkhdf")]
    for link in links:
        link.symlink_to(precious)
    result = tc.simulate(SCENES["full removal"](), FINE, out=place, frames=3, checkpoint={"every_steps": 10})
    assert result.ok
    assert unharmed(precious)
    assert not any(path.is_symlink() for path in place.iterdir())
    assert sorted(path.name for path in place.iterdir()) == ["history.csv", "result.vtkhdf", "summary.json"]


@pytest.mark.parametrize("dangling", [True, False])
def test_a_result_file_that_is_a_link_is_not_written_through(dangling, precious, tmp_path):
    place = tmp_path / "run"
    place.mkdir()
    (place / "result.vtkhdf").symlink_to(tmp_path / "absent" if dangling else precious)
    with pytest.raises(tc.InputError, match="already holds"):
        tc.simulate(SCENES["full removal"](), FINE, out=place)
    assert unharmed(precious)
    assert not (tmp_path / "absent").exists()


def test_a_run_whose_result_file_became_a_link_is_not_gone_on_with(monkeypatch, tmp_path):
    physics = SCENES["full removal"]()
    whole, copies = copied(monkeypatch, tmp_path, physics, FINE, 15, frames=4)
    place = copies[min(copies)]
    (place / "result.vtkhdf").rename(tmp_path / "moved.vtkhdf")
    (place / "result.vtkhdf").symlink_to(tmp_path / "moved.vtkhdf")
    before = (tmp_path / "moved.vtkhdf").read_bytes()
    assert len(ResultData.open(place / "result.vtkhdf")) > 0  # reading follows
    with pytest.raises(tc.InputError, match="symbolic link"):
        tc.resume(place, physics, FINE)
    assert (tmp_path / "moved.vtkhdf").read_bytes() == before
    (place / "result.vtkhdf").unlink()
    shutil.move(tmp_path / "moved.vtkhdf", place / "result.vtkhdf")
    linked = tmp_path / "linked"
    linked.symlink_to(place)  # the folder itself may be given as a link
    same(tc.resume(linked, physics, FINE), whole)


def test_force_takes_links_away_and_not_what_is_behind_them(precious, tmp_path):
    place = tmp_path / "run"
    (place / "export").mkdir(parents=True)
    kept = precious.parent / "frame-0000.png"
    precious.rename(kept)
    for name in ("summary.json", "energy.png", "export/series.pvd"):
        (place / name).symlink_to(kept)
    (place / "frames").symlink_to(kept.parent)
    assert kept.name in [path.name for path in (place / "frames").iterdir()]
    assert sorted(path.name for path in folder.our_files(place)) == ["energy.png", "series.pvd", "summary.json"]
    with folder.replacing(place, force=True):
        assert not folder.our_files(place)
        (place / "summary.json").write_text("{}")
    assert kept.read_text() == "precious\n"
    assert (place / "frames").is_symlink()
    assert not (place / "energy.png").is_symlink()
    (place / ".replaced").symlink_to(kept.parent)
    with pytest.raises(tc.InputError, match="symbolic link"), folder.replacing(place, force=True):
        pass
    assert [path.name for path in kept.parent.iterdir()] == [kept.name]


def test_pictures_curves_and_exports_replace_links(precious, tmp_path):
    path = written(tmp_path)
    out = tmp_path / "out"
    (out / "frames").mkdir(parents=True)
    names = ["frames/frame-0000.png", "animation.gif", "contact-face.png", "energy.png"]
    names += ["frame-0001.vtu", "series.pvd", "series.h5", "series.xdmf", "one.png"]
    for name in names:
        (out / name).symlink_to(precious)
    render.render_frames(path, out, "von_mises", size=(160, 160))
    render.render_picture(path, out / "one.png", size=(160, 160))
    for kind in ("vtu", "xdmf"):
        export(path, out, kind)
    time = np.linspace(0.0, 1.0, 5)
    plots.energy(out / "energy.png", dict.fromkeys(("time", "kinetic", "energy", "energy_error"), time))
    assert unharmed(precious)
    assert [name for name in names if (out / name).is_symlink()] in ([], ["contact-face.png"])  # drawn if it touches


def test_folders_of_pictures_and_exports_that_are_links_are_refused(precious, tmp_path, capsys):
    path = written(tmp_path)
    for name in ("frames", "export"):
        (tmp_path / name).symlink_to(precious.parent)
    assert main(["render", str(path), "--size", "160x160"]) == 2
    assert main(["export", str(path)]) == 2
    assert capsys.readouterr().err.count("symbolic link") == 2
    assert unharmed(precious)
    assert main(["export", str(path), "--out", str(tmp_path / "export")]) == 0  # given by name, it is meant


@pytest.mark.parametrize("below", ["", "deeper/down"])
def test_a_folder_behind_a_link_to_nothing_is_refused_with_what_is_wrong(below, tmp_path, capsys):
    path, link = written(tmp_path), tmp_path / "link"
    link.symlink_to(tmp_path / "absent")
    out = link / below
    for call in (
        lambda: tc.simulate(SCENES["full removal"](), FINE, out=out),
        lambda: render.render_frames(path, out, size=(160, 160)),
        lambda: render.render_picture(path, out / "one.png", size=(160, 160)),
        lambda: export(path, out),
    ):
        with pytest.raises(tc.InputError, match="is a symbolic link that leads nowhere; make what it leads to"):
            call()
    for words in (["run", "cube-impact"], ["render", str(path)], ["export", str(path)], ["study", "bar-impact"]):
        assert main([*words, "--out", str(out)]) == 2
        assert "is a symbolic link that leads nowhere" in capsys.readouterr().err
    assert main(["report", str(tmp_path), "--out", str(out / "page.html")]) == 2
    assert "is a symbolic link that leads nowhere" in capsys.readouterr().err
    assert link.is_symlink()
    assert not (tmp_path / "absent").exists()


def test_a_link_that_turns_up_while_a_file_is_written_stays_where_it_is(precious, tmp_path):
    """`replaced` renames over the link."""
    from tcontact.results.report import write_json

    path = tmp_path / "summary.json"
    path.symlink_to(precious)
    write_json(path, {"a": 1})
    assert not path.is_symlink()
    assert unharmed(precious)
    assert os.path.getsize(path) > 0
