"""Cost of contact between bodies: two equal cubes face to face, their meshes turned against each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ...contact.pairs.pair_contact import PairContact
from ...device import runtime
from ...planning.planning import plan
from ...run.simulation import simulate
from ...scene.contact_models import MasslessContact
from ...scene.scene import Scene
from . import blocks, timing
from .parts import PAIR_PARTS, WHOLE_STEP, parts_of_a_step

TURN = 17.0  # between the meshes [degrees]
STEPS, ROUNDS = 60, 5
SHARES = {
    "search": PAIR_PARTS[:1],
    "coupling": PAIR_PARTS[1:],
    "solve": ("boundary nodes and static solve", "contact cells"),
    "force": ("force and update",),
}


def scene(size: int, motion: str) -> Scene:
    """Return the cube of the benchmark and one below it at rest that it touches, its mesh turned about the normal.

    motion: "falling" without a slip but that of the impact, or "sheared" by standing waves too.
    """
    falling = blocks.block("hex8", "neo-hookean", size, "full")
    upper = replace(falling.bodies[0], name="upper")
    if motion == "falling":
        upper = replace(upper, velocity=(0.0, 0.0, -blocks.SPEED))
    half = blocks.LENGTH / 2
    mesh = upper.mesh.translated((0.0, 0.0, -blocks.LENGTH))
    mesh = mesh.rotated(((0.0, 0.0, 1.0), np.radians(TURN)), about=(half, half, 0.0))
    lower = replace(upper, mesh=mesh, velocity=(0.0, 0.0, 0.0), contact="zmax", name="lower")
    return Scene([upper, lower], duration=falling.duration, contact=MasslessContact("full"))


def pairs(arch: str, threads: int, size: int, steps: int = STEPS) -> dict[str, Any]:
    """Return a row for each motion: seconds of a step and the shares of its parts over `steps` steps in contact.

    Each round is a run from the start; the first step, which compiles, is not in it. Shares of the solve and the force
    are None for small cubes, which do both in one launch. `us_per_face_pair`: time of the coupling of a pair of faces
    that may meet.
    """
    runtime.start(arch, threads)
    load = timing.load()
    rows = [_row(scene(size, motion), steps, {"threads": threads, "arch": arch}) | {"motion": motion}
            for motion in ("falling", "sheared")]  # fmt: skip
    return {"size": size, "rows": rows, "load": [load, timing.load()]}


def _row(given: Scene, steps: int, options: dict[str, Any]) -> dict[str, Any]:
    dt = simulate(given, **options).dt
    given = replace(given, duration=(steps - 0.5) * dt)
    result = simulate(given, **options)
    if not result.ok:
        raise RuntimeError(f"{result.reason}: {result.message}")
    history = result.history
    parts = [parts_of_a_step(given) for _ in range(ROUNDS)]
    whole = np.array([sum(one.values()) for one in parts])
    seconds = {name: np.array([sum(one.get(part, 0.0) for part in own) for one in parts])
               for name, own in SHARES.items()}  # fmt: skip
    built = float(history["pair_rebuilds"][-1]) / result.steps
    return {
        "steps": result.steps,
        "step_s": timing.spread(whole),
        "shares": {
            name: None if WHOLE_STEP in parts[0] and name in ("solve", "force") else timing.spread(part / whole)
            for name, part in seconds.items()
        },
        "rebuilds_per_step": built,
        "us_per_face_pair": timing.spread(1e6 * seconds["coupling"] / built / face_pairs(given)),
        "products_mean": float(history["solver_products"][1:].mean()),
        "products_max": float(history["solver_products"].max()),
        "energy_error": float(np.abs(history["energy_error"]).max()),
    }


def face_pairs(given: Scene) -> int:
    """Return how many pairs of faces may meet at the start."""
    domain = plan(given).domains[0]
    coupling = PairContact(domain)
    coupling.search(domain.reference)
    return coupling.face_pairs


def lines(found: Sequence[dict[str, Any]]) -> list[str]:
    """Return the rows of all thread counts as a table in Markdown."""
    text = [
        "| cubes | threads | step, ms | search | coupling | solve | force | rebuilds a step | us per pair of faces |"
        " products: mean, most | energy error |",
        "|" + 11 * "---|",
    ]
    for part in found:
        if not part["ok"]:
            text.append(f"two cubes, {part['threads']} threads: FAILED: {part['reason']}")
            continue
        for row in part["rows"]:
            known = [row["shares"][name] for name in SHARES]
            shares = " | ".join("-" if share is None else f"{100.0 * share['median']:.1f} %" for share in known)
            text.append(
                f"| {part['size']}^3, {row['motion']} | {part['threads']} | {1e3 * row['step_s']['median']:.1f} |"
                f" {shares} | {row['rebuilds_per_step']:.2f} | {row['us_per_face_pair']['median']:.1f} |"
                f" {row['products_mean']:.0f}, {row['products_max']:.0f} | {row['energy_error']:.1e} |"
            )
    return text
