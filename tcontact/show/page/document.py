"""The page of a run, of runs side by side, or of a study."""

from __future__ import annotations

import json
from collections.abc import Sequence
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import Any

from ...base.errors import InputError
from ...base.version import __version__
from ...device.atomic_file import refuse_special, replaced
from ...results.report import plain
from ...results.stored import StoredResult, open_result, read_summary
from ..texts import encodable
from . import curves, facts, film, surface
from .studies import study_of

MOST = 4  # runs on a page
SCRIPTS = ("three.js", "figure.js", "view.js", "page.js")


def write_page(folders: Sequence[Path], path: Path) -> Path:
    """Write a page of runs side by side, or of studies, into one file that needs no other and no network; return it.

    folders: of runs, of comparisons (all their runs) or of studies, or result files.
    Raises `InputError` for a folder that holds none of them, for too many runs, and for a file that cannot be written.
    """
    refuse_special(path, "--out")
    runs: list[Path] = []
    studies: list[Path] = []
    for folder in folders:
        named = read_summary(folder).get("runs") if folder.is_dir() else None
        if folder.is_dir() and (folder / "study.json").is_file():
            studies.append(folder)
        elif isinstance(named, list) and not (folder / "result.vtkhdf").is_file():
            runs += [folder / str(name) for name in named]
        else:
            runs.append(folder)
    if len(runs) > MOST:
        names = ", ".join(str(run) for run in runs)
        raise InputError("DIR", names, f"are {len(runs)} runs; a page shows up to {MOST} side by side: name fewer")
    data = {"runs": [run_of(open_result(run)) for run in runs], "studies": [study_of(study) for study in studies]}
    titles = [one["title"] for one in (*data["runs"], *data["studies"])]
    text = assembled(" | ".join(titles), data)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with replaced(path) as part:
            part.write_text(text, encoding="utf-8")
    except OSError as error:
        raise InputError("--out", str(path), f"cannot be written ({error}); name another file") from error
    return path


def run_of(result: StoredResult) -> dict[str, Any]:
    """Return what a page shows of a run. A run that has not ended has no history yet, and goes without curves."""
    ended = result.reason != "running"
    shown: dict[str, Any] = {
        "title": facts.title_of(result),
        "verdict": facts.verdict_of(result),
        "figures": curves.groups_of(result) if ended else [],
        "columns": curves.columns_of(result) if ended else [],
        "checks": facts.check_rows(result),
        "tables": [["Scene", facts.scene_rows(result)], ["Run", facts.run_rows(result)]],
        "times": [],
        "surface": None,
        "film": [],
        "without": "The run stored no frames: run it again with frames to see it here.",
    }
    if ended:
        shown["tables"].insert(0, ["Ledger", facts.ledger_rows(result)])
    if len(result.frames):
        studio = surface.studio_of(result)
        frames = surface.chosen_frames(studio)
        shown["times"] = [float(result.frames.times[index]) for index in frames]
        shown["surface"] = surface.surface_of(studio, frames)
        shown["film"] = film.pictures_of(studio, frames, result.file.parent)
        shown["without"] = f"The surface has more than {surface.FACES} faces: look at it with ParaView."
    return shown


def assembled(title: str, data: dict[str, Any]) -> str:
    """Return the text of the page."""
    numbers = json.dumps(plain(data), separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    parts = {
        "%TITLE%": escape(encodable(title)),
        "%VERSION%": escape(__version__),
        "%STYLE%": _asset("page.css"),
        "%SCRIPT%": "\n".join(_asset(name) for name in SCRIPTS),
    }
    text = _asset("page.html")
    for mark, value in parts.items():
        text = text.replace(mark, value)
    return text.replace("%DATA%", numbers)


def _asset(name: str) -> str:
    return (files(__package__) / "assets" / name).read_text(encoding="utf-8")
