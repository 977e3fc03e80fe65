"""The README: its Python example runs as written, its test command is the one CI runs, its pictures exist."""

import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
TEXT = (ROOT / "README.md").read_text(encoding="utf-8")


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", TEXT, flags=re.DOTALL)


def test_the_python_example_runs_as_written():
    (code,) = blocks("python")
    assert len(code.splitlines()) <= 16
    smaller = code.replace("(16, 16, 16)", "(4, 4, 4)")
    assert smaller != code
    done = subprocess.run([sys.executable, "-c", smaller], cwd=ROOT, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr[-2000:]
    assert "Result(finished" in done.stdout


def test_ci_runs_the_test_command_of_the_readme():
    """The words after the environment is set up are the same."""
    command = blocks("sh")[1].strip().split("&&")[-1].strip()
    assert command.removeprefix(".venv/bin/") in (ROOT / ".ci" / "run").read_text(encoding="utf-8")


def test_every_picture_and_link_exists():
    for path in re.findall(r"\]\(([^)#]+)\)", TEXT):
        assert path.startswith("http") or (ROOT / path).is_file(), path


def test_every_command_of_the_readme_is_known():
    from tcontact import cli

    known = subprocess.run(
        [sys.executable, "-m", "tcontact", "--help"], cwd=ROOT, capture_output=True, text=True
    ).stdout
    for verb in re.findall(r"`tcontact (\w+)", TEXT):
        assert verb in known, verb
    assert cli.main
