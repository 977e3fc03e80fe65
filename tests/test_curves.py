"""Curves are drawn again at any time; a run that was killed while its pictures were drawn gets them from `resume`."""

import json
import shutil

import numpy as np
import pytest
from scenes import python
from stopped_runs import SCENES, quietly, same_files

import tcontact as tc
from tcontact.commands import curves
from tcontact.commands.cli import main
from tcontact.run.checkpoint import store
from tcontact.show import plots, render

CURVES = ["contact-force.png", "energy.png", "gap.png"]
SMALL_CUBE = ["--set", "cells=2", "--set", "cfl=0.5", "--frames", "2", "--quiet"]


@pytest.fixture
def drawn(monkeypatch):
    """What was drawn, by the name of its file: arguments of `plots`; files are left as marks."""
    found = {}

    def keep(path, *arguments, **options):
        found[path.name] = arguments
        path.write_text(path.name)

    for name in ("contact_force", "gap", "energy", "comparison", "panels"):
        monkeypatch.setattr(plots, name, keep)
    monkeypatch.setattr(render, "render_frames", lambda *_, **__: [])
    return found


def alike(one, other):
    """Whether two lists of arguments are the same."""
    assert len(one) == len(other)
    for mine, theirs in zip(one, other, strict=True):
        if isinstance(mine, dict):
            assert mine.keys() == theirs.keys()
            for key in mine:
                assert np.array_equal(np.asarray(mine[key]), np.asarray(theirs[key]), equal_nan=True), key
        elif isinstance(mine, list):
            assert np.array_equal(mine, theirs)
        else:
            assert mine == theirs


@pytest.mark.parametrize("case", ["cube-impact", "sliding-block"])
def test_curves_of_a_case_are_drawn_again_as_they_were(case, drawn, tmp_path):
    """With the exact solution and the case's own figures: the scene is made again from the summary."""
    quick = {"cube-impact": ["--set", "cells=2"], "sliding-block": ["--set", "cells=2", "--set", "duration=1e-3"]}
    main(["run", case, *quick[case], "--frames", "0", "--quiet", "--out", str(tmp_path / "run")])
    first = dict(drawn)
    assert set(CURVES) <= set(first)
    assert first["contact-force.png"][2]  # what the case knows
    for name in first:
        (tmp_path / "run" / name).unlink()
    drawn.clear()
    assert main(["render", str(tmp_path / "run"), "--plots"]) == 0
    assert drawn.keys() == first.keys()
    for name, arguments in first.items():
        if name in CURVES:
            alike(drawn[name], arguments)
        assert (tmp_path / "run" / name).exists()


def test_curves_of_a_scene_file_and_of_a_program(drawn, tmp_path, monkeypatch, capsys):
    physics = SCENES["full removal"]()
    tc.save_scene(physics, tmp_path / "drop.toml")
    assert main(["run", str(tmp_path / "drop.toml"), "--frames", "0", "--quiet", "--out", str(tmp_path / "file")]) == 0
    first = dict(drawn)
    result = tc.simulate(physics, out=tmp_path / "program")
    for place, caption in (("file", "drop"), ("program", "program")):
        drawn.clear()
        (tmp_path / "drop.toml").unlink(missing_ok=True) if place == "program" else None
        assert main(["render", str(tmp_path / place), "--plots", "--out", str(tmp_path / f"new-{place}")]) == 0
        assert sorted(path.name for path in (tmp_path / f"new-{place}").iterdir()) == CURVES
        assert drawn["energy.png"][1] == caption
        alike([*drawn["contact-force.png"][:2]], [*first["contact-force.png"][:2]])
    assert np.array_equal(drawn["gap.png"][0]["gap_min"], result.history["gap_min"])
    alone = shutil.copy(tmp_path / "program/result.vtkhdf", tmp_path / "alone.vtkhdf")
    assert main(["render", str(alone), "--plots", "--out", str(tmp_path / "third")]) == 0
    assert sorted(path.name for path in (tmp_path / "third").iterdir()) == CURVES


def test_curves_of_a_comparison(drawn, tmp_path):
    main(["run", "cube-impact", "--set", "compare=true", *SMALL_CUBE, "--out", str(tmp_path / "run")])
    first = drawn["comparison.png"]
    for path in tmp_path.rglob("*.png"):
        path.unlink()
    drawn.clear()
    assert main(["render", str(tmp_path / "run"), "--plots"]) == 0
    assert len(list(tmp_path.rglob("*.png"))) == 3 * len(CURVES) + 1
    assert drawn["comparison.png"][0].keys() == first[0].keys()
    for label, history in first[0].items():
        alike([drawn["comparison.png"][0][label]], [history])


def test_there_are_no_curves_without_a_history(drawn, tmp_path, capsys):
    assert main(["render", str(tmp_path / "absent"), "--plots"]) == 2
    (tmp_path / "empty").mkdir()
    assert main(["render", str(tmp_path / "empty"), "--plots"]) == 2
    from series import written

    from tcontact.results.files.vtkhdf import ResultFile
    from tcontact.run.checkpoint import store

    path = written(tmp_path)
    ResultFile.reopen(path, 1).close()
    assert main(["render", str(path), "--plots"]) == 2
    store.write(path.parent, {"row": 3, "frames": 0}, {}, {})
    assert main(["render", str(path), "--plots"]) == 2
    said = capsys.readouterr().err.splitlines()
    assert len(said) == 4
    assert "has to be run again" in said[2], "there is nothing to go on from"
    assert f"tcontact resume {path.parent}" in said[3]


KILLED = """
import os, sys
from tcontact.planning.body_plan import SMALL
SMALL.update(dict.fromkeys(SMALL, 0))
from tcontact.commands.cli import main
from tcontact.show import plots
plots.gap = lambda *arguments: os.kill(os.getpid(), 9)
main(["run", "cube-impact", "--set", "cells=2", "--set", "cfl=0.5", "--frames", "2", "--quiet", "--out", sys.argv[1]])
"""


def test_a_kill_while_pictures_are_drawn_is_made_good_by_resume(tmp_path, monkeypatch, capsys):
    main(["run", "cube-impact", *SMALL_CUBE, "--out", str(tmp_path / "straight")])
    done = python(KILLED, tmp_path / "killed")
    assert done.returncode == -9, done.stderr
    assert (tmp_path / "killed/contact-force.png").exists()
    assert not (tmp_path / "killed/energy.png").exists()
    assert main(["info", str(tmp_path / "killed")]) == 0
    main(["resume", str(tmp_path / "killed"), "--quiet"])
    same_files(tmp_path / "killed", tmp_path / "straight")  # names of the files too
    mine, theirs = (json.loads((tmp_path / name / "summary.json").read_text()) for name in ("killed", "straight"))
    for name in ("checks", "case", "parameters", "last_row", "smoothness", "origin", "steps"):
        assert mine[name] == theirs[name], name
    capsys.readouterr()
    assert main(["resume", str(tmp_path / "killed")]) == 2
    said = capsys.readouterr().err
    assert "has ended" in said
    assert "--plots" in said


def test_checkpoints_that_are_to_be_kept_stay_at_the_end(tmp_path):
    physics, place = SCENES["full removal"](), tmp_path / "run"
    fine = tc.CentralDifference(cfl=0.3)
    options = tc.Checkpoint(every_seconds=3600.0, keep=True)
    whole = quietly(tc.simulate, physics, fine, out=place, frames=3, checkpoint=options)
    assert [stored.row for stored in store.read_all(place)[0]] == [whole.steps]
    again = quietly(tc.resume, place, physics, fine)
    np.testing.assert_array_equal(again.position, whole.position)
    assert len(store.read_all(place)[0]) > 0
    with pytest.raises(tc.InputError, match="keep"):
        tc.Checkpoint(every_steps=1, keep="yes")


def test_the_caption_leaves_the_comparison_out():
    assert curves.caption_of("cube", ["cells=4", "compare=true"]) == "cube, cells=4"


DRAWN = """
import hashlib, pathlib, sys
import numpy as np
if sys.argv[2] == "quick":
    from tcontact.commands.quick_import import load_matplotlib
    load_matplotlib()
from matplotlib.artist import Artist, kwdoc
from matplotlib.lines import Line2D
from tcontact.show import plots
time = np.linspace(0.0, 1.0, 9)
plots.panels(pathlib.Path(sys.argv[1]), {("path", "m"): {"computed": (time, time), "exact": (time, time**2)}})
line = Line2D([0], [0])
line.set(color="red", linewidth=3.0)
print(line.get_color(), line.get_linewidth(), "figure" in kwdoc(Artist), "linestyle" in str(Line2D.set.__doc__))
"""


def test_curves_of_a_command_need_no_docstrings_of_matplotlib(tmp_path):
    """They look the same, artists do what they do else, and what writes docstrings is there again afterwards."""
    plain, quick = (python(DRAWN, tmp_path / f"{name}.png", name) for name in ("plain", "quick"))
    assert plain.stdout == "red 3.0 True True\n", plain.stderr
    assert quick.stdout == "red 3.0 True False\n", quick.stderr
    assert (tmp_path / "quick.png").read_bytes() == (tmp_path / "plain.png").read_bytes()
