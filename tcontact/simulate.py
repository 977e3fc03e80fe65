"""The loop: rows of history, one step after the other, until the end or until a guard stops it."""

from __future__ import annotations

import signal
import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from . import runtime, validate
from .contact_models import PenaltyContact
from .errors import InputError
from .guards import Guards, Stop
from .history import PLACE, WIDTH, History
from .plan import Plan, plan
from .progress import ProgressBar
from .recorder import Recorder, check_folder
from .result import Result
from .scene import Scene
from .schemes import scheme_of
from .schemes.central_difference import CentralDifference
from .stable_step import StableStep
from .state import BodyState

FIRST_CHECK = 50  # steps between looks at the stable step of a body that deforms; doubled while it stays
LAST_CHECK = 800
FEW_PRODUCTS = 6
CLOSE = 0.95  # a step larger than this share of the present stable step is shortened to cfl times it
CRUSHED = 0.05  # a drop of the smallest det F by this much asks for a look at once


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
) -> Result:
    """Run a scene and return its `Result`.

    scheme: a name or an object with its options; out: folder for result.vtkhdf, history.csv and summary.json (must not
    hold another run); frames: how many states are written, first and last included; threads: CPU threads (None = all);
    arch: "cpu" or "cuda"; progress: a bar on a terminal; history_every: keep every so many rows; initial: start from the
    end of another run of the same bodies. Ctrl-C stops after the present step with everything kept.

    Raises `InputError` before anything is started or written.
    """
    started = perf_counter()
    if not isinstance(scene, Scene):
        raise InputError("scene", scene, "give a tcontact.Scene")
    scheme = scheme_of(scheme)
    validate.whole("frames", frames, 0)
    validate.whole("history_every", history_every, 1)
    displacement, velocity = _start(scene, initial)
    folder = None if out is None else check_folder(out)
    planned = plan(scene)
    runtime.start(arch, threads)
    run = Run(scene, planned, scheme, displacement, velocity, history_every)
    recorder = None if folder is None else Recorder(folder, scene, run.states, " + ".join(planned.terms))
    with ProgressBar(scene.duration, "simulate", progress) as bar:
        result = run.go(frames, recorder, bar, started)
    if recorder is not None and folder is not None:
        from .report import run_attributes, write_history, write_json

        recorder.close(result.history, run_attributes(result))
        write_history(folder / "history.csv", result.history)
        write_json(folder / "summary.json", run_attributes(result))
    return result


def _start(scene: Scene, initial: Result | None) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Displacement and velocity [n, 3] of every body at the start."""
    if initial is None:
        return (
            [np.zeros((body.mesh.node_count, 3)) for body in scene.bodies],
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
    positions, velocities = np.split(initial.position, ends), np.split(initial.velocity, ends)
    for body, speeds in zip(scene.bodies, velocities, strict=True):
        held = np.isfinite(body.prescribed)
        speeds[held] = body.prescribed[held]
    return [x - body.mesh.nodes for x, body in zip(positions, scene.bodies, strict=True)], velocities


class Run:
    """One run: bodies, step size, history."""

    def __init__(
        self,
        scene: Scene,
        planned: Plan,
        scheme: CentralDifference,
        displacement: list[np.ndarray],
        velocity: list[np.ndarray],
        history_every: int,
    ) -> None:
        self.scene, self.planned, self.scheme = scene, planned, scheme
        self.states = [
            BodyState(scene, body, u, v) for body, u, v in zip(planned.bodies, displacement, velocity, strict=True)
        ]
        planes = np.array([obstacle.normal for obstacle in scene.obstacles])
        self.limits = []
        for state in self.states:
            contact, penalty = state.plan.contact, None
            if isinstance(scene.contact, PenaltyContact) and contact is not None:
                penalty = scene.contact.stiffness * contact.areas
            self.limits.append(StableStep(state.plan, planes, penalty))
        self.dt_limit = self._limit()
        self.dt = self.scheme.step_size(self.dt_limit)
        self.history = History(history_every)
        self.warnings: list[str] = []
        self.guards = Guards(scene, self.states)
        self.over_limit = False
        self._check_every, self._next_check, self._jacobian = FIRST_CHECK, FIRST_CHECK, 1.0
        self._warn_over(self.dt, self.dt_limit)

    def _limit(self, **options: int) -> float:
        from . import arrays

        pairs = zip(self.states, self.limits, strict=True)
        return min(limit.estimate(np.array(arrays.get(state.u)), **options) for state, limit in pairs)

    def _warn_over(self, dt: float, limit: float) -> None:
        if dt > limit and not self.over_limit:
            self.over_limit = True
            self.warn(f"dt = {dt:.6g} s is above the stable step {limit:.6g} s; the run may blow up")

    def warn(self, text: str) -> None:
        """Warn now and in the result."""
        self.warnings.append(text)
        warnings.warn(text, RuntimeWarning, stacklevel=4)

    def go(self, frames: int, recorder: Recorder | None, bar: ProgressBar, started: float) -> Result:
        """All steps; returns the result."""
        steps = max(1, int(np.ceil(self.scene.duration / self.dt * (1.0 - 1e-9))))
        written = (
            set(np.round(np.linspace(0, steps, frames)).astype(int)) if frames > 1 else {steps} if frames else set()
        )
        first_dt, before, time, row_number = self.dt, 0.0, 0.0, 0
        stop: Stop | None = None
        last: tuple[list[np.ndarray], list[np.ndarray]] = ([], [])
        compiled = started
        if not np.isfinite(self.dt):
            raise InputError("scheme.dt", self.dt, "the stable step is not finite; give dt")
        with _interrupts() as interrupted:
            for state in self.states:
                self.scheme.begin(state, self.dt)
            while True:
                final = time >= self.scene.duration * (1.0 - 1e-9) or interrupted() or stop is not None
                after = 0.0 if final else self.dt
                keep = final or row_number in written
                if keep:
                    us = [state.displacement() for state in self.states]
                    halves = [state.half_step_velocity() for state in self.states]
                    loose = [state.massless_velocity(before or self.dt) for state in self.states]
                for state in self.states:
                    self.scheme.step(state, before, after)
                rows = [state.row(time) for state in self.states]
                row = _total(rows)
                self.history.add(row)
                if keep:
                    share = before / (before + after) if before + after > 0.0 else 0.0
                    vs = [
                        state.velocity(old + share * (state.half_step_velocity() - old), free)
                        for state, old, free in zip(self.states, halves, loose, strict=True)
                    ]
                    last = us, vs
                    if recorder is not None and (row_number in written or (final and frames > 0)):
                        recorder.frame(time, us, vs, [state.contact_force() for state in self.states])
                if row_number == 0:
                    compiled = perf_counter()
                if final:
                    if interrupted() and time < self.scene.duration * (1.0 - 1e-9) and stop is None:
                        stop = Stop(
                            "interrupted", f"stopped by the user at t = {time:.6g} s; everything up to then is kept"
                        )
                    break
                stop = self.guards.check(row, rows, self.history, self.over_limit)
                if stop is not None:
                    break
                self._watch(row, row_number)
                before, time, row_number = after, time + after, row_number + 1
                bar.update(time)
        self.history.finish()
        if stop is not None and stop.reason != "interrupted":
            last = (
                [state.displacement() for state in self.states],
                [state.velocity(state.half_step_velocity(), None) for state in self.states],
            )
        return self._result(stop, row_number, time, first_dt, last, compiled - started, perf_counter() - compiled)

    def _watch(self, row: np.ndarray, number: int) -> None:
        """Look at the stable step again now and then as a nonlinear body deforms."""
        if not any(self.guards.nonlinear):
            return
        jacobian = float(row[PLACE["jacobian_min"]][0])
        crushed = jacobian < self._jacobian - CRUSHED
        if number < self._next_check and not crushed:
            return
        limit = self._limit(products=FEW_PRODUCTS)
        if self.scheme.dt is not None:
            self._warn_over(self.dt, limit)
        elif self.dt > CLOSE * limit:  # an even step is worth more than the cfl number asked for
            self.dt = min(self.scheme.step_size(limit), CLOSE * limit)
            self._check_every = FIRST_CHECK // 2
        if crushed:
            self._jacobian = jacobian
        self._check_every = min(2 * self._check_every, LAST_CHECK)
        self._next_check = number + self._check_every

    def _result(
        self,
        stop: Stop | None,
        steps: int,
        time: float,
        dt: float,
        last: tuple[list[np.ndarray], list[np.ndarray]],
        compile_s: float,
        wall_s: float,
    ) -> Result:
        cells = sum(body.mesh.cell_count for body in self.scene.bodies)
        memory: dict[str, int] = {}
        for state in self.states:
            for name, size in state.memory().items():
                memory[name] = memory.get(name, 0) + size
        return Result(
            ok=stop is None,
            reason="finished" if stop is None else stop.reason,
            message="" if stop is None else stop.message,
            steps=steps,
            time=time,
            dt=dt,
            dt_limit=self.dt_limit,
            wall_s=wall_s,
            compile_s=compile_s,
            cell_updates_per_s=cells * steps / wall_s if wall_s > 0.0 else 0.0,
            memory=memory,
            terms=self.planned.terms,
            position=np.concatenate([body.mesh.nodes + u for body, u in zip(self.scene.bodies, last[0], strict=True)]),
            velocity=np.concatenate(last[1]),
            contact_node_force=np.concatenate([state.contact_force() for state in self.states]),
            history=self.history.columns(),
            scene=self.scene,
            warnings=self.warnings,
        )


def _total(rows: list[np.ndarray]) -> np.ndarray:
    """The row of all bodies together."""
    if len(rows) == 1:
        return rows[0]
    total = np.sum(rows, axis=0)
    total[0] = rows[0][0]
    for name, pick in (("gap_min", min), ("jacobian_min", min), ("sweeps", max), ("static_residual", max)):
        place = PLACE[name].start
        total[place] = pick(row[place] for row in rows)
    assert len(total) == WIDTH
    return total


@contextmanager
def _interrupts() -> Iterator[Any]:
    """Turns the first Ctrl-C into a flag; the second one is an ordinary KeyboardInterrupt."""
    pressed = [False]
    if threading.current_thread() is not threading.main_thread():
        yield lambda: False
        return
    before = signal.getsignal(signal.SIGINT)

    def remember(_number: int, _frame: Any) -> None:
        pressed[0] = True
        signal.signal(signal.SIGINT, before)

    signal.signal(signal.SIGINT, remember)
    try:
        yield lambda: pressed[0]
    finally:
        signal.signal(signal.SIGINT, before)
