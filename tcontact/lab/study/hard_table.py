"""Table of the hard cases: it runs them, and leaves their verdicts as JSON, CSV and text."""

from __future__ import annotations

import csv
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from time import perf_counter
from typing import Any

from ...device import runtime
from ...device.atomic_file import replaced
from ...results.report import plain, versions
from .hard_cases import HardCase, evaluate

COLUMNS = ("case", "hard", "verdict", "as_expected", "energy_error", "momentum_error", "static_residual", "remedy")


def collect(
    cases: Sequence[HardCase],
    full: bool = False,
    budget: float | None = None,
    threads: int | None = None,
    say: Callable[[str], None] = lambda text: None,
) -> dict[str, Any]:
    """Run the cases, in order, inside the budget [s]; return rows and versions as plain data for JSON."""
    started = perf_counter()
    rows: list[dict[str, Any]] = []
    interrupted = False
    for case in cases:
        row: dict[str, Any] = {"case": case.name, "hard": case.hard, "expected": list(case.expected), "skipped": False}
        if interrupted or (budget is not None and perf_counter() - started > budget):
            rows.append(row | {"verdict": "not run", "as_expected": False, "skipped": True, "remedy": case.remedy})
            continue
        outcome = evaluate(case, full, threads)
        row |= {
            "verdict": outcome.verdict,
            "as_expected": outcome.as_expected,
            "detail": outcome.detail,
            "energy_error": outcome.energy_error,
            "momentum_error": outcome.momentum_error,
            "static_residual": outcome.static_residual,
            "steps": outcome.steps,
            "wall_s": outcome.wall_s,
            "remedy": case.remedy if outcome.verdict in ("refused", "stopped") else "",
            "checks": [check.to_dict() for check in outcome.checks],
        }
        rows.append(row)
        interrupted = outcome.detail.startswith("interrupted")
        say(f"{case.name:<24} {outcome.verdict}{'' if outcome.as_expected else ', NOT AS IT SHOULD'}")
    return plain(
        {
            "case": "hard-cases",
            "full": full,
            "rows": rows,
            "passed": all(row["as_expected"] for row in rows if not row["skipped"]),
            "interrupted": interrupted,
            "seconds": perf_counter() - started,
            "threads": runtime.threads(),
            "versions": versions(),
        }
    )


def write_csv(path: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """Write one row per case."""
    names = [*COLUMNS, "steps", "wall_s", "detail"]
    with replaced(path) as part, part.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(names)
        writer.writerows([row.get(name, "") for name in names] for row in rows)


def lines(report: Mapping[str, Any]) -> list[str]:
    """Return the table, and in full what is not as it should be."""
    rows = report["rows"]
    width = max(len(row["case"]) for row in rows)
    found = [f"  {'case':<{width}}  {'verdict':<8} {'energy':>8} {'momentum':>8} {'residual':>8}  what is hard; remedy"]
    for row in rows:
        figures = " ".join(
            f"{_short(row.get(key)):>8}" for key in ("energy_error", "momentum_error", "static_residual")
        )
        mark = " " if row["as_expected"] or row["skipped"] else "!"
        remedy = f"; {row['remedy']}" if row["remedy"] else ""
        found.append(f"{mark} {row['case']:<{width}}  {row['verdict']:<8} {figures}  {row['hard']}{remedy}")
    bad = [row for row in rows if not row["as_expected"] and not row["skipped"]]
    if bad:
        found += ["", "  not as it should be"]
        found += [
            f"    {row['case']}: {row['verdict']} instead of {' or '.join(row['expected'])}: {row['detail']}"
            for row in bad
        ]
    return found


def _short(value: Any) -> str:
    return f"{value:.1e}" if isinstance(value, (int, float)) else "-"
