"""Small scenes and start-up: the bar of 100 cells, what compiling costs, import and first step of the main case."""

from __future__ import annotations

from time import perf_counter
from typing import Any

import numpy as np

from ...device import runtime
from ...run.simulation import simulate
from ...schemes.explicit.central_difference import CentralDifference
from . import blocks, timing

BAR_CELLS = 100
BAR_CFL = 0.9
RUNS = 7
# a fresh interpreter runs this; printed: seconds from before the import to the end of the first step, energy error
FIRST_STEP = """
from time import perf_counter
started = perf_counter()
import tcontact as tc
from tcontact.cases import cube_impact
result = tc.simulate(cube_impact.scene(duration=1e-9), arch={arch!r}, threads={threads})
print(perf_counter() - started, result.steps, result.history["energy_error"].max())
"""


def bar(arch: str, threads: int) -> dict[str, Any]:
    """Run bar-impact with 100 hexes, cfl 0.9, to 4 length/c: seconds of all steps after the compile, and its errors."""
    from ...cases import bar_impact

    material = bar_impact.scene(cells=BAR_CELLS).bodies[0].material
    scene = bar_impact.scene(cells=BAR_CELLS, duration=4 * 0.1 / material.wave_speed)
    load, walls = timing.load(), []
    for _ in range(RUNS + 1):
        result = simulate(scene, CentralDifference(cfl=BAR_CFL), arch=arch, threads=threads)
        if not result.ok:
            raise RuntimeError(f"{result.reason}: {result.message}")
        walls.append(result.wall_s)
    history = result.history
    exact = bar_impact.exact_force(history["time"], result.dt, scene)
    return {
        "wall_s": timing.spread(np.array(walls[1:])),
        "rate": timing.spread(BAR_CELLS * result.steps / np.array(walls[1:])),
        "step_s": timing.spread(np.array(walls[1:]) / result.steps),
        "steps": result.steps,
        "bytes_per_cell": sum(result.memory.values()) / BAR_CELLS,
        "force_error": float(np.linalg.norm(history["contact_force"][:, 2] - exact) / np.linalg.norm(exact)),
        "energy_error": float(np.abs(history["energy_error"]).max()),
        "load": [load, timing.load()],
    }


def compilation(kind: str, law: str, contact: str, arch: str, threads: int, precision: str = "f64") -> dict[str, Any]:
    """Return the seconds by which the first run of a small block takes longer than the second: compiling, loading."""
    runtime.start(arch, threads)
    scene = blocks.block(kind, law, 4, contact)
    begin = perf_counter()
    first = simulate(scene, arch=arch, threads=threads, precision=precision)
    middle = perf_counter()
    simulate(scene, arch=arch, threads=threads, precision=precision)
    if not first.ok:
        raise RuntimeError(f"{first.reason}: {first.message}")
    return {"compile_s": (middle - begin) - (perf_counter() - middle)}
