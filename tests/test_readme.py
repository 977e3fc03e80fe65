"""The README: its Python example runs as written, its test command is the one CI runs, its pictures exist."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

import tcontact as tc
from tcontact import cases
from tcontact.commands import cli, settings
from tcontact.lab.study import hard_register, methods, problems

ROOT = Path(__file__).resolve().parents[1]
PAGES = {page: page.read_text(encoding="utf-8") for page in (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")))}
TEXT = "\n".join(PAGES.values())


def blocks(language, page=None):
    """The code of a language, in all pages or in one of docs/."""
    text = TEXT if page is None else PAGES[ROOT / "docs" / page]
    return re.findall(rf"```{language}\n(.*?)```", text, flags=re.DOTALL)


def test_the_python_example_runs_as_written():
    code, _ = blocks("python")
    assert len(code.splitlines()) <= 16
    smaller = code.replace("(16, 16, 16)", "(4, 4, 4)")
    assert smaller != code
    done = subprocess.run([sys.executable, "-c", smaller], cwd=ROOT, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr[-2000:]
    assert "Result(finished" in done.stdout


def test_the_page_on_results_runs_as_written(tmp_path, monkeypatch):
    for package in ("pandas", "pyvista"):
        pytest.importorskip(package, reason=f"{package} is not installed")
    _, code = blocks("python")
    monkeypatch.chdir(tmp_path)
    cli.main(["run", "cube-impact", "--set", "cells=2", "--frames", "4", "--quiet"])
    names = {}
    exec(code, names)
    assert names["result"].reason == "finished"
    assert names["grid"].n_cells == 8
    assert len(names["table"]) == len(names["result"].history["time"])
    assert (tmp_path / "end.png").exists()


def test_the_scenes_of_the_page_on_scenes_are_scenes():
    """Its parts run one after the other; each scene, and each body alone, has a plan."""
    parts, names = blocks("py", "SCENES.md"), {}
    assert len(parts) == 8
    for part in parts:
        exec(part, names)
        if "scene" in names:
            assert tc.plan(names["scene"]).terms
    bodies = [value for value in names.values() if isinstance(value, tc.Body)]
    assert len(bodies) == 6
    for body in bodies:
        assert tc.plan(tc.Scene([body], [tc.Plane(point=(0, 0, -1))], duration=1e-3)).terms


def test_the_scene_of_the_first_run_is_a_scene():
    (code,) = blocks("py", "first-run.md")
    names = {}
    exec(code, names)
    assert "massless-contact" in tc.plan(names["scene"]).terms


def test_ci_runs_the_test_command_of_the_readme():
    """The words after the environment is set up are the same."""
    command = blocks("sh")[1].strip().split("&&")[-1].strip()
    assert command.removeprefix(".venv/bin/") in (ROOT / ".ci" / "run").read_text(encoding="utf-8")


def test_every_picture_and_link_exists():
    linked = set()
    for page, text in PAGES.items():
        for path in re.findall(r"\]\(([^)#]+)\)", text):
            assert path.startswith("http") or (page.parent / path).is_file(), (page.name, path)
            linked.add((page.parent / path).resolve())
    site = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    for path in (ROOT / "docs").iterdir():
        assert path.stat().st_size < 200_000, path
        assert path.is_dir() or path.resolve() in linked or path.name in site, path


def test_the_readme_fits_on_three_screens():
    """Some fifty lines a screen; what is longer belongs into docs/."""
    assert len(PAGES[ROOT / "README.md"].splitlines()) <= 170


def test_every_run_of_the_readme_is_one():
    """Cases and parameters of each `tcontact run` exist and take the values given; further words are parameters too."""
    found = re.findall(r"`tcontact (run [a-z][^`]*)`", TEXT)
    assert len(found) >= 8
    for line in found:
        words = cli.parser().parse_args(line.split())
        if words.case.endswith(".toml"):
            continue  # test_scene_file runs the one that stands in the README
        case = cases.load(words.case)
        wanted = settings.read(words.case, case, words.set)
        if not hasattr(case, "scene"):
            continue
        assert case.scene(**wanted.scene)
        settings.scheme(wanted.scheme)
    (more,) = re.findall(r"`--set (contact=[^`]*)`", TEXT)
    keys = {word.partition("=")[0] for word in more.split()}
    assert keys <= {"compare", *settings.SCHEME_KEYS, *cases.parameters("cube-impact")}


def test_every_command_of_the_readme_is_known():
    known = subprocess.run(
        [sys.executable, "-m", "tcontact", "--help"], cwd=ROOT, capture_output=True, text=True
    ).stdout
    for verb in re.findall(r"`tcontact (\w+)", TEXT):
        assert verb in known, verb


def test_every_study_of_the_readme_is_one():
    """Cases and methods of each `tcontact study` exist, and so do the hard cases of the table."""
    for line in re.findall(r"`tcontact (study [a-z][^`]*)`", TEXT):
        words = cli.parser().parse_args(line.split())
        assert words.case in (*problems.names(), "hard-cases", "friction-layer")
        for name in words.methods or ():
            methods.method(name)
    known = hard_register.register()
    (table,) = blocks("text", "NUMBERS.md")
    rows = [row.split() for row in table.splitlines()[1:]]
    assert len(rows) > 10
    assert all(row[0] in known and row[1] in known[row[0]].expected for row in rows)
