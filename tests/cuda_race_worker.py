"""Runs scenes on CUDA whose loads and stores are watched (watched_ptx.py): python cuda_race_worker.py OUT.npz."""

import os
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import cuda_contact_scenes
import cuda_scenes
import tiers

from tcontact.device import runtime

# those whose boundary nodes share most: friction on an obstacle that moves freely, pairs; all of them with --slow
WATCHED = tiers.of_tier(("paired",), ("floated",))
RUNS = tuple(cuda_scenes.RUNS) if tiers.long() else ()
RACES = Path(os.environ["TCONTACT_RACES"])


def told() -> list[str]:
    """Return what was told since the last question."""
    lines = RACES.read_text().splitlines() if RACES.exists() else []
    RACES.unlink(missing_ok=True)
    return lines


def planted() -> list[str]:
    """Return what is told of threads that add to the same number, of those that wait in between, and of those apart."""
    from tcontact.kernels.engine import ti

    array = ti.types.ndarray(ti.f64, ndim=1)

    @ti.kernel
    def together(x: array):
        for _ in range(64):
            x[0] = x[0] + 1.0

    @ti.kernel
    def in_turn(x: array):
        ti.loop_config(block_dim=64)
        for t in range(64):
            if t == 0:
                x[1] = 2.0
            ti.simt.block.sync()
            x[2 + t] = x[1] + t

    @ti.kernel
    def unaware(x: array):
        ti.loop_config(block_dim=64)
        for t in range(64):
            ti.simt.block.sync()
            if t == 63:
                x[1] = 3.0
            x[2 + t] = x[1]

    @ti.kernel
    def alike(x: array):
        for _ in range(64):
            x[70] = 5.0

    found, values = [], ti.ndarray(ti.f64, 80)
    for kernel in (together, in_turn, unaware, alike):
        kernel(values)
        found.append(len(told()))
    return found


def main(out: str) -> None:
    """Run everything and store it."""
    runtime.start("cuda")
    found = {"planted": np.array(planted())}
    scenes = cuda_contact_scenes.SCENES if tiers.slow() else WATCHED
    for name in scenes:
        steps = cuda_contact_scenes.run(name, "cuda")["steps"]
        found[f"{name}/steps"], found[f"{name}/told"] = np.array(steps), np.array(told(), dtype=str)
    for name in RUNS:
        steps = cuda_scenes.run(name, "cuda")["steps"]
        found[f"{name}/steps"], found[f"{name}/told"] = np.array(steps), np.array(told(), dtype=str)
    np.savez(out, **found)


if __name__ == "__main__":
    main(sys.argv[1])
