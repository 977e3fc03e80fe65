"""Report of a run as numbers: summary.json, history.csv and the table at the end."""

from __future__ import annotations

import csv
import json
import math
import platform
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..base.version import __version__
from ..device import runtime
from ..device.atomic_file import replaced
from . import smoothness
from .acting_force import acting_force, largest_energy_error, partner_in_words
from .checks import Check
from .result import Result
from .tables import flat_columns

SCALARS = ("ok", "reason", "message", "steps", "time", "dt", "dt_limit", "wall_s", "compile_s", "cell_updates_per_s")


def versions() -> dict[str, str]:
    """Return the versions of tcontact, Taichi, numpy and Python, without importing Taichi."""
    from importlib.metadata import PackageNotFoundError, version

    def installed(package: str) -> str:
        try:
            return version(package)
        except PackageNotFoundError:
            return "not installed"

    return {
        "tcontact": __version__,
        "taichi": installed("taichi"),
        "numpy": np.__version__,
        "python": platform.python_version(),
    }


def run_attributes(result: Result) -> dict[str, Any]:
    """Return a run as plain data for JSON: scalars, largest energy error, last row of the history, versions.

    "energy_error_max", "contact_force_max" and "peaks" count every step, other largest values the rows of the history.
    "contact_force_max" [N] is that of the obstacle or pair with the largest force; where there are several,
    "contact_force_of" is its column of the history. "smoothness" holds the numbers of `tcontact.results.smoothness` of
    that force; it is empty if nothing touched. "temperature_max" [K] of metals is the highest of the whole run.
    """
    data: dict[str, Any] = {name: getattr(result, name) for name in SCALARS}
    data["energy_error_max"] = largest_energy_error(result.history, result.peaks)
    if "contact_force" in result.history:
        acting = acting_force(result.history, result.peaks)
        data["contact_force_max"] = acting.largest
        data |= {"contact_force_of": acting.column} if acting.several else {}
    data["peaks"] = dict(result.peaks)
    if "hourglass" in result.history:
        data["hourglass_share_max"] = hourglass_share(result.history)
    if "temperature_max" in result.history:
        data["temperature_max"] = float(np.max(result.history["temperature_max"]))
    data["memory_bytes"] = dict(result.memory)
    data["terms"] = list(result.terms)
    data["warnings"] = list(result.warnings)
    data["cells"] = sum(body.mesh.cell_count for body in result.scene.bodies)
    data["nodes"] = sum(body.mesh.node_count for body in result.scene.bodies)
    data["smoothness"] = smoothness_of(result)
    if result.maxima:
        data["maxima"] = {name: vars(found) for name, found in result.maxima.items()}
    data["last_row"] = {name: column[-1] for name, column in result.history.items()}
    data["versions"] = versions()
    data |= {"arch": runtime.arch(), "threads": runtime.threads(), "precision": result.precision}
    return plain(data)


def total_force(result: Result) -> np.ndarray:
    """Return the largest partner's force [rows] along the normal that all obstacles share; else its size."""
    acting = acting_force(result.history, result.peaks)
    normals = [np.asarray(obstacle.normal) for obstacle in result.scene.obstacles if hasattr(obstacle, "normal")]
    with np.errstate(invalid="ignore"):
        flat = len(normals) == len(result.scene.obstacles) and normals and not acting.of_pair
        if flat and all(np.allclose(normal, normals[0]) for normal in normals):
            return np.asarray(acting.force @ normals[0])
        return acting.size


def smoothness_of(result: Result, records: Sequence[smoothness.PressureRecord] | None = None) -> dict[str, float | int]:
    """Measure how smooth the contact of a run is: numbers of the largest partner's force, and of nodes with records.

    records: one per body that can touch, the worst counts; None = `result.contact_pressures` if the run kept them.
    Empty if nothing touched or the force is not finite.
    """
    if records is None:
        records = result.contact_pressures
    force = total_force(result)
    if not np.isfinite(force).all() or not smoothness.largest(force) > 0.0:
        return {}
    numbers: dict[str, float | int] = {
        "force_variation": smoothness.force_variation(force),
        "peak_over_plateau": smoothness.peak_over_plateau(force),
        "releases": smoothness.releases(force),
    }
    nodal = [record.numbers() for record in records]
    for name in nodal[0] if nodal else ():
        known = [found[name] for found in nodal if np.isfinite(found[name])]
        numbers[name] = max(known, default=float("nan"))
    return numbers


def hourglass_share(history: Mapping[str, np.ndarray]) -> float:
    """Return the largest hourglass energy over the largest kinetic + elastic energy of the run."""
    scale = float((history["kinetic"] + history["elastic"]).max())
    return float(history["hourglass"].max()) / scale if scale > 0.0 else 0.0


def summary(result: Result, *, case: str, parameters: Mapping[str, Any], checks: Sequence[Check]) -> dict[str, Any]:
    """Return `run_attributes` with the case, its parameters, and its checks: value, bound and whether they passed."""
    data = {"case": case, "parameters": dict(parameters)} | run_attributes(result)
    data["checks"] = [check.to_dict() for check in checks]
    data["passed"] = bool(result.ok) and all(check.passed for check in checks)
    return plain(data)


def plain(value: Any) -> Any:
    """Return the value as plain data for JSON: numpy becomes Python, what is not finite becomes text ("nan", "inf")."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float):
        return value if math.isfinite(value) else str(value)
    return value if value is None or isinstance(value, (bool, int, str)) else str(value)


def write_json(path: Path, data: Mapping[str, Any]) -> None:
    """Write plain data as indented JSON."""
    with replaced(path) as part:
        part.write_text(json.dumps(plain(data), indent=2, allow_nan=False) + "\n", encoding="utf-8")


def write_history(path: Path, history: Mapping[str, np.ndarray]) -> None:
    """Write the history as CSV: one row per step, all digits; vectors take the columns name_x, name_y, name_z."""
    columns = flat_columns(history)
    with replaced(path) as part, part.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        writer.writerows(zip(*(column.tolist() for column in columns.values()), strict=True))


def si(value: float, unit: str, digits: int = 3) -> str:
    """Return a value with an SI prefix: si(2.5e-6, "s") = "2.5 us"."""
    if not math.isfinite(value):
        return f"{value} {unit}"
    factor, prefix = si_scale(abs(value))
    return f"{value / factor:.{digits}g} {prefix}{unit}"


def si_scale(size: float) -> tuple[float, str]:
    """Return the power of 1000 for values of this size, and its prefix: 2.5e-6 -> (1e-6, "u")."""
    if not math.isfinite(size) or size == 0.0:
        return 1.0, ""
    power = min(4, max(-4, math.floor(math.log10(size) / 3.0 + 1e-9)))
    return 1000.0**power, ("p", "n", "u", "m", "", "k", "M", "G", "T")[power + 4]


def lines(data: Mapping[str, Any]) -> list[str]:
    """Return the table at the end of a run, from its summary: how it ended, its cost, its errors, the checks."""
    dt, limit = _number(data["dt"]), _number(data["dt_limit"])
    memory = sum(data["memory_bytes"].values()) / 1e6
    where = f"{data['arch']}, {data['threads']} threads"
    where += ", mixed precision" if data.get("precision") == "mixed" else ""
    rows = {
        "dt": f"{si(dt, 's')} = {dt / limit if limit else math.nan:.2f} of the limit {si(limit, 's')}",
        "wall": f"{data['wall_s']:.2f} s, compile {data['compile_s']:.2f} s ({where})",
        "speed": f"{_number(data['cell_updates_per_s']) / 1e6:.3g} Mcell/s"
        f" at an energy error of {_number(data['energy_error_max']):.2e}",
        "hourglass": f"at most {_number(data.get('hourglass_share_max')):.2e} of the largest kinetic + elastic energy",
        "scene": f"{data['cells']} cells, {data['nodes']} nodes, {memory:.3g} MB",
        "terms": ", ".join(data["terms"]),
    }
    if "hourglass_share_max" not in data:
        del rows["hourglass"]
    last = data.get("last_row") or {}
    if "plastic_work" in last:
        rows["metal"] = f"plastic work {si(_number(last['plastic_work']), 'J')}"
        rows["metal"] += f", plastic strain at most {_number(last['plastic_strain_max']):.3g}"
        hottest = data.get("temperature_max", last["temperature_max"])  # older files have that of the last row alone
        rows["metal"] += f", temperature at most {_number(hottest):.4g} K"
    smooth = data.get("smoothness")
    if smooth:
        rows["contact"] = f"force variation {_number(smooth['force_variation']):.3g}"
        if "nodal_variation" in smooth:
            rows["contact"] += f" (a node's {_number(smooth['nodal_variation']):.3g})"
            board = _number(smooth["checkerboard"])
            rows["contact"] += f", checkerboard {board:.2g}" if math.isfinite(board) else ""
        rows["contact"] += f", peak {_number(smooth['peak_over_plateau']):.3g} x plateau, releases {smooth['releases']}"
        if "contact_force_of" in data:
            rows["contact"] += f", of the force {partner_in_words(str(data['contact_force_of']))}"
    found = [f"{data['case']}: {data['reason']} at {si(_number(data['time']), 's', 4)} after {data['steps']} steps"]
    found += [f"  {name:<10}{text}" for name, text in rows.items()]
    if data["message"]:
        found.append(f"  {'remedy' if not data['ok'] else 'note':<10}{data['message']}")
    found += [f"  {'warning':<10}{text}" for text in data["warnings"]]
    return found + check_lines(data["checks"])


def check_lines(checks: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return one line for every check: pass or FAIL, name, value, bound."""
    if not checks:
        return []
    width = max(len(check["name"]) for check in checks)
    return [
        f"  {'pass' if c['passed'] else 'FAIL'}  {c['name']:<{width}}  {_shown(c['value']):>10}  {c['bound']}"
        for c in checks
    ]


def _shown(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, (int, float)) else str(value)


def _number(value: Any) -> float:
    """Return a number from what JSON holds of it."""
    return float(value) if value is not None else math.nan
