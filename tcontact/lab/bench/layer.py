"""Speed of the friction layer: million cell steps a second, with the errors of the same runs."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...friction_layer import solve, study
from . import timing

GRIDS = ((40, 30.0), (200, 1.0))  # points, grading
CELLS, DT, RUNS = 1000, 1e-9, 7
SLOWEST, FASTEST = 34.0, 340.0  # speeds of the cells [m/s]: the first is the paper's, the last reaches melting


def layer(arch: str, threads: int) -> dict[str, Any]:
    """Measure both grids: 1000 cells from 34 to 340 m/s, 1.3 GPa, 0.6 us in steps of 1 ns; errors as in the study."""
    speeds = np.linspace(SLOWEST, FASTEST, CELLS)
    load, grids = timing.load(), []
    for points, grading in GRIDS:
        walls = []
        for _ in range(RUNS + 1):
            run = solve(velocity=speeds, points=points, grading=grading, dt=DT, threads=threads, arch=arch)
            walls.append(run.wall_s)
        errors = [study.errors(run, speed, cell) for speed, cell in ((SLOWEST, 0), (FASTEST, -1))]
        grids.append(
            {
                "points": points,
                "grading": grading,
                "rate": timing.spread(CELLS * run.steps / np.array(walls[1:])),
                "temperature_error": max(error[0] for error in errors),
                "stress_error": max(error[1] for error in errors),
                "energy_error": float(np.abs(run.heat - 0.5 * run.slip_work).max() / run.heat.max()),
                "evaluations_per_step": float(run.evaluations.mean() / run.steps),
                "failures": int(run.failures.sum()),
                "bytes_per_cell": run.memory / CELLS,
            }
        )
    return {"cells": CELLS, "grids": grids, "load": [load, timing.load()]}


def lines(rows: list[dict[str, Any]]) -> list[str]:
    """Return the rows of all thread counts as text."""
    found = []
    for row in rows:
        if not row["ok"]:
            found.append(f"friction layer, {row['threads']} threads: FAILED: {row['reason']}")
            continue
        for grid in row["grids"]:
            rate = {name: 1e-6 * grid["rate"][name] for name in ("median", "low", "high")}
            found.append(
                f"friction layer, {row['cells']} cells, {grid['points']} points graded {grid['grading']:g},"
                f" {row['threads']} threads: {rate['median']:.3g} [{rate['low']:.3g}, {rate['high']:.3g}]"
                f" Mcell steps/s; errors {grid['temperature_error']:.1e} (temperature),"
                f" {grid['stress_error']:.1e} (stress), {grid['energy_error']:.1e} (energy),"
                f" {grid['failures']} failures"
            )
    return found
