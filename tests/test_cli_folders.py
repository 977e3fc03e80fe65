"""The folder of a run: nothing is lost, nothing of others is touched."""

from __future__ import annotations

import json
import re

import pytest
from test_cli import NUMBERS, ROOT, SMALL, names, read

from tcontact.commands import folder
from tcontact.commands.cli import main


def test_another_run_is_never_overwritten_without_force(tmp_path, capsys):
    out = tmp_path / "run"
    assert main(["run", "bar-impact", *SMALL, "--quiet", "--out", str(out)]) == 0
    assert capsys.readouterr().out == ""
    assert names(out) == NUMBERS
    before = {path: path.read_bytes() for path in out.iterdir()}
    foreign = out / "notes.txt"
    foreign.write_text("mine", encoding="utf-8")
    assert main(["run", "bar-impact", *SMALL, "--out", str(out)]) == 2
    assert "--force" in capsys.readouterr().err
    assert {path: path.read_bytes() for path in before} == before

    thin = ["--set", "cells=1", "--set", "pitch=45", "--frames", "0"]
    wrong = ["run", "cube-impact", *thin, "--force", "--out", str(out)]
    assert main(wrong) == 2, "one cell cannot lose the mass of two faces: found when the run is planned"
    assert {path: path.read_bytes() for path in before} == before, "bad input must not cost the older run"

    late = ["run", "bar-impact", *SMALL, "--set", "cfl=1e-12", "--force", "--out", str(out)]
    assert main(late) == 2, "too many steps: found when the stable step is known"
    assert {path: path.read_bytes() for path in before} == before

    for words in (wrong[1:-3], late[1:-3]):
        assert main(["run", *words, "--out", str(tmp_path / "new" / "run")]) == 2
        assert not (tmp_path / "new").exists(), "a refused run leaves no folder"

    assert main(["run", "bar-impact", "--set", "cells=5", "--frames", "0", "--force", "--out", str(out)]) == 0
    assert read(out / "summary.json")["parameters"]["cells"] == 5
    assert foreign.read_text(encoding="utf-8") == "mine"
    assert names(out) == NUMBERS | {"notes.txt"}


def test_a_run_that_was_put_aside_by_a_killed_one_is_named_and_put_back(tmp_path, capsys):
    """What a run with --force leaves that is killed while it compiles."""
    assert main(["run", "bar-impact", *SMALL, "--quiet", "--out", str(tmp_path)]) == 0
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    aside = tmp_path / ".replaced"
    aside.mkdir()
    for path in before:
        path.rename(aside / path.name)
    for words in (["info"], ["resume"], ["export"], ["render"]):
        assert main([*words, str(tmp_path)]) == 2
        assert "move the files in .replaced back" in capsys.readouterr().err
    assert main(["run", "bar-impact", *SMALL, "--out", str(tmp_path)]) == 2
    assert "--force" in capsys.readouterr().err
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before


@pytest.mark.parametrize("command", ["render", "export"])
def test_of_a_comparison_the_runs_are_named(command, tmp_path, capsys):
    """Pictures and exports are of one run; the folder of several says which there are."""
    (tmp_path / "summary.json").write_text(json.dumps({"case": "two", "runs": ["massless", "penalty"]}))
    assert main([command, str(tmp_path)]) == 2
    said = capsys.readouterr().err
    assert f"name one of its runs: {tmp_path / 'massless'}, {tmp_path / 'penalty'}" in said


def test_default_folder_is_named_after_the_case(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["run", "bar-impact", *SMALL, "--quiet"]) == 0
    assert names(tmp_path / "runs" / "bar-impact") == NUMBERS


def test_out_may_not_be_a_file(tmp_path, capsys):
    (tmp_path / "taken").write_text("mine", encoding="utf-8")
    assert main(["run", "bar-impact", *SMALL, "--out", str(tmp_path / "taken")]) == 2
    assert "is a file" in capsys.readouterr().err


def test_every_file_that_a_case_draws_is_ours(tmp_path):
    """Else `--force` would leave the picture of an older run beside the new ones."""
    drawn = set()
    for path in [*(ROOT / "cases").glob("*.py"), *(ROOT / "tcontact" / "commands").glob("*.py")]:
        drawn |= set(re.findall(r'\b(?:folder|out) / "([\w-]+\.(?:png|csv|json))"', path.read_text(encoding="utf-8")))
    assert {"motion.png", "sliding.png", "tractions.png", "profile.csv", "energy.png", "study.csv"} <= drawn
    again = ("bench.json", "bench.csv", "bench.png", "ranks.json", "solvers.json", "pairs.json")
    drawn -= {*again, "alternatives.json", "alternatives.csv"}  # a bench is repeated in place
    for name in drawn:
        (tmp_path / name).write_text("")
    assert {path.name for path in folder.our_files(tmp_path)} == drawn


def test_files_that_are_not_ours_are_never_counted(tmp_path):
    for name in ("summary.json.bak", "photo.png", "frames/mine.png", "other/summary.json"):
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        path.write_text("{}", encoding="utf-8")
    assert folder.our_files(tmp_path) == []
    (tmp_path / "summary.json").write_text('{"runs": ["../other", "/", "..", 5]}', encoding="utf-8")
    assert folder.our_files(tmp_path) == [tmp_path / "summary.json"]
