"""The report as text and as CSV. No speed stands without the errors of the same run beside it."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ...device.atomic_file import replaced
from . import alternatives, device_model, layer, queries, rubbing, waiting
from .columns import columns
from .parts import WHOLE_STEP

MEANING = """\
Mcell/s      million cell updates a second of the whole step: force, update, contact, history; median [quartiles]
plain        the obvious step on the same arrays in the same rounds: a cell per iteration, atomic adds, no history
x plain      how many times as fast, compared round by round
x 1 thr      rate over the row with one thread
roof         bytes a step must touch over the measured copy bandwidth, as a share of the time of the step; on a GPU all
             that its kernels read and write (planning/device_traffic.py)
calls/step   launches, copies that wait and syncs of a step in a block of rows, where the driver logs them
contact      share of the step, against the same cube without contact in the same rounds
ledger       what the same kernel costs less without the energy density and without rows, guards and loop around it;
             the sums over nodes (kinetic energy, momenta) are in both, the looks at the stable step in neither
compile      seconds of the first small run beyond the second, in a new process: empty kernel cache / filled one
err f        nodal force against NumPy on a randomly deformed mesh, largest difference over largest value
f32          beside the threads: the cells of this row compute in mixed precision
err E        largest energy error of the timed run"""


def lines(report: Mapping[str, Any]) -> list[str]:
    """Return everything that a terminal shows."""
    rows = report["rows"]
    others = alternatives.lines(report.get("alternatives", []))
    found = [_machine(report["machine"], rows), ""]
    if not rows:
        return [*found, *others]
    found += columns([_cells(row) for row in rows])
    found += [_failure(row) for row in rows if not row["ok"]]
    shares = [row for row in rows if row["ok"] and row.get("parts_s")]
    if shares:
        found += ["", "where the time of a step goes, in us; the timers add to the small parts"]
        found += columns([_parts(row) for row in shares])
    found += device_model.lines(report.get("model", []))
    for row in report.get("bar", ()):
        found += ["", _bar(row) if row["ok"] else f"bar-impact, {row['threads']} threads: FAILED: {row['reason']}"]
    found += layer.lines(report.get("layer", []))
    found += further(report)
    return [*found, "", *MEANING.splitlines(), *([""] if others else []), *others]


def further(report: Mapping[str, Any]) -> list[str]:
    """Return friction, gap queries, and what is no step, as text."""
    return [
        *rubbing.lines(report.get("rubbing", [])),
        *queries.lines(report.get("queries", [])),
        *waiting.lines(report),
    ]


def rows_of(parts: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Return the rows of all parts that have some."""
    return [row for part in parts if part["ok"] for row in part["rows"]]


def write_csv(path: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """Write one line per row; what is nested takes columns name.part."""
    flat = [_flat(row) for row in rows]
    names = list(dict.fromkeys(name for row in flat for name in row))
    with replaced(path) as part, part.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, names)
        writer.writeheader()
        writer.writerows(flat)


def _flat(row: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    result: dict[str, Any] = {}
    for name, value in row.items():
        if isinstance(value, Mapping):
            result |= _flat(value, f"{prefix}{name}.")
        else:
            result[prefix + name] = value
    return result


def _cells(row: Mapping[str, Any]) -> dict[str, str]:
    cells = _head(row)
    if not row["ok"]:
        return cells | {"Mcell/s": "FAILED"}
    rate = {name: 1e-6 * row["rate"][name] for name in ("median", "first_quartile", "third_quartile")}
    cells["Mcell/s"] = f"{rate['median']:.3g} [{rate['first_quartile']:.3g}, {rate['third_quartile']:.3g}]"
    alone = row["contact"] == "none"
    cells["err f"], cells["err E"] = f"{row['force_error']:.1e}", f"{row['energy_error']:.1e}"
    cells["plain"] = f"{1e-6 * row['plain_rate']['median']:.3g}" if alone else ""
    cells["x plain"] = f"{row['ratio_to_plain']['median']:.2f}" if alone else ""
    cells["x 1 thr"] = f"{row['over_one_thread']:.2f}" if row["threads"] > 1 and "over_one_thread" in row else ""
    share = "ledger" if alone else "contact"
    cells["share"] = f"{_percent(row, share + '_share')} {share}" if share + "_share" in row else "-"
    cells["B/cell"] = f"{row['bytes_per_cell']:.0f}"
    cells["GB/s"] = f"{1e-9 * row['copy_bytes_per_s']['median']:.1f}"
    cells["roof"] = _percent(row, "roofline_share")
    if row["arch"] == "cuda":
        calls = row.get("calls_per_step")
        cells["ms/step"] = f"{1e3 * row['step_s']['median']:.3g}"
        names = ("launches", "copies", "syncs")
        cells["calls/step"] = "-" if calls is None else ", ".join(f"{calls[name]:.3g}" for name in names)
    cold, warm = row.get("compile_cold_s"), row.get("compile_warm_s")
    cells["compile s"] = f"{_seconds(cold)} / {_seconds(warm)}"
    return cells


def _head(row: Mapping[str, Any]) -> dict[str, str]:
    cells = {name: str(row[name]) for name in ("kind", "law", "size")}
    where = str(row["threads"]) if row["arch"] == "cpu" else row["arch"]
    where += " f32" if row.get("precision") == "mixed" else ""
    return cells | {"thr": where, "contact": row["contact"]}


def _machine(machine: Mapping[str, Any], rows: Sequence[Mapping[str, Any]]) -> str:
    versions = ", ".join(f"{name} {number}" for name, number in machine["versions"].items())
    text = f"{machine['processor']}, {machine['cores']} cores; {versions}"
    if "device" in machine:
        text += f"\nGPU: {machine['device']}"
    loads = [max(row["load"]) - row["threads"] for row in rows if row["ok"] and row["arch"] == "cpu"]
    if loads and max(loads) > 0.5:
        text += f"\nNOTE: a loaded machine (load up to {max(loads):.1f} above our threads): rates are too low, and with"
        text += " several threads ratios are off too"
    return text


def _bar(row: Mapping[str, Any]) -> str:
    return (
        f"bar-impact, 100 hexes to 4 L/c, {row['threads']} threads: {row['wall_s']['median']:.3f} s"
        f" [{row['wall_s']['low']:.3f}, {row['wall_s']['high']:.3f}] after the compile,"
        f" {1e6 * row['step_s']['median']:.0f} us a step; force error {row['force_error']:.3f} (L2, exact solution),"
        f" energy error {row['energy_error']:.1e}"
    )


def _name(row: Mapping[str, Any]) -> str:
    contact = "" if row["contact"] == "none" else f", {row['contact']} removal"
    return f"{row['kind']} {row['law']} {row['size']}^3, {row['threads']} threads{contact}"


def _failure(row: Mapping[str, Any]) -> str:
    return f"FAILED {_name(row)}: {row['reason']}"


def _parts(row: Mapping[str, Any]) -> dict[str, str]:
    """Return the microseconds by group of parts."""
    groups = {
        "whole step": (WHOLE_STEP,),
        "force and update": ("force and update",),
        "contact cells": ("contact cells",),
        "boundary, static solve": ("boundary nodes and static solve",),
        "rows, guards, loop": ("history row", "history", "guards", "loop"),
        "stable step": ("stable step",),
    }
    cells = _head(row)
    for name, parts in groups.items():
        known = [row["parts_s"][part] for part in parts if part in row["parts_s"]]
        cells[name] = f"{1e6 * sum(known):.0f}" if known else ""
    return cells | {"err E": f"{row['energy_error']:.1e}"}


def _percent(row: Mapping[str, Any], name: str) -> str:
    return f"{100 * row[name]['median']:.1f}%"


def _seconds(value: float | None) -> str:
    return "-" if value is None else f"{value:.1f}"
