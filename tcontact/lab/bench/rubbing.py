"""Cost of friction: a cube of 32^3 hexes whose 1089 contact nodes slide, without, with Coulomb and with layers."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from ...results.result import Result
from ...run.simulation import simulate
from ...scene.friction_models import Coulomb, FrictionLayer, FrictionModel
from ...scene.scene import Scene
from . import blocks, timing

SIZE, SLIDING, COEFFICIENT = 32, 3.0, 0.3  # cells along an edge; slip speed [m/s]
STEPS, ROUNDS = 60, 5
LAW = "neo-hookean"
MODELS: dict[str, FrictionModel | None] = {
    "none": None,
    "coulomb": Coulomb(COEFFICIENT),
    "layer": FrictionLayer(coefficient=COEFFICIENT),
}


def rubbing(arch: str, threads: int) -> dict[str, Any]:
    """Return the step of each model over that without friction, by round, both removals, and the energy errors."""
    load, rows = timing.load(), []
    for removal in ("normal", "full"):
        scene = blocks.block("hex8", LAW, SIZE, removal)
        body = scene.bodies[0]
        fast = replace(body, velocity=body.initial_velocity + np.array([SLIDING, 0.0, 0.0]))
        scenes = {name: replace(scene, bodies=[fast], friction=model) for name, model in MODELS.items()}
        dt = simulate(scenes["none"], threads=threads, arch=arch).dt
        results: dict[str, Result] = {}

        def work(name: str, scenes: dict[str, Scene] = scenes, dt: float = dt, kept: dict = results) -> timing.Work:
            def run() -> float:
                kept[name] = simulate(replace(scenes[name], duration=(STEPS - 0.5) * dt), threads=threads, arch=arch)
                return kept[name].wall_s / kept[name].steps

            run()  # this one compiles
            return run

        taken = timing.rounds({name: work(name) for name in scenes}, 0.0, ROUNDS)
        for name in list(MODELS)[1:]:
            rows.append(
                {
                    "removal": removal,
                    "friction": name,
                    "over_frictionless": timing.spread(taken[name] / taken["none"]),
                    "step_s": timing.spread(taken[name]),
                    "contact_nodes": int(results[name].history["contact_nodes"].max()),
                    "energy_error": float(results[name].history["energy_error"].max()),
                    "layer_error": float(results[name].history.get("layer_error", np.zeros(1)).max()),
                }
            )
    return {"rows": rows, "load": [load, timing.load()]}


def lines(found: list[dict[str, Any]]) -> list[str]:
    """Return the rows of all thread counts as text."""
    text = []
    for part in found:
        if not part["ok"]:
            text.append(f"friction, {part['threads']} threads: FAILED: {part['reason']}")
            continue
        for row in part["rows"]:
            share = row["over_frictionless"]
            text.append(
                f"{row['friction']} friction, {row['removal']} removal, {row['contact_nodes']} sliding nodes on"
                f" {SIZE}^3 hexes, {part['threads']} threads: {share['median']:.3f} [{share['first_quartile']:.3f},"
                f" {share['third_quartile']:.3f}] of the step without; energy error {row['energy_error']:.1e}"
                + (f", layer error {row['layer_error']:.1e}" if row["friction"] == "layer" else "")
            )
    return text
