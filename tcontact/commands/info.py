"""`tcontact info FILE`: it prints a run at a glance."""

from __future__ import annotations

import argparse
import json
import textwrap
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base import validate
from ..base.errors import InputError
from ..results import report
from ..results.acting_force import acting_force
from ..results.report import check_lines, si
from ..results.stored import is_summary, read_summary, stored_peaks, unended
from ..show.render.colours import FIELDS
from . import options
from .folder import ASIDE, NO_RESULT, PUT_ASIDE
from .run import show

if TYPE_CHECKING:
    from ..results.files.vtkhdf import ResultData


def add(subparsers: Any) -> None:
    """Declare the command."""
    parser = subparsers.add_parser("info", help="show a run at a glance", description="Show a run at a glance.")
    options.add(parser, "FILE")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Print what the file holds."""
    path, whole = arguments.file, validate.is_folder(arguments.file)
    folder = path if whole else path.parent
    data = _summary(folder / "summary.json") if whole or path.name == "result.vtkhdf" else None
    if data is not None and "runs" in data:
        for name in map(str, data["runs"]):
            part = _summary(folder / name / "summary.json")
            show(_table(part, folder / name) if part else [f"{folder / name}: no summary.json"])
        return 0
    if data is not None:
        show(_table(data, folder))
        settings = ", ".join(f"{key}={_short(value)}" for key, value in data["parameters"].items())
        made = ", ".join(f"{key} {value}" for key, value in data["versions"].items())
        show([*(_wrapped("set", settings) if settings else []), *_wrapped("made by", made)])
    if whole:
        path = path / "result.vtkhdf"
        if not path.is_file() and data is None:
            aside = (folder / ASIDE / "result.vtkhdf").is_file()
            raise InputError("file", str(folder), PUT_ASIDE if aside else _no_run(folder))
    if data is None:
        validate.file_exists("file", path, NO_RESULT)
    if path.is_file():
        show(contents(path))
    return 0


def _no_run(folder: Path) -> str:
    """Return why there is nothing to show of a folder without a run, and for that of a study what shows it."""
    if (folder / "study.json").is_file():
        return f"holds a study, no run; `tcontact report {folder}` makes a page of it"
    return "holds no run: neither summary.json nor result.vtkhdf"


def contents(path: Path) -> list[str]:
    """Return what a result file holds, line by line. Raises `InputError` if it is none."""
    from ..results.files.vtkhdf import ResultData

    data = ResultData.open(path)
    kinds = ", ".join(f"{len(cells)} {kind}" for kind, cells in data.blocks)
    span = f", {si(data.times[0], 's')} to {si(data.times[-1], 's', 4)}" if len(data) else ""
    summary = read_summary(path.parent) if path.name == "result.vtkhdf" else {}
    if "reason" not in data.attributes and summary.get("reason") != "not-written":
        span += f"; {unended(data)}"
    files = [path, *(part.path for part in data.parts)]
    size = sum(file.stat().st_size for file in files) / 1e6
    found = [f"{path}: {len(data.points)} nodes, {kinds}, {len(data)} frames{span}, {size:.3g} MB"]
    if data.parts:
        found.append(f"  parts     {len(data.parts)} of as many ranks, in {data.parts[0].path.parent}")
    box = np.ptp(data.points, axis=0)
    found.append("  size      " + " x ".join(si(float(length), "m") for length in box))
    obstacles = data.attributes.get("obstacles", ())
    if obstacles:
        found += _wrapped("obstacles", ", ".join(_obstacle(one) for one in obstacles))
    found += _fields(data)
    history = data.history
    if history:
        rows = len(next(iter(history.values())))
        found += _wrapped("history", f"{rows} rows: " + ", ".join(history))
        if "contact_force" in history and rows:
            acting = acting_force(history, stored_peaks(data))
            if acting.largest > 0.0:
                found.append(f"  force     {sparkline(acting.size)} at most {si(acting.largest, 'N')}{acting.partner}")
        if "energy_error" in history and rows:
            found.append(
                f"  last row  energy error {history['energy_error'][-1]:.3g}, time {si(history['time'][-1], 's', 4)}"
            )
    return found


def _obstacle(one: Mapping[str, Any]) -> str:
    """Return an obstacle in words: its kind, its name where it has one, and whether it moves."""
    name = f" {one['name']!r}" if one.get("name") else ""
    return f"{one.get('kind')}{name}{' (moving)' if one.get('motion') else ''}"


def _table(data: dict[str, Any], folder: Path) -> list[str]:
    """Return the lines of a summary. Raises `InputError` where a part of it is missing, or is not of its type."""
    try:
        return report.lines(data) if "dt" in data else _own(data)
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        text = f"is damaged ({type(error).__name__}: {error}); remove it, or run the case again"
        raise InputError("file", str(folder / "summary.json"), text) from error


def _own(data: dict[str, Any]) -> list[str]:
    """Return the lines of a run of a case without a mechanical scene."""
    found = [str(data["case"])]
    for label, values in data.get("figures", {}).items():
        found.append(f"  {label}: " + ", ".join(f"{name} {_short(value)}" for name, value in values.items()))
    return found + check_lines(data["checks"])


def _fields(data: ResultData) -> list[str]:
    """Return a line for every field: its unit, and its largest value over all frames."""
    names = (*data.point_fields, *data.cell_fields)
    largest = dict.fromkeys(names, 0.0)
    for index in range(len(data)):
        frame = data.frame(index)
        for name, array in (frame.point_data | frame.cell_data).items():
            sizes = np.linalg.norm(array, axis=1) if array.ndim == 2 else np.abs(array)
            largest[name] = max(largest[name], float(np.max(sizes, initial=0.0, where=np.isfinite(sizes))))
    units = {name: FIELDS[name][1] for name in names if name in FIELDS}
    shown = [
        f"{name} (up to {si(largest[name], units[name]) if units.get(name) else _short(largest[name])})"
        for name in names
    ]
    return _wrapped("fields", ", ".join(shown))


def sparkline(values: np.ndarray, width: int = 60) -> str:
    """Return a curve in one line of text, the largest value of every piece of it."""
    pieces = np.array_split(np.nan_to_num(values, nan=0.0, posinf=0.0, neginf=0.0), min(width, len(values)))
    tops = np.array([piece.max() for piece in pieces])
    steps = np.ceil(8 * tops / tops.max()) if tops.max() > 0 else 0 * tops
    return "".join(" ▁▂▃▄▅▆▇█"[int(step)] for step in steps)


def _short(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _wrapped(name: str, text: str) -> list[str]:
    """Return the text behind its name, in lines of 120."""
    return textwrap.wrap(text, 120, initial_indent=f"  {name:<10}", subsequent_indent=" " * 12)


def _summary(path: Path) -> dict[str, Any] | None:
    if not path.is_file():
        return None
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise InputError("file", str(path), f"is not readable ({error}); run the case again") from error
    if not is_summary(data) or not ({"case", "runs", "reason"} & data.keys()):
        raise InputError("file", str(path), "is not the summary of a run; remove it, or run the case again")
    return {
        "case": path.absolute().parent.name,
        "checks": [],
        "parameters": {},
        "versions": {},
    } | data  # as `simulate` leaves it
