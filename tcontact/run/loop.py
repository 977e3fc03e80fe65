"""The time loop: steps with a row of history each, until the end or until a guard stops the run."""

from __future__ import annotations

from contextlib import suppress
from functools import partial
from time import perf_counter
from typing import Any

import numpy as np

from ..base import validate, warning_kinds
from ..base.errors import FunctionError, InputError, OutputError
from ..base.warning_kinds import LockingWarning, RemovalWarning, SlaveWarning
from ..device import arrays
from ..planning.locking import locking
from ..planning.measured import combined
from ..planning.planning import Plan
from ..results.result import Maximum, Result
from ..scene.scene import Scene
from ..scene.slaves import slave_warnings
from ..schemes import Scheme
from ..schemes.explicit.body_view import BodyView
from ..schemes.explicit.stable_step import coarse, largest_rate, with_viscosity
from .body_search import body_search
from .checkpoint.keeper import Keeper
from .course import Course
from .end_checks import end_warnings
from .end_state import end_state
from .entered import entered
from .flutter import SLID, flutter
from .guards import Guards, Stop, early_stop, explained
from .handover import Handover
from .history import MOST_ROWS, History
from .interrupts import interrupts
from .left_inside import left_inside
from .precision import precision_of
from .progress import ProgressBar
from .recorder import Recorder
from .rigid_step import RigidStep
from .shape_watch import ShapeWatch
from .snapshot import Snapshot
from .watches.looks import Looks

FIRST_CHECK = 100  # steps between estimates of the stable step of a nonlinear body; doubled while it does not change
LAST_CHECK = 800
FEW_PRODUCTS = 6
CLOSE = 0.95  # a step larger than this share of the present stable step is shortened to cfl times it
CRUSHED = 0.05  # drop of the smallest det F after which the stable step is estimated at once


class Run:
    """A run: bodies, step size, history, course. A checkpoint holds its attributes that change."""

    result_type: Any = Result

    def __init__(
        self,
        scene: Scene,
        planned: Plan,
        scheme: Scheme,
        displacement: list[np.ndarray],
        velocity: list[np.ndarray],
        history_every: int,
        pressures: bool = False,
        history_rows: int = MOST_ROWS,
        points: tuple[tuple[np.ndarray, ...], ...] = (),
    ) -> None:
        """Plan the run; points: the state of the points of every body (`Result.points`), with which it starts."""
        self.scene, self.planned, self.scheme = scene, planned, scheme
        self.warnings: list[str] = []
        self.refused: Warning | None = None  # the first one that the user has turned into an error
        self.course = Course()
        self.domains: list[Any] = self.made_states(displacement, velocity)
        views = {id(view.plan): view for domain in self.domains for view in domain.views}
        self.states: list[BodyView] = [views[id(body)] for body in planned.bodies]
        # domains with contact step first: they evaluate functions of time, and if one fails nothing has moved yet
        self._order = sorted(self.domains, key=lambda domain: not domain.touching)
        for body in planned.bodies:
            text = locking(body.body, body.label)
            if text is not None:
                self.warn(text, LockingWarning)
        for text in slave_warnings(scene):
            self.warn(text, SlaveWarning)
        self.limits = self.searches()
        for state, own in zip(self.states, points, strict=bool(points)):
            state.start_points(own)  # the stable step is that of this state
        self.dt_limit = self._limit()
        if scheme.implicit or all(state.plan.body.linear for state in self.states):
            self.limits = []  # it does not change: free the memory
        self.shape = ShapeWatch(self.domains, self.limits) if self.limits else None
        self.dt: float = self.scheme.step_size(self.dt_limit)
        if not np.isfinite(self.dt):
            raise InputError(
                "scheme.dt", self.dt, "the stable step is not finite; check density, elastic constants and units"
            )
        validate.step_count("scheme.dt", self.dt, scene.duration)
        self.history = History(history_every, planned.layout, planned.factors, scheme.implicit, history_rows)
        records = [(state, state.pressure_record()) for state in self.states if pressures]
        self.pressures = [(state, record) for state, record in records if record is not None]
        self.rigid = RigidStep.of(self)
        self.guards, self.looks = self.watches()
        self.over_limit = False
        self._check_every, self._next_check, self._jacobian = FIRST_CHECK, FIRST_CHECK, 1.0
        self._warn_over(self.dt, self.dt_limit)
        self._displaced = any(own.any() for own in displacement)  # at the start
        self._flutter = flutter(scene, planned.bodies)
        self.handover: Handover | None = None  # what to tell of a start from the end of another run

    def made_states(self, displacement: list[np.ndarray], velocity: list[np.ndarray]) -> list[Any]:
        """Make the state of every domain; displacement, velocity: start of every body [n, 3]."""
        return list(self.scheme.states(self.scene, self.planned, displacement, velocity))

    def watches(self) -> tuple[Guards, Looks]:
        """Make the guards and the looks of the run."""
        return Guards(self.scene, self.states, self.scheme), Looks(self)

    def cut_by(self, signal: str) -> str:
        """Return what stops the run early, "" without; signal: the name of what this process has received."""
        if signal or self.refused is None:
            return signal
        return f"{type(self.refused).__name__}, which is an error here ({self.refused}),"

    def moves_finitely(self) -> bool:
        """Return whether all displacements are finite."""
        return all(bool(np.isfinite(arrays.get(domain.u)).all()) for domain in self.domains)

    def searches(self) -> list[Any]:
        """Make the search for the stable step of every domain."""
        return [
            domain.searches([body_search(self, view.plan, view.viscous_force) for view in domain.views])
            for domain in self.domains
        ]

    def _limit(self, **options: int) -> float:
        pairs = zip(self.domains, self.limits, strict=True)
        found = min(limit.estimate(domain.u, **options) for domain, limit in pairs)
        self._elastic = min(limit.elastic for limit in self.limits)
        self._damped = min(limit.damped for limit in self.limits)
        return found

    def _warn_over(self, dt: float, limit: float) -> None:
        if dt > limit and not self.over_limit and not self.scheme.implicit:
            self.over_limit = True
            self.warn(f"dt = {dt:.6g} s is above the stable step {limit:.6g} s; the run may blow up")

    def warn(self, text: str, kind: type[Warning] = RuntimeWarning) -> None:
        """Issue a warning now and store it in the result.

        One that the user has turned into an error is raised at once before the run begins. Later it stops the run,
        which keeps what it has, and `raise_refused` raises it.
        """
        self.warnings.append(text)
        try:
            warning_kinds.warn(text, kind)
        except Warning as error:
            if not self.course.begun:
                raise
            self.refused = self.refused or error

    def raise_refused(self, result: Result) -> None:
        """Raise the warning that the user has turned into an error, with the result of the run, which is complete."""
        if self.refused is not None:
            self.refused.result = result  # type: ignore[attr-defined]
            raise self.refused

    def go(
        self, frames: int, recorder: Recorder | None, bar: ProgressBar, started: float, keeper: Keeper | None = None
    ) -> Result:
        """Do all steps and return the result.

        frames: number of frames; started: time at which the call of the user began; keeper: writes checkpoints. A run
        restored from a checkpoint continues from there, with its frames.
        """
        end = self.scene.duration * (1.0 - 1e-9)
        course, first, output, compiled = self.course, True, 0.0, started
        spent = course.wall
        failed: FunctionError | None = None
        unwritten: OutputError | None = None
        if recorder is not None and frames > 0:
            recorder.prepare()
        with interrupts() as interrupted:
            if not course.begun:
                self._begin(frames, end)
            while True:
                cut = self.cut_by(interrupted())
                if keeper is not None and keeper.due(course.row, bool(cut), course.time >= end):
                    writing = perf_counter()
                    course.wall = spent + (0.0 if first else writing - compiled - output)
                    keeper.save(self, course.row)
                    output += perf_counter() - writing
                time, before, row_number, due = course.time, course.before, course.row, course.next_frame
                final = time >= end or bool(cut)
                after = 0.0 if final else self.dt
                frame = (final and course.frames > 0) or time >= due - 0.5 * self.dt
                # a start that is inverted stops the run before it moves
                strained = row_number == 0 and self._displaced
                snapshot = self.snapshot(before, after) if final or frame or strained else None
                many = 1
                if snapshot is None and before == after:
                    many = self._rows_until(min(end, due - 0.5 * self.dt) - time, row_number)
                try:
                    done = self._step(time, before, after, many)
                except FunctionError as error:  # nothing has moved yet: the run ends at this level
                    failed, after, final, frame = error, 0.0, True, course.frames > 0
                    snapshot = self.snapshot(before, after)
                    done = self._step(time, before, after, 1)
                times = np.cumsum([time, *[after] * (done - 1)])
                table = combined(self._tables(times), self.planned.layout)
                self._keep(table)
                row, time = table[-1], float(times[-1])
                row_number += done - 1
                if first:
                    first, compiled, output = False, perf_counter(), 0.0
                    if self.handover is not None:
                        self.warn(self.handover.text(self.history.columns()), RemovalWarning)
                stop = self.guards.check(row, self.history, self.over_limit, after)
                stop = stop or self.looks.take(self, row_number, time, after)
                if stop is not None:  # the state in which it stopped is the last frame
                    snapshot, frame = snapshot or self.snapshot(0.0, 0.0), course.frames > 0
                if snapshot is not None and frame and recorder is not None:
                    writing = perf_counter()
                    try:
                        recorder.frame(time, snapshot)
                    except OutputError as error:
                        unwritten, stop = error, Stop("not-written", str(error))
                    output += perf_counter() - writing
                    course.pass_frames(time, self.dt)
                if stop is not None or final:
                    break
                self._watch(row, row_number)
                course.before, course.time, course.row = after, time + after, row_number + 1
                bar.update(course.time)
        wall = spent + perf_counter() - compiled - output
        if recorder is not None and unwritten is None:
            try:
                recorder.settle()
            except OutputError as error:
                unwritten, stop = error, Stop("not-written", str(error))
        self._keep(None)
        if stop is None:
            stop = early_stop(time, end, failed, cut, keeper)
        assert snapshot is not None
        self.limits, self.shape = [], None  # free their memory for the end
        result = self._result(stop, row_number, time, course.first_dt, snapshot, compiled - started, wall)
        if unwritten is not None:
            unwritten.result = result
            raise unwritten
        return result

    def _begin(self, frames: int, end: float) -> None:
        """Set the times of the frames and the bodies at the start; end [s]: end of the run."""
        for domain in self.domains:
            self.scheme.begin(domain, self.dt)
        if self.rigid is not None:
            self.rigid.begin(self)
        steps, course = max(1, int(np.ceil(end / self.dt))), self.course
        if frames > 1:  # the last frame is always written
            course.due = [float(when) for when in np.round(np.linspace(0, steps, frames)[:-1]) * self.dt]
        course.begun, course.frames, course.first_dt = True, frames, self.dt

    def _tables(self, times: np.ndarray) -> list[np.ndarray]:
        """Return the rows of every domain; beside bodies of nonlinear laws det F is theirs alone, as only they fail."""
        tables = [domain.rows(times) for domain in self.domains]
        for domain, table in zip(self.domains, tables, strict=True):
            if any(self.guards.nonlinear) and all(view.plan.body.linear for view in domain.views):
                table[:, self.planned.layout.place["jacobian_min"]] = np.inf
        return tables

    def snapshot(self, before: float, after: float) -> Snapshot:
        """Take the state at the present level; before, after [s]: the steps that end and start there."""
        return Snapshot(self.states, before, after, self.dt, self.scheme.implicit)

    def _keep(self, table: np.ndarray | None) -> None:
        """Add rows to the history with the pressures of the row that it keeps; None closes it."""
        count = self.history.count
        if table is None:
            self.history.finish()
        else:
            self.history.add(table)
        if self.history.count > count:
            for state, record in self.pressures:
                record.add(state.contact_node_force())
        while table is not None and self.history.thin():
            for _, record in self.pressures:
                record.thin()

    def _warn_flutter(self) -> None:
        """Warn when bodies slide that may flutter."""
        if self._flutter and self.history.friction_work() > SLID * self.history.reference_energy:
            self.warn(self._flutter)
            self._flutter = ""

    def _step(self, time: float, before: float, after: float, many: int) -> int:
        """Do one step of every domain, or up to `many` of a small one; return the number of steps."""
        if many == 1:
            for domain in self._order if len(self._order) > 1 and not self.scheme.implicit else ():
                domain.prepare(time, before, after, 1)  # if a function of time fails, no domain has moved
            for domain in self._order:
                self.scheme.step(domain, time, before, after)
            return 1
        stop_at = self.guards.limits(self.history, self._jacobian - CRUSHED)
        if self.scene.viscosity is not None and self.scheme.dt is None:
            factor = 1.0 if self.shape is None else self.shape.factor
            stop_at["viscous_rate"] = largest_rate(self._elastic * factor, self.dt / CLOSE, self._damped * factor**2)
        if self.shape is not None and stop_at:
            stop_at["contact_nodes"] = self.shape.touching_limit()
        if self.rigid is not None:
            stop_at["rigid_rate"] = self.rigid.largest_rate(self)
        try:
            return self.scheme.step(self.domains[0], time, before, after, many, **stop_at)
        except FunctionError:  # in one of these rows: do one row
            return self._step(time, before, after, 1)

    def _rows_until(self, span: float, number: int) -> int:
        """Return the number of rows from `number` on for one launch: up to the next frame, look, reader or the end."""
        if len(self.domains) > 1 or self.pressures:
            return 1
        rows = min(self.domains[0].rows_at_once, int(span / self.dt))
        if self.shape is not None:
            rows = min(rows, self._next_check - number + 1, self.shape.due - number + 1)
        return max(1, min(rows, self.looks.rows(number)))

    def _of(self, row: np.ndarray, name: str) -> float:
        """Return a number of a measured row."""
        return float(row[self.history.layout.place[name].start])

    def node_limit(self, row: np.ndarray) -> float:
        """Return the present stable step [s] of the nodes alone, with the viscosity of a row."""
        return self._present(self._of(row, "viscous_rate") if self.scene.viscosity is not None else 0.0)

    def _present(self, rate: float, factor: float | None = None) -> float:
        """Return the stable step [s] at a viscous rate [1/s]; factor: of the last estimate, None: by the last look."""
        if factor is None:
            factor = 1.0 if self.shape is None else self.shape.factor
        return with_viscosity(self._elastic * factor, rate, self._damped * factor**2)

    def _watch(self, row: np.ndarray, number: int) -> None:
        """Follow the stable step: at every row of a viscous body, by looks at the shape of nonlinear ones.

        It is estimated again where these ask for it, at intervals and where the smallest det F has fallen.
        """
        self._warn_flutter()
        rate = 0.0
        if self.scene.viscosity is not None:
            rate = self._of(row, "viscous_rate")
            self.keep_below(self._present(rate))
        if self.rigid is not None:
            self.rigid.follow(self, row)
        if self.shape is None or self.over_limit:
            return
        jacobian, touching = self._of(row, "jacobian_min"), self._of(row, "contact_nodes")
        crushed = jacobian < self._jacobian - CRUSHED
        due = number >= self._next_check or crushed
        if not (due or self.shape.wanted(number, touching)):
            return
        if not self.moves_finitely():
            return  # the guards stop at the next row
        used = self.shape.look(number, touching, self.dt, partial(self._present, rate))
        if not (due or used):
            return
        limit = self._limit(products=FEW_PRODUCTS)
        self.shape.anchor(number)
        if self.keep_below(limit) and due:
            self._check_every = FIRST_CHECK // 2
        if crushed:
            self._jacobian = jacobian
        if due:
            self._check_every = min(2 * self._check_every, LAST_CHECK)
        self._next_check = number + self._check_every

    def keep_below(self, limit: float) -> bool:
        """Shorten a step close to the stable one [s], or warn if the user set it; return whether it changed."""
        if self.scheme.dt is not None or self.over_limit:
            self._warn_over(self.dt, limit)
            return False
        if self.dt <= CLOSE * limit:  # a constant step is worth more than the exact cfl number
            return False
        self.dt = coarse(min(self.scheme.step_size(limit), CLOSE * limit))
        return True

    def _result(
        self,
        stop: Stop | None,
        steps: int,
        time: float,
        dt: float,
        last: Snapshot,
        compile_s: float,
        wall_s: float,
    ) -> Result:
        cells = sum(body.mesh.cell_count for body in self.scene.bodies)
        history, entered_pairs = self.history.columns(), self.looks.entered()
        if stop is None:
            floor = self.guards.floor / (self.history.reference_energy or 1.0)
            worst = self.history.worst()
            for text, kind in end_warnings(self.scene, self.scheme, history, dt, floor, worst, entered_pairs):
                self.warn(text, kind)
        stop = explained(stop, entered_pairs)
        memory: dict[str, int] = {}
        for domain in self.domains:
            for name, size in domain.memory().items():
                memory[name] = memory.get(name, 0) + size
        result = self.result_type(
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
            history=history,
            scene=self.scene,
            warnings=self.warnings,
            contact_pressures=tuple(record for _, record in self.pressures),
            scheme=self.scheme,
            maxima=self.largest(),
            peaks=self.history.peaks(),
            precision=precision_of(self.planned),
            **self.end_state(last),
        )
        if stop is None and result.whole:
            found: list[str] = []
            with suppress(FunctionError):  # of a motion, at a time at which the run did not evaluate it
                found += left_inside(self.scene, self.scheme.implicit, result.position, history)
                found += entered(self.scene, result.position, time)
            for text in found:
                self.warn(text)
        return result

    def end_state(self, last: Snapshot) -> dict[str, Any]:
        """Return the fields of the result with values of nodes and cells; last: the state at the end."""
        return end_state(self.scene, self.states, last)

    def largest(self) -> dict[str, Maximum]:
        """Return the largest values of all steps of the quantities in `Scene.maxima`."""
        found: dict[str, Maximum] = {}
        for name in self.scene.maxima:
            known = [Maximum(*domain.sensors.maxima[name]) for domain in self.domains if name in domain.sensors.maxima]
            if known:
                found[name] = max(known, key=lambda one: one.value)
        return found
