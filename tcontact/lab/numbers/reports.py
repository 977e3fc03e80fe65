"""Reports of the commands that make figures: each command runs once, and its report is read."""

from __future__ import annotations

import io
import json
import re
import shlex
import warnings
from collections.abc import Callable
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any

from ...base.errors import OutputError

NAMES = {"run": "summary.json", "study": "study.json", "bench": "bench.json"}


class Reports:
    """Reports of commands, which run into a folder of their own below `out` when they are first asked for.

    main: runs a command line and returns its exit code; say: told each command before it runs.
    """

    def __init__(
        self, out: Path, main: Callable[[list[str]], int], say: Callable[[str], None] = lambda text: None
    ) -> None:
        self.out, self.main, self.say = out, main, say
        self._known: dict[str, dict[str, Any]] = {}

    def folder(self, command: str) -> Path:
        """Return the folder of a command, by its words."""
        return self.out / re.sub(r"[^a-z0-9.]+", "-", command.lower()).strip("-")

    def __call__(self, command: str) -> dict[str, Any]:
        """Return the report of a command. Raises `OutputError` if it left none."""
        if command not in self._known:
            self._known[command] = self._run(command)
        return self._known[command]

    def _run(self, command: str) -> dict[str, Any]:
        self.say(f"tcontact {command}")
        words, folder = shlex.split(command), self.folder(command)
        options = ["--out", str(folder)] + ([] if words[0] == "bench" else ["--force"])
        if words[0] == "run":
            options += ["--quiet"] if "--frames" in words else ["--quiet", "--frames", "0"]
        report = folder / NAMES[words[0]]
        before = _written(report)  # stays: that of a comparison names the runs whose files may be replaced
        with redirect_stdout(io.StringIO()) as printed, warnings.catch_warnings():
            warnings.simplefilter("ignore")
            code = self.main([*words, *options])  # it is 1 where a scheme fails that is meant to fail
        if code == 2 or _written(report) in (None, before):
            raise OutputError(f"`tcontact {command}` left no {report.name} (exit code {code}): {printed.getvalue()}")
        return dict(json.loads(report.read_text(encoding="utf-8")))


def _written(path: Path) -> tuple[int, int] | None:
    """Return what tells a file from one that takes its place later, None without a file."""
    try:
        found = path.stat()
    except OSError:
        return None
    return found.st_ino, found.st_mtime_ns
