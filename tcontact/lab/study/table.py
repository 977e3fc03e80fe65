"""A study as text: the table on the terminal and study.csv."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ...device.atomic_file import replaced
from .pareto import IDEALS, changes

NOT_RUN = "not run: over the budget, or interrupted"
COLUMNS = ("method", "size", "cfl", "dt", "steps", "wall_s", "cell_updates", "compile_s", "memory_bytes")


def write_csv(path: Path, report: Mapping[str, Any]) -> None:
    """Write one row per run: cost, main error, energy error, further errors, failure by name, empty for none."""
    further = list(dict.fromkeys(name for row in report["rows"] for name in row.get("errors", {})))
    header = [*COLUMNS, *further, "energy_error", "ok", "failure"]
    with replaced(path) as part, part.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(header)
        for row in report["rows"]:
            flat = dict(row) | row.get("errors", {})
            if row.get("skipped"):
                flat["failure"] = NOT_RUN
            writer.writerow([flat.get(name, "") for name in header])


def lines(report: Mapping[str, Any]) -> list[str]:
    """Return the table: every run, the best method per level, the failures."""
    reference = report["reference"]
    made = f", made {reference['made']}" if "made" in reference else ""
    exact = IDEALS.get(report["error"])
    main = report["error"].removesuffix("_error").replace("_", " ") + (" error" if exact is None else "")
    found = [
        f"{report['case']}: errors against {reference['what']}{made}",
        "",
        f"  {'method':<22} {'size':>5} {'cfl':>5} {'steps':>7} {'wall':>9} {main:>14} {'energy':>8}"
        f" {'Mcell/s':>8} {'MB':>6} {'compile':>8}",
    ]
    for row in report["rows"]:
        head = f"  {row['method']:<22} {row['size']:>5} {row['cfl']:>5g}"
        if "errors" not in row:
            found.append(f"{head} {NOT_RUN if row.get('skipped') else 'FAILED, see below'}")
            continue
        rate = 1e-6 * row["cell_updates"] / row["wall_s"] if row["wall_s"] > 0.0 else float("nan")
        found.append(
            f"{head} {row['steps']:>7} {row['wall_s']:>7.3f} s {_short(row['errors'][report['error']]):>14}"
            f" {_short(row['energy_error']):>8} {rate:>8.3g} {1e-6 * row['memory_bytes']:>6.2g}"
            f" {row['compile_s']:>6.2f} s{'  *' if row['failure'] else ''}"
        )
    if report["pareto"].get(report["error"]):
        found += ["", f"  cheapest for a {main}" + (" of" if exact is None else f" that differs from {exact:g} by")]
        found += [
            f"    <= {best['level']:<7g} {best['method']} (size {best['size']}, cfl {best['cfl']:g}):"
            f" {best['wall_s']:.3g} s, energy error {_short(best['energy_error'])}"
            for best in changes(report["pareto"][report["error"]])
        ]
    if report["failures"]:
        found += ["", "  failures"]
        found += [
            f"    {row['method']} (size {row['size']}, cfl {row['cfl']:g}): {row['failure']}"
            for row in report["failures"]
        ]
    return found


def _short(value: Any) -> str:
    return f"{value:.1e}" if isinstance(value, (int, float)) else str(value)
