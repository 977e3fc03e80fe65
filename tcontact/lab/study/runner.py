"""Runs of a study: the grid methods x sizes x steps inside a budget, every run measured."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from time import perf_counter
from typing import Any

import numpy as np

from ...base.errors import InputError
from ...device import runtime
from ...results.report import plain, versions
from . import errors, pareto
from .methods import Method, method
from .reference import prepare
from .setting import Study, build

SHORT = 0.5  # seconds: runs below it are repeated, the smallest wall counts
REPEATS = 3
GROWN = 0.1  # an energy error above this counts as a failure
WRONG = 1.0  # an error as large as the solution counts as one, too


def collect(study: Study, say: Callable[[str], None] = lambda text: None) -> dict[str, Any]:
    """Return all rows of the study, the reference, the Pareto-best methods, the failures, as plain data for JSON."""
    started = perf_counter()
    reference, about = prepare(study, say)
    rows: list[dict[str, Any]] = []
    interrupted = False
    before: dict[str, tuple[float, dict[str, Any]]] = {}  # seconds and row of the method's last run
    for size in sorted(study.sizes):
        for cfl in sorted(study.cfls, reverse=True):
            for name in study.methods:
                row: dict[str, Any] = {"method": name, "size": size, "cfl": cfl}
                left: float = np.inf if study.budget is None else study.budget - (perf_counter() - started)
                if interrupted or left <= 0.0 or (name in before and _forecast(*before[name], size, cfl) > left):
                    rows.append(row | {"ok": False, "skipped": True, "failure": ""})
                    continue
                begun = perf_counter()
                row |= _one(study, method(name), size, cfl, reference)
                before[name] = (perf_counter() - begun - row.get("compile_s", 0.0), row)
                rows.append(row)
                interrupted = row.get("reason") == "interrupted"
                say(_said(row, study.shown))
    return plain(
        {
            "case": study.name,
            "parameters": study.parameters,
            "reference": about,
            "error": study.shown,
            "rows": rows,
            "pareto": {name: pareto.best(rows, name) for name in study.problem.ERRORS},
            "failures": [
                {key: row[key] for key in ("method", "size", "cfl", "failure")} for row in rows if row["failure"]
            ],
            "skipped": [{key: row[key] for key in ("method", "size", "cfl")} for row in rows if row.get("skipped")],
            "interrupted": interrupted,
            "seconds": perf_counter() - started,
            "threads": runtime.threads(),
            "arch": runtime.arch(),
            "versions": versions(),
        }
    )


def _forecast(seconds: float, row: dict[str, Any], size: int, cfl: float) -> float:
    """Return the seconds of a run of another size and cfl, from the last one: cells times steps."""
    cells = row["cell_updates"] / row["steps"] if row.get("steps") else 1.0
    dimensions = round(np.log(max(cells, 1.0)) / np.log(row["size"])) if row["size"] > 1 else 3
    return float(seconds * (size / row["size"]) ** (dimensions + 1) * row["cfl"] / cfl)


def _one(study: Study, chosen: Method, size: int, cfl: float, reference: Any) -> dict[str, Any]:
    """Do one run, repeated while it is short; return cost and errors, or what it did if it failed."""
    import tcontact as tc

    row: dict[str, Any] = {"ok": False, "failure": "", "warnings": []}
    result: Any = None
    try:
        scene = build(study, chosen, size)
        walls: list[float] = []
        step = study.problem.step(scene) if hasattr(study.problem, "step") else None
        while not walls or (sum(walls) < SHORT and len(walls) < REPEATS):
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                result = tc.simulate(scene, scheme=chosen.scheme(cfl, step), threads=study.threads)
            walls.append(result.wall_s)
            row.setdefault("compile_s", result.compile_s)
            if not result.ok:
                break
    except InputError as error:
        return row | {"failure": f"refused: {error}"}
    cells = sum(body.mesh.cell_count for body in result.scene.bodies)
    row |= {
        "ok": result.ok,
        "reason": result.reason,
        "steps": result.steps,
        "dt": result.dt,
        "dt_limit": result.dt_limit,
        "wall_s": min(walls),
        "repeats": len(walls),
        "cell_updates": cells * result.steps,
        "memory_bytes": sum(result.memory.values()),
        "energy_error": errors.energy(result),
        "warnings": list(result.warnings),
    }
    if not result.ok:
        return row | {"failure": f"{result.reason}: {result.message}"}
    try:
        found = study.problem.errors(result, *(() if reference is None else (reference,)))
    except InputError as error:
        return row | {"ok": False, "failure": f"refused: {error}"}
    row["errors"] = found
    if not row["energy_error"] <= GROWN:
        change = result.history["energy"] - result.history["energy"][0]
        way = "gained" if change[np.argmax(np.abs(change))] > 0.0 else "lost"
        row["failure"] = f"finished, but {way} {100 * row['energy_error']:.0f} % of the energy"
    elif not pareto.error_of(study.shown, found[study.shown]) <= WRONG:
        value, name = found[study.shown], study.shown.replace("_", " ")
        exact = pareto.IDEALS.get(study.shown)
        said = f"{100 * value:.0f} %" if exact is None else f"{value:.3g} instead of {exact:g}"
        row["failure"] = f"finished, but with a {name} of {said}"
    return row


def _said(row: dict[str, Any], error: str) -> str:
    head = f"{row['method']:<22} size {row['size']:<4} cfl {row['cfl']:<5g}"
    if "errors" not in row:
        return f"{head} {row['failure'][:90]}"
    return f"{head} {error} {row['errors'][error]:.2e}, energy {row['energy_error']:.1e}, {row['wall_s']:.3f} s"
