"""Tables of a page: how a run ended, its scene, its checks, its balances."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...base.errors import InputError
from ...results.acting_force import acting_force, largest_energy_error
from ...results.report import si
from ...results.stored import StoredResult

Rows = list[list[str]]


def verdict_of(result: StoredResult) -> dict[str, Any]:
    """Return {"good", "text", "message"}: whether all is well, in words."""
    summary, ended = result.summary, result.reason
    checks = summary.get("checks", [])
    failed = [str(check.get("name")) for check in checks if not check.get("passed")]
    good = result.ok and not failed
    text = "finished" if ended == "finished" else "still running" if ended == "running" else f"stopped: {ended}"
    if checks:
        text += f", {len(checks) - len(failed)} of {len(checks)} checks passed"
    elif not summary and ended != "running":
        text += ", checks unknown as there is no summary.json that can be read"
    return {"good": good, "text": text, "message": result.message}


def run_rows(result: StoredResult) -> Rows:
    """Return how the run went."""
    known = result.frames.attributes
    rows = [
        ["ended", f"{result.reason} at {si(result.time, 's', 4)} after {result.steps} steps"],
        ["step", f"{si(result.dt, 's')} (stable below {si(result.dt_limit, 's')})"],
        ["time taken", f"{si(result.wall_s, 's')}, and {si(result.compile_s, 's')} to plan and compile"],
        ["speed", f"{result.cell_updates_per_s:.3g} cells x steps per second"],
        ["device", f"{known.get('arch', '')}, {known.get('threads', '')} threads, {result.precision}"],
        ["made by", ", ".join(f"{name} {number}" for name, number in known.get("versions", {}).items())],
    ]
    return rows if result.reason != "running" else rows[-2:]


def scene_rows(result: StoredResult) -> Rows:
    """Return what was run."""
    data, known = result.frames, result.frames.attributes
    box = " x ".join(si(float(length), "m") for length in np.ptp(data.points, axis=0))
    kinds = ", ".join(f"{len(cells)} {kind}" for kind, cells in data.blocks)
    obstacles = [f"{one.get('kind')}{' (moving)' if one.get('motion') else ''}" for one in known.get("obstacles", ())]
    rows = [
        ["cells", f"{kinds}; {len(data.points)} nodes"],
        ["size", box],
        ["bodies", ", ".join(map(str, known.get("bodies", ()))) or "1"],
        ["obstacles", ", ".join(obstacles) or "none"],
        ["physics", ", ".join(result.terms)],
        ["frames", f"{len(data)}"],
    ]
    settings = result.summary.get("parameters", {})
    rows += [["settings", ", ".join(f"{name} = {value}" for name, value in settings.items())]] if settings else []
    return rows + [["warning", str(text)] for text in result.warnings]


def check_rows(result: StoredResult) -> list[dict[str, Any]]:
    """Return the checks: name, value, bound and verdict."""
    return [
        {
            "name": str(check.get("name")),
            "value": _figure(check.get("value")),
            "bound": str(check.get("bound")),
            "passed": bool(check.get("passed")),
        }
        for check in result.summary.get("checks", [])
    ]


def ledger_rows(result: StoredResult) -> Rows:
    """Return the balance of the run: energy and its error, contact impulse, largest contact force and penetration."""
    history = result.history
    whole, error = history["kinetic"] + history["elastic"], largest_energy_error(history, result.peaks)
    start, end = (si(float(whole[row]), "J", 4) for row in (0, -1))
    rows = [
        ["kinetic + elastic energy", f"{start} at the start, {end} at the end"],
        ["energy error, largest", f"{error:.2g} of the largest kinetic + elastic energy"],
    ]
    acting = acting_force(history, result.peaks)
    if acting.largest > 0.0:
        rows.append(["contact force, largest", si(acting.largest, "N", 4) + acting.partner])
        if result.frames.attributes.get("obstacles"):
            rows.append(["impulse of the obstacles", si(float(np.linalg.norm(history["impulse"][-1])), "N s", 4)])
    gaps = history["gap_min"][np.isfinite(history["gap_min"])]
    if len(gaps):
        rows.append(["smallest gap", si(float(gaps.min()), "m")])
    return rows


def title_of(result: StoredResult) -> str:
    """Return the name of a run: its case with its label, or its folder."""
    origin = result.summary.get("origin")
    label = str(origin.get("label", "")) if isinstance(origin, dict) else ""
    try:
        name = str(result.summary.get("case") or result.file.absolute().parent.name)
    except InputError:
        name = str(result.file)
    return name if not label or label in name else f"{name} {label}"


def _figure(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
