"""`tcontact run CASE` for a case without a mechanical scene, which brings `solve`, `summary`, `write` and `checks`."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from ..base.errors import InputError
from ..device import runtime
from ..results import report
from . import folder


def run_own(case: Any, parameters: dict[str, Any], out: Path, arguments: argparse.Namespace, show: Any) -> int:
    """Solve, check, write files and print the table; return the exit code."""
    if arguments.precision == "mixed":
        raise InputError("--precision", arguments.precision, f"{arguments.case} has no cells; leave it out")
    runtime.start(arguments.arch, arguments.threads)
    runs = case.solve(**parameters)
    checks = [check.to_dict() for check in case.checks(runs)]
    figures = case.summary(runs)
    passed = all(check["passed"] for check in checks)
    with folder.replacing(out, arguments.force):
        data = {"case": arguments.case, "parameters": parameters, "figures": figures, "checks": checks}
        data |= {"passed": passed, "versions": report.versions()}
        data |= {"arch": runtime.arch(), "threads": runtime.threads()}
        report.write_json(out / "summary.json", data)
        case.write(runs, out)
    lines = report.check_lines(checks)
    if arguments.quiet:
        failed = [line for line in lines if "FAIL" in line]
        if failed:
            show(failed)
        return 0 if passed else 1
    print(arguments.case)
    for label, values in figures.items():
        shown = ", ".join(f"{name} {value:.6g}" for name, value in values.items())
        print(f"  {label}: {shown}")
    show(lines)
    print(f"  files in {out}")
    return 0 if passed else 1
