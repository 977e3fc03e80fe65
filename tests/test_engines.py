"""The compiler of the kernels: one module imports it, and a fork of Taichi can take its place."""

from __future__ import annotations

import ast
import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tcontact.commands import engines

ROOT = Path(__file__).resolve().parent.parent


def imported(path: Path) -> set[str]:
    """Top-level packages that a file imports by name."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            found.add((node.module or "").partition(".")[0])
    return found


def test_one_module_imports_the_compiler():
    files = [path for place in ("tcontact", "kernels", "cases") for path in (ROOT / place).rglob("*.py")]
    assert [path.name for path in files if imported(path) & set(engines.ENGINES)] == []
    assert "taichi" in (ROOT / "kernels" / "engine.py").read_text(encoding="utf-8")


def test_a_compiler_that_is_missing_is_named():
    environment = os.environ | {"TCONTACT_ENGINE": "no_such_compiler"}
    program = "from tcontact.device import runtime; runtime.load()"
    done = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True)
    assert done.returncode == 1
    assert "TCONTACT_ENGINE=no_such_compiler" in done.stderr
    found = engines.digests("no_such_compiler", ["bar-impact"])
    assert found["runs"] == {}
    assert "no_such_compiler" in found["errors"]["all"]


def compare(names: tuple[str, ...]) -> None:
    """The histories of Taichi and of its fork have the same bits."""
    expected, found = (engines.digests(engine, names) for engine in engines.ENGINES)
    assert set(expected["runs"]) == set(names), expected["errors"]
    assert found["errors"] == {}
    assert found["runs"] == expected["runs"]


@pytest.mark.skipif(importlib.util.find_spec("quadrants") is None, reason="pip install quadrants")
@pytest.mark.xfail(reason="the fork may change; Taichi is the compiler that is supported", strict=False)
@pytest.mark.parametrize("names", [("bar-impact",), pytest.param(tuple(engines.SHORT), marks=pytest.mark.slow)])
def test_the_fork_gives_the_same_bits(names):
    compare(names)


def test_doctor_compares_the_compilers(monkeypatch, capsys):
    """A compiler that fails is reported, and one that is missing names its package."""
    answers = {
        "taichi": {"version": "1.7.4", "runs": dict.fromkeys(engines.SHORT, "a"), "errors": {}},
        "quadrants": {"version": "9", "runs": {"bar-impact": "a", "two-cubes": "b"}, "errors": {"taylor-bar": "bad"}},
    }
    monkeypatch.setattr(engines, "digests", answers.get)
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: name)
    engines.compare_engines()
    text = capsys.readouterr().out
    assert f"taichi        1.7.4: {len(engines.SHORT)} of {len(engines.SHORT)} runs" in text
    assert f"quadrants     9: 2 of {len(engines.SHORT)} runs, 1 with equal bits" in text
    assert "taylor-bar: bad" in text
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    engines.compare_engines()
    assert "not installed (pip install quadrants)" in capsys.readouterr().out
