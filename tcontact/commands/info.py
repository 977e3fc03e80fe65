"""`tcontact info FILE`: a run at a glance."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from ..errors import InputError


def add(subparsers: Any) -> None:
    """Declare the command."""
    parser = subparsers.add_parser("info", help="show a run at a glance", description="Show a run at a glance.")
    parser.add_argument("file", metavar="FILE", type=Path, help="a result.vtkhdf or the folder of a run")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Print what the file holds."""
    from .. import report
    from .run import show

    path = arguments.file
    folder = path if path.is_dir() else path.parent
    data = _summary(folder / "summary.json") if path.is_dir() or path.name == "result.vtkhdf" else None
    if data is not None and "runs" in data:
        for name in data["runs"]:
            part = _summary(folder / name / "summary.json")
            show(report.lines(part) if part else [f"{folder / name}: no summary.json"])
        return 0
    if data is not None:
        show(report.lines(data))
        settings = ", ".join(f"{key}={value}" for key, value in data["parameters"].items())
        show([f"  set       {settings}", "  made by   " + ", ".join(f"{k} {v}" for k, v in data["versions"].items())])
    if path.is_dir():
        path = path / "result.vtkhdf"
        if not path.is_file() and data is None:
            raise InputError("file", str(folder), "holds no run: neither summary.json nor result.vtkhdf")
    if path.is_file():
        show(contents(path))
    elif data is None:
        raise InputError("file", str(path), "no such file; give a result.vtkhdf or the folder of a run")
    return 0


def contents(path: Path) -> list[str]:
    """What a result file holds, line by line. Raises `InputError` if it is none."""
    from ..report import si
    from ..vtkhdf import ResultData

    data = ResultData.open(path)
    kinds = ", ".join(f"{len(cells)} {kind}" for kind, cells in data.blocks)
    span = f", {si(data.times[0], 's')} to {si(data.times[-1], 's', 4)}" if len(data) else ""
    if "reason" not in data.attributes:
        span += "; the run has not ended: it goes on, or `tcontact resume` goes on with it"
    found = [
        f"{path}: {len(data.points)} nodes, {kinds}, {len(data)} frames{span}",
        "  fields    " + ", ".join([*data.point_fields, *data.cell_fields]),
    ]
    history = data.history
    if history:
        rows = len(next(iter(history.values())))
        found.append(f"  history   {rows} rows: " + ", ".join(history))
        if "energy_error" in history and rows:
            found.append(
                f"  last row  energy error {history['energy_error'][-1]:.3g}, time {si(history['time'][-1], 's', 4)}"
            )
    return found


def _summary(path: Path) -> dict[str, Any] | None:
    if not path.is_file():
        return None
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise InputError("file", str(path), f"is not readable ({error}); run the case again") from error
    if isinstance(data, dict) and "reason" in data and "case" not in data:
        return None  # of a run that a program started: the result file says more
    if not isinstance(data, dict) or not ({"case", "runs"} & data.keys()):
        raise InputError("file", str(path), "is not the summary of a run")
    return data
