"""Study the friction layer: error against cost over points, grading, time step and method; failures of methods.

Errors are against REFERENCE, from an independent code (method of lines with a stiff integrator,
tests/oracle/friction_layer.py, Richardson in the number of volumes); a slow test computes it again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from .figures import error_against_cost
from .layer import METHODS
from .metals import STAINLESS_304
from .result import LayerResult
from .solution import solve

TIMES = (1e-7, 2e-7, 3e-7, 4e-7, 5e-7, 6e-7)
# speed [m/s]: surface temperature [K] and tau [MPa] at TIMES of the paper's case (stainless 304, 1.3 GPa, b = 1/2)
REFERENCE: dict[float, tuple[tuple[float, ...], tuple[float, ...]]] = {
    34.0: (
        (449.4832, 508.3794, 552.2490, 588.3323, 619.4409, 647.0193),
        (195.37543, 191.65350, 188.70157, 186.18118, 183.95099, 181.93373),
    ),
    340.0: (
        (1460.461, 1711.312, 1845.508, 1898.103, 1898.822, 1898.998),
        (137.506, 112.403, 97.019, 78.533, 66.638, 59.379),
    ),
}
GRIDS = ((20, 30.0), (40, 30.0), (80, 30.0), (40, 1.0), (100, 1.0), (200, 1.0))  # points, grading
STEPS = (4e-9, 2e-9, 1e-9, 5e-10, 2.5e-10, 1e-10)  # dt [s]
CELLS = 16  # equal cells, so that the launch does not dominate the time
SWEEP_STEPS, SWEEP_CELLS, SWEEP_BATCHES = 25, 50, 20


def study(
    budget_s: float | None = None,
    methods: Sequence[str] = METHODS,
    say: Callable[[dict[str, Any]], None] = lambda row: None,
) -> list[dict[str, Any]]:
    """Return the rows of the study; after `budget_s` seconds no further row is begun. Starts Taichi.

    methods: methods to run; say: function called with every finished row.

    kind "accuracy": method, velocity [m/s], points, grading, dt [s], cells, steps, wall_s (after compiling, for all
    cells), compile_s, cell_updates (cells * steps), cell_updates_per_s, temperature_error (largest over TIMES, over the
    rise), last_temperature_error (at the last), stress_error (largest, relative), energy_error (heat against slip
    work), evaluations_per_step, failures.
    kind "failures": method, conditions, failed_conditions, steps, failures, failed (a list of conditions that failed:
    velocity, pressure, dt, initial_temperature, failed steps), wall_s, compile_s: the random sweep.
    """
    begin, rows = perf_counter(), []
    for task in tasks(methods):
        if budget_s is not None and perf_counter() - begin > budget_s:
            break
        rows.append(sweep(task[1]) if task[0] == "failures" else accuracy(*task[1:]))
        say(rows[-1])
    return rows


def tasks(methods: Sequence[str] = METHODS) -> list[tuple[Any, ...]]:
    """List the tasks: failures of every method, errors of the default method on all grids, of others on one grid."""
    return [task for task in _tasks() if task[1] in methods]


def _tasks() -> Iterator[tuple[Any, ...]]:
    yield from (("failures", method) for method in METHODS)
    for velocity in REFERENCE:
        for points, grading in GRIDS:
            yield from (("accuracy", METHODS[0], velocity, points, grading, dt) for dt in STEPS)
        for method in METHODS[1:]:
            yield from (("accuracy", method, velocity, 200, 1.0, dt) for dt in STEPS)


def accuracy(method: str, velocity: float, points: int, grading: float, dt: float) -> dict[str, Any]:
    """Return a row of kind "accuracy", the fastest of three runs."""
    speeds = np.full(CELLS, velocity)
    runs = [
        solve(velocity=speeds, points=points, grading=grading, dt=dt, duration=TIMES[-1], method=method)
        for _ in range(3)
    ]
    run = min(runs, key=lambda one: one.wall_s)
    temperature, stress, last = errors(run, velocity)
    heat = 0.5 * run.slip_work
    return {
        "kind": "accuracy",
        "method": method,
        "velocity": velocity,
        "points": points,
        "grading": grading,
        "dt": dt,
        "cells": CELLS,
        "steps": run.steps,
        "wall_s": run.wall_s,
        "compile_s": runs[0].compile_s,
        "cell_updates": CELLS * run.steps,
        "cell_updates_per_s": run.cell_steps_per_s,
        "temperature_error": temperature,
        "last_temperature_error": last,
        "stress_error": stress,
        "energy_error": float(np.abs(run.heat - heat).max() / heat.max()),
        "evaluations_per_step": float(run.evaluations[0] / run.steps),
        "failures": int(run.failures[0]),
    }


def errors(run: LayerResult, velocity: float, cell: int = 0) -> tuple[float, float, float]:
    """Return the largest relative errors of surface temperature and tau at TIMES, and that of the last temperature."""
    at = [round(time / run.dt) for time in TIMES]
    temperature, tau = (np.array(values) for values in REFERENCE[velocity])
    rise = temperature - run.surface_temperature[0, 0]
    hot = np.abs(run.surface_temperature[at, cell] - temperature) / rise
    weak = np.abs(1e-6 * run.shear_stress[at, cell] / tau - 1.0)
    return float(hot.max()), float(weak.max()), float(hot[-1])


def conditions(seed: int = 1) -> Iterator[tuple[np.ndarray, np.ndarray, float, float]]:
    """Yield the random sweep in batches: velocity [m/s], pressure [Pa] (both [cells]), dt [s], temperature [K].

    v 0.01..1000 m/s and dt 1e-11..1e-6 s by their logarithm, P 0..10 GPa, 300..1890 K: 1000 conditions in all.
    """
    rng = np.random.default_rng(seed)
    for dt in 10.0 ** np.linspace(-11.0, -6.0, SWEEP_BATCHES):
        velocity = 10.0 ** rng.uniform(-2.0, 3.0, SWEEP_CELLS)
        pressure = rng.uniform(0.0, 1e10, SWEEP_CELLS)
        yield velocity, pressure, float(dt), float(rng.uniform(300.0, 1890.0))


def sweep(method: str, points: int = 200) -> dict[str, Any]:
    """Return a row of kind "failures": the random sweep, 25 steps each, by one method."""
    failed: list[dict[str, float]] = []
    steps = failures = evaluations = 0
    wall = compiled = 0.0
    for velocity, pressure, dt, initial in conditions():
        run = solve(
            velocity=velocity,
            pressure=pressure,
            dt=dt,
            duration=SWEEP_STEPS * dt,
            initial_temperature=initial,
            points=points,
            method=method,
        )
        wall += run.wall_s
        compiled += run.compile_s
        steps += run.steps * run.cells
        failures += int(run.failures.sum())
        evaluations += int(run.evaluations.sum())
        failed += [
            {
                "velocity": float(velocity[cell]),
                "pressure": float(pressure[cell]),
                "dt": dt,
                "initial_temperature": initial,
                "failed_steps": int(run.failures[cell]),
            }
            for cell in np.flatnonzero(run.failures)
        ]
    return {
        "kind": "failures",
        "method": method,
        "points": points,
        "metal_melts_at": STAINLESS_304.melting_temperature,
        "conditions": SWEEP_BATCHES * SWEEP_CELLS,
        "failed_conditions": len(failed),
        "steps": steps,
        "failures": failures,
        "failed": failed,
        "evaluations_per_step": evaluations / steps,
        "wall_s": wall,
        "compile_s": compiled,
    }


def draw(path: Path, rows: list[dict[str, Any]]) -> bool:
    """Draw the error-against-cost figure of the rows of `study` as PNG; return False if none of them has an error."""
    if not any(row["kind"] == "accuracy" for row in rows):
        return False
    error_against_cost(path, rows)
    return True
