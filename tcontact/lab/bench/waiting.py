"""What a user waits for beside the steps: the set-up of a large body, the frames of a run, the default case."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np

from ...device import runtime
from ...results.result import Result
from ...run.simulation import simulate
from ...scene.scene import Scene
from . import blocks, timing

LAW = "neo-hookean"
SETUP_SIZE, COMPILING_SIZE = 100, 24  # cells along an edge; the second is large enough for the kernels of large bodies
FRAMES_SIZE, FRAMES, STEPS, ROUNDS = 32, 100, 600, 3


def setup(arch: str, threads: int) -> dict[str, Any]:
    """Return CPU seconds and memory from the mesh to the end of the first step of a cube with contact on a face.

    The cube is set up twice, as its contact face has a kernel that a smaller body has not: the first time for
    `peak_over_arrays`, growth of the resident memory of the process up to its peak over the arrays of the run (nan
    where the system does not tell), the second time, with all kernels compiled, for the seconds.
    """
    runtime.start(arch, threads)
    load = timing.load()
    _run(blocks.block("hex8", LAW, min(COMPILING_SIZE, SETUP_SIZE), "normal"), arch, threads)
    before = resident("VmRSS")
    arrays = sum(_run(blocks.block("hex8", LAW, SETUP_SIZE, "normal"), arch, threads).memory.values())
    peak = resident("VmHWM")
    begin, cpu = perf_counter(), process_time()
    result = _run(blocks.block("hex8", LAW, SETUP_SIZE, "normal"), arch, threads)
    return {
        "cpu_s": process_time() - cpu,
        "wall_s": perf_counter() - begin,
        "array_bytes": arrays,
        "peak_over_arrays": (peak - before) / arrays,
        "cells": SETUP_SIZE**3,
        "energy_error": float(np.abs(result.history["energy_error"]).max()),
        "load": [load, timing.load()],
    }


def frames(arch: str, threads: int) -> dict[str, Any]:
    """Return what the files of a run with frames add to it, in turns with the same run that writes nothing.

    `share`: added wall time over the whole of the run without files; `cpu_share`: the same of CPU time.
    """
    runtime.start(arch, threads)
    load = timing.load()
    scene = blocks.block("hex8", LAW, FRAMES_SIZE, "normal")
    scene = replace(scene, duration=(STEPS - 0.5) * _run(scene, arch, threads).dt)
    cpu: dict[str, list[float]] = {"bare": [], "framed": []}
    last: list[Result] = []

    def timed(name: str) -> timing.Work:
        def work() -> float:
            with tempfile.TemporaryDirectory(prefix="tcontact-bench-") as folder:
                files = {"out": Path(folder) / "run", "frames": FRAMES} if name == "framed" else {}
                begin, spent = perf_counter(), process_time()
                last[:] = [_run(scene, arch, threads, **files)]
                cpu[name].append(process_time() - spent)
                return perf_counter() - begin

        return work

    taken = timing.rounds({name: timed(name) for name in cpu}, 0.0, ROUNDS)
    return {
        "size": FRAMES_SIZE,
        "frames": FRAMES,
        "steps": last[0].steps,
        "wall_s": timing.spread(taken["bare"]),
        "share": timing.spread(taken["framed"] / taken["bare"] - 1.0),
        "cpu_share": timing.spread(np.array(cpu["framed"]) / np.array(cpu["bare"]) - 1.0),
        "energy_error": float(np.abs(last[0].history["energy_error"]).max()),
        "load": [load, timing.load()],
    }


def _run(scene: Scene, arch: str, threads: int, **files: Any) -> Result:
    result = simulate(scene, arch=arch, threads=threads, **files)
    if not result.ok:
        raise RuntimeError(f"{result.reason}: {result.message}")
    return result


def resident(name: str) -> float:
    """Return a size of this process [B] by its name in Linux, VmRSS (now) or VmHWM (largest); nan elsewhere."""
    try:
        lines = Path("/proc/self/status").read_text(encoding="utf-8").splitlines()
        return 1024.0 * next(float(line.split()[1]) for line in lines if line.startswith(f"{name}:"))
    except (OSError, StopIteration):
        return float("nan")


def lines(report: Mapping[str, Any]) -> list[str]:
    """Return the rows of set-up, frames and start as text."""
    say = {"setup": _setup, "frames": _frames, "start": _start}
    names = {"setup": "set-up of a large body", "frames": "frames of a run", "start": "start of cube-impact"}
    return [
        f"{names[part]}, {row['threads']} threads: " + (text(row) if row["ok"] else f"FAILED: {row['reason']}")
        for part, text in say.items()
        for row in report.get(part, ())
    ]


def _setup(row: Mapping[str, Any]) -> str:
    return (
        f"{row['cells']} hexes, {row['cpu_s']:.1f} CPU seconds ({row['wall_s']:.1f} s) from the mesh to the first step,"
        f" {1e-6 * row['array_bytes']:.0f} MB of arrays, at the peak {float(row['peak_over_arrays']):.1f} times that;"
        f" energy error {row['energy_error']:.1e}"
    )


def _frames(row: Mapping[str, Any]) -> str:
    share, cpu = ([100.0 * row[name][end] for end in ("median", "low", "high")] for name in ("share", "cpu_share"))
    return (
        f"{row['frames']} frames of {row['size']}^3 hexes add {share[0]:.1f} % [{share[1]:.1f}, {share[2]:.1f}] to the"
        f" {row['wall_s']['median']:.2f} s of {row['steps']} steps, {cpu[0]:.1f} % to their CPU time;"
        f" energy error {row['energy_error']:.1e}"
    )


def _start(row: Mapping[str, Any]) -> str:
    return (
        f"import and first step {row['cold_s']:.1f} s with an empty kernel cache, {row['warm_s']:.1f} s with a filled"
        f" one; `tcontact run cube-impact` to its last file {row['run_cold_cpu_s']:.1f} and {row['run_warm_cpu_s']:.1f}"
        f" CPU seconds ({row['run_cold_s']:.1f} and {row['run_warm_s']:.1f} s)"
    )
