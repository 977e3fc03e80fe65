"""The two solvers of the static solve beside each other: sweeps against MPRGP on one face of a linear hex8 cube."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ...device import runtime
from ...run.simulation import simulate
from ...scene.contact_models import MasslessContact
from ...scene.materials import LinearElastic
from ...scene.scene import Scene
from . import blocks, timing
from .parts import WHOLE_STEP, parts_of_a_step

SOLVERS = ("gauss-seidel", "projected-gradient")
POISSONS = (0.3, 0.45, 0.49)
STEPS = 40  # in contact from the first one; more would see the wave come back
ROUNDS = 3


def impact(size: int, poisson: float, removal: str, solver: str) -> Scene:
    """Return the cube of the benchmark with another Poisson's ratio."""
    scene = blocks.block("hex8", "linear", size, removal)
    material = LinearElastic(blocks.YOUNG, poisson, blocks.DENSITY)
    body = replace(scene.bodies[0], material=material)
    duration = STEPS * 0.5 * blocks.LENGTH / size / material.wave_speed
    return replace(scene, bodies=[body], duration=duration, contact=MasslessContact(removal, solver=solver))


def compare(
    size: int, threads: int, poissons: Sequence[float] = POISSONS, removals: Sequence[str] = ("normal", "full")
) -> list[dict[str, Any]]:
    """Return a row per removal, Poisson's ratio and solver, timed in turns: sweeps or products, seconds of a step.

    `contact_s`: boundary nodes, contact cells and static solve, which one thread does, None for a small cube, whose
    step is one launch; `step_s`: the whole step.
    """
    runtime.start("cpu", threads)
    found = []
    for removal in removals:
        for poisson in poissons:
            scenes = {solver: impact(size, poisson, removal, solver) for solver in SOLVERS}
            results = {solver: simulate(scene, threads=threads) for solver, scene in scenes.items()}
            parts: dict[str, list[dict[str, float]]] = {solver: [] for solver in SOLVERS}
            for _ in range(ROUNDS):
                for solver, scene in scenes.items():
                    parts[solver].append(parts_of_a_step(scene))
            for solver, result in results.items():
                count = result.history["sweeps"][1:]
                mine = parts[solver]
                contact = [part["boundary nodes and static solve"] for part in mine if WHOLE_STEP not in part]
                found.append(
                    {
                        "size": size,
                        "threads": threads,
                        "removal": removal,
                        "poisson": poisson,
                        "solver": solver,
                        "ok": result.ok,
                        "count_mean": float(count.mean()),
                        "count_max": float(count.max()),
                        "static_residual": float(result.history["static_residual"].max()),
                        "contact_s": timing.spread(np.array(contact)) if contact else None,
                        "step_s": timing.spread(np.array([sum(part.values()) for part in mine])),
                    }
                )
    return found


def lines(rows: Sequence[dict[str, Any]]) -> list[str]:
    """Return the rows as a table in Markdown."""
    found = [
        "| removal | poisson | threads | solver | sweeps or products: mean, most | largest residual |"
        " contact, ms a step | whole step, ms |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for row in rows:
        contact, step = (f"{1e3 * row[name]['median']:.2f}" if row[name] else "-" for name in ("contact_s", "step_s"))
        found.append(
            f"| {row['removal']} | {row['poisson']:g} | {row['threads']} | {row['solver']} | {row['count_mean']:.1f},"
            f" {row['count_max']:.0f} | {row['static_residual']:.0e} | {contact} | {step} |"
        )
    return found
