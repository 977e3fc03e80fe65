"""Tables of figures as lines of Markdown, each from the reports of its commands."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from ..study import hard_table
from . import register
from .reports import Reports
from .rows import Report, Row, short_exponents

HEAD = ("| command | quantity | value |", "|---|---|---|")


@dataclass(frozen=True)
class Table:
    """A table of the documents: its lines from the reports, and whether other machines make the same figures."""

    lines: Callable[[Reports], list[str]]
    repeats: bool = True


def rows(chosen: Sequence[Row], reports: Reports) -> list[str]:
    """Return the lines of a table of rows; a command that stands in the row above is left out."""
    found, above = list(HEAD), ""
    for row in chosen:
        words = "" if row.command == above else f"`tcontact {row.command}`" + (f" ({row.note})" if row.note else "")
        found.append(f"| {words} | {row.quantity} | {row.figures(reports(row.command))} |")
        above = row.command
    return found


def _speed(reports: Reports) -> list[str]:
    """Return the speed of a cube that touches nothing."""
    report = reports(register.BENCH)
    row = next(row for row in report["rows"] if _is(row, "hex8", 32, "none") and row["threads"] > 1)
    speed = f"{1e-6 * row['rate']['median']:.1f}; {row['ratio_to_plain']['median']:.1f}; {row['force_error']:.0e}"
    what = f"million cell updates/s on {row['threads']} threads; times the obvious atomic kernel; forces against NumPy"
    command = f"`tcontact bench --kinds hex8` (32^3, neo-Hookean, {_processor(report)})"
    return [*HEAD, f"| {command} | {what} | {short_exponents(speed)} |"]


def _study(reports: Reports) -> list[str]:
    """Return force and energy error of every method over all sizes, for each step."""
    found = ["| method | step / stable step | force error | energy error |", "|---|---|---|---|"]
    measured = reports(register.STUDY)["rows"]
    for method in register.METHODS.split(","):
        for cfl in (0.9, 0.45):
            mine = [row for row in measured if row["method"] == method and row["cfl"] == cfl]
            force = _range([row["errors"]["force_error"] for row in mine])
            energy = _range([row["energy_error"] for row in mine])
            found.append(f"| {method} | {cfl:g} | {force} | {energy} |")
    return found


def _cost(reports: Reports) -> list[str]:
    """Return what a step costs, kind by kind; the processor in the line above."""
    report = reports(register.BENCH)
    found = [f"{_processor(report)}; {_versions(report)}.", ""]
    found += [
        "| cells, contact on a face | threads | million cell updates/s | times the plain step | share of contact |"
        " bytes per cell | error of forces | energy error |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for row in report["rows"]:
        if not row["ok"]:
            found.append(f"| {_name(row)} | {row['threads']} | failed: {row['reason']} | | | | | |")
            continue
        alone = row["contact"] == "none"
        cells = (
            _name(row),
            f"{row['threads']}",
            f"{1e-6 * row['rate']['median']:.3g}",
            f"{row['ratio_to_plain']['median']:.1f}" if alone else "",
            "" if alone else f"{100 * row['contact_share']['median']:.0f} %",
            f"{row['bytes_per_cell']:.0f}",
            short_exponents(f"{row['force_error']:.0e}"),
            short_exponents(f"{row['energy_error']:.1e}"),
        )
        found.append(f"| {' | '.join(cells)} |")
    for row in report.get("bar", ()):
        step = f"{1e6 * row['step_s']['median']:.0f} us a step" if row["ok"] else f"failed: {row['reason']}"
        errors = (
            f"{row['force_error']:.3f} | {short_exponents(format(row['energy_error'], '.1e'))}" if row["ok"] else " | "
        )
        found.append(f"| bar of 100 `hex8`, contact and history | {row['threads']} | {step} | | | | {errors} |")
    return found


def _others(reports: Reports) -> list[str]:
    """Return the internal force beside other ways to it."""
    report = reports(register.BENCH)
    found = [f"{_processor(report)}; {_versions(report)}.", ""]
    found += [
        "| cells, law | threads | method | million cells/s | time over ours | difference of the forces |"
        " MB held, peak | ready after [s] |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for part in report["alternatives"]:
        for row in part["rows"] if part["ok"] else ():
            name = f"`{row['kind']}` {row['size']}^3, {row['law']} | {row['threads']} | {row['method']}"
            if "rate" not in row:
                found.append(f"| {name} | {row['reason']} | | | | |")
                continue
            cells = (
                f"{1e-6 * row['rate']['median']:.3g}",
                f"{row['times_ours']['median']:.2f}",
                short_exponents(f"{row['force_error']:.0e}"),
                f"{1e-6 * row['held_bytes']:.1f}, {1e-6 * row['peak_bytes']:.1f}",
                f"{row['ready_s']:.1f}",
            )
            found.append(f"| {name} | {' | '.join(cells)} |")
    return found


def _waits(reports: Reports) -> list[str]:
    """Return what is no step, and friction and gap queries, as the bench prints them."""
    from ..bench import table

    return [f"- {line}" for line in table.further(reports(register.BENCH))]


def _hard(reports: Reports) -> list[str]:
    """Return the verdicts of some hard cases, as the study prints them."""
    return ["```text", *(line.rstrip() for line in hard_table.lines(reports(register.HARD))), "```"]


def _range(values: Sequence[float]) -> str:
    low, high = (short_exponents(f"{value:.1e}") for value in (min(values), max(values)))
    return low if low == high else f"{low} .. {high}"


def _is(row: Report, kind: str, size: int, contact: str) -> bool:
    return bool(row["ok"]) and (row["kind"], row["size"], row["contact"]) == (kind, size, contact)


def _name(row: Report) -> str:
    contact = "" if row["contact"] == "none" else f", {row['contact']} removal"
    return f"`{row['kind']}` {row['size']}^3{contact}"


def _processor(report: Report) -> str:
    machine: dict[str, Any] = report["machine"]
    return f"{machine['processor']} ({machine['cores']} cores)"


def _versions(report: Report) -> str:
    return ", ".join(f"{name} {number}" for name, number in report["machine"]["versions"].items())


TABLES = {
    "runs": Table(lambda reports: rows(register.RUNS, reports)),
    "study": Table(_study),
    "hard-cases": Table(_hard),
    "implicit": Table(lambda reports: rows(register.IMPLICIT_RUNS, reports)),
    "cost": Table(_cost, repeats=False),
    "others": Table(_others, repeats=False),
    "waits": Table(_waits, repeats=False),
    "short": Table(lambda reports: rows([row for row in register.RUNS if row.short], reports)),
    "speed": Table(_speed, repeats=False),
}
