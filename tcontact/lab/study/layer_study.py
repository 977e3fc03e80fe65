"""The study of the friction layer as a command leaves it: JSON, CSV, and the table.

A row is a method on a grid with a time step, or the failures of a method in a random sweep of conditions
(`tcontact.friction_layer.study`).
"""

from __future__ import annotations

import csv
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from time import perf_counter
from typing import Any

from ...base.errors import InputError
from ...device import runtime
from ...device.atomic_file import replaced
from ...friction_layer import METHODS
from ...friction_layer import study as layer
from ...results.report import plain, si, versions
from . import pareto

NAME = "friction-layer"
REFERENCE = "an independent code: method of lines, stiff integrator (constants of tcontact.friction_layer.study)"
ERROR = "temperature_error"
KEYS = ("method", "points", "grading", "dt")
HEAD = (
    f"{'speed':>8} {'method':<24} {'points':>6} {'grading':>7} {'dt':>7} {'steps':>5} {'a cell':>8} {'T error':>8}"
    f" {'tau error':>9} {'energy':>8} {'solves':>6} {'failed':>6}"
)


def choose(methods: Sequence[str] | None) -> tuple[str, ...]:
    """Return the methods to run, all by default. Raises `InputError` with the known ones."""
    for name in methods or ():
        if name not in METHODS:
            raise InputError("--methods", name, "use " + ", ".join(METHODS))
    return tuple(methods or METHODS)


def collect(
    methods: Sequence[str],
    budget: float | None = None,
    threads: int | None = None,
    say: Callable[[str], None] = lambda text: None,
) -> dict[str, Any]:
    """Return all rows inside the budget [s] and the cheapest ones per speed and level of error, as data for JSON."""
    started = perf_counter()
    runtime.start("cpu", threads)
    say(HEAD)
    rows: list[dict[str, Any]] = []

    def keep(row: dict[str, Any]) -> None:
        rows.append(row)
        say(_said(row))

    interrupted = False
    try:
        layer.study(budget, methods, keep)
    except KeyboardInterrupt:
        interrupted = True
    return plain(
        {
            "case": NAME,
            "reference": {"what": REFERENCE},
            "error": ERROR,
            "rows": rows,
            "pareto": {f"{speed:g} m/s": pareto.best(_able(rows, speed), ERROR, KEYS) for speed in layer.REFERENCE},
            "skipped": len(layer.tasks(methods)) - len(rows),
            "interrupted": interrupted,
            "seconds": perf_counter() - started,
            "threads": runtime.threads(),
            "arch": runtime.arch(),
            "versions": versions(),
        }
    )


def write_csv(path: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """Write one line per row, empty where a kind has no such figure; conditions that failed stand in the JSON only."""
    names = [name for name in dict.fromkeys(key for row in rows for key in row) if name != "failed"]
    with replaced(path) as part, part.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, names, restval="", extrasaction="ignore")
        writer.writeheader()
        writer.writerows(rows)


def lines(report: Mapping[str, Any]) -> list[str]:
    """Return what is cheapest, and which method failed where; every row was printed when it was done."""
    found = [f"{NAME}: errors against {report['reference']['what']}"]
    for speed, levels in report["pareto"].items():
        if levels:
            found += ["", f"  {speed}, cheapest for a largest error of the temperature over its rise of"]
        found += [
            f"    <= {best['level']:<7g} {best['method']}, {best['points']} points, grading {best['grading']:g},"
            f" dt {si(best['dt'], 's')}: {si(best['wall_s'] / layer.CELLS, 's')} a cell"
            for best in pareto.changes(levels, KEYS)
        ]
    found += ["", "  failures by method"]
    for method in dict.fromkeys(row["method"] for row in report["rows"]):
        mine = [row for row in report["rows"] if row["method"] == method]
        found += [_sweep_line(row) for row in mine if row["kind"] == "failures"]
        runs = [row for row in mine if row["kind"] == "accuracy"]
        bad = [row for row in runs if row["failures"]]
        if runs:
            text = f"    {method}: {len(bad)} of {len(runs)} runs of the case"
            found.append(text + "".join(f"; {row['velocity']:g} m/s, dt {si(row['dt'], 's')}" for row in bad))
    if report["skipped"]:
        found += ["", f"  not run: {report['skipped']} rows, over the budget or interrupted"]
    return found


def _sweep_line(row: Mapping[str, Any]) -> str:
    """Return the failures of a method in the random sweep and where they lie."""
    text = f"    {row['method']}: {row['failed_conditions']} of {row['conditions']} random conditions"
    text += f", {row['failures']} of {row['steps']} steps; {row['evaluations_per_step']:.1f} solves a step"
    if not row["failed"]:
        return text
    ranges = []
    for key, unit in (("velocity", "m/s"), ("initial_temperature", "K"), ("dt", "s")):
        values = [condition[key] for condition in row["failed"]]
        ranges.append(f"{min(values):.2g} .. {max(values):.4g} {unit}")
    return f"{text}; at {', '.join(ranges)}"


def _able(rows: Sequence[Mapping[str, Any]], speed: float) -> list[dict[str, Any]]:
    """Return the rows of a speed as `pareto.best` takes them."""
    mine = [row for row in rows if row["kind"] == "accuracy" and row["velocity"] == speed]
    return [{**row, "ok": row["failures"] == 0, "errors": {ERROR: row[ERROR]}} for row in mine]


def _said(row: Mapping[str, Any]) -> str:
    if row["kind"] == "failures":
        return f"{'':>8} {row['method']:<24} {row['failed_conditions']} of {row['conditions']} random conditions failed"
    return (
        f"{row['velocity']:>4g} m/s {row['method']:<24} {row['points']:>6} {row['grading']:>7g} {si(row['dt'], 's'):>7}"
        f" {row['steps']:>5} {si(row['wall_s'] / row['cells'], 's'):>8} {row[ERROR]:>8.1e} {row['stress_error']:>9.1e}"
        f" {row['energy_error']:>8.1e} {row['evaluations_per_step']:>6.2f} {row['failures']:>6}"
    )
