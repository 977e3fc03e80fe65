"""`simulate`: check the input, plan, start the runtime, run the loop, write what was asked for."""

from __future__ import annotations

from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from . import runtime, validate
from .errors import InputError
from .loop import Run
from .plan import plan
from .progress import ProgressBar
from .recorder import Recorder, check_folder, make_folder
from .result import Result
from .scene import Scene
from .schemes import scheme_of


def simulate(
    scene: Scene,
    scheme: Any = "central-difference",
    out: str | Path | None = None,
    frames: int = 0,
    threads: int | None = None,
    arch: str = "cpu",
    progress: bool = False,
    history_every: int = 1,
    initial: Result | None = None,
    pressures: bool = False,
) -> Result:
    """Run a scene and return its `Result`.

    scheme: a name or an object with its options; out: folder for result.vtkhdf, history.csv and summary.json (must not
    hold another run); frames: how many states are written, first and last included; threads: CPU threads (None = all);
    arch: "cpu" or "cuda"; progress: a bar on a terminal; history_every: keep every so many rows; initial: start from
    the end of another run of the same bodies, whatever velocity and displacement they name; pressures: keep the
    pressures of the contact nodes at every row of the history (`Result.contact_pressures`). Ctrl-C stops after the
    present step with everything kept.

    Raises `InputError` before anything is started or written.
    """
    started = perf_counter()
    if not isinstance(scene, Scene):
        raise InputError("scene", scene, "give a tcontact.Scene")
    scheme = scheme_of(scheme)
    if scheme.dt is not None:
        validate.step_count("scheme.dt", scheme.dt, scene.duration)
    validate.whole("frames", frames, 0, 10**6)
    validate.whole("history_every", history_every, 1)
    for name, value in (("progress", progress), ("pressures", pressures)):
        if not isinstance(value, bool):
            raise InputError(name, value, "use True or False")
    displacement, velocity = _start(scene, initial)
    folder = None if out is None else check_folder(out)
    planned = plan(scene)
    runtime.start(arch, threads)
    if folder is not None:
        make_folder(folder)
    run = Run(scene, planned, scheme, displacement, velocity, history_every, pressures)
    recorder = None if folder is None else Recorder(folder, scene, run.states, " + ".join(planned.terms))
    with ProgressBar(scene.duration, "simulate", progress) as bar:
        result = run.go(frames, recorder, bar, started)
    if recorder is not None and folder is not None:
        from .report import run_attributes, write_history, write_json

        attributes = run_attributes(result)
        recorder.close(result.history, attributes)
        write_history(folder / "history.csv", result.history)
        write_json(folder / "summary.json", attributes)
    return result


def _start(scene: Scene, initial: Result | None) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Displacement and velocity [n, 3] of every body at the start."""
    if initial is None:
        return (
            [np.array(body.initial_displacement) for body in scene.bodies],
            [np.array(body.initial_velocity) for body in scene.bodies],
        )
    if not isinstance(initial, Result):
        raise InputError("initial", initial, "give the Result of another run")
    counts = [body.mesh.node_count for body in scene.bodies]
    theirs = [body.mesh.cells for body in initial.scene.bodies]
    same = len(theirs) == len(counts) and initial.position.shape == (sum(counts), 3)
    if not same or not all(
        np.array_equal(body.mesh.cells, cells) for body, cells in zip(scene.bodies, theirs, strict=True)
    ):
        raise InputError(
            "initial", initial, f"it ran other meshes; give a run of the same bodies ({sum(counts)} nodes)"
        )
    if not (np.isfinite(initial.position).all() and np.isfinite(initial.velocity).all()):
        raise InputError("initial", initial.reason, "its end state is not finite; start from a run that finished")
    ends = np.cumsum(counts)[:-1]
    positions, velocities = np.split(initial.position, ends), np.split(initial.velocity.copy(), ends)
    for body, speeds in zip(scene.bodies, velocities, strict=True):
        held = np.isfinite(body.prescribed)
        speeds[held] = body.prescribed[held]
    return [x - body.mesh.nodes for x, body in zip(positions, scene.bodies, strict=True)], velocities
