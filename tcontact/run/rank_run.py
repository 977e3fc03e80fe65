"""Simulate a scene on several ranks: every rank steps its part and writes the frames of it (docs/SCALING.md).

The first one plans the scene and gives every rank its part (rank_plan.py). All go through the same loop with the same
rows and take the same decisions. What reads whole bodies, such as looks and the end of the result, the first one does
alone (rank_lead.py).
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from ..base import stages
from ..base.errors import InputError
from ..base.memory import give_back
from ..contact.pairs.pair_contact import check_starts
from ..device.team import Team
from ..planning.partition.body_part import BodyPart
from ..planning.partition.domain_part import DomainPart
from ..planning.partition.outline import PlanOutline, forget_cells, forget_places
from ..planning.planning import Plan
from ..results import frame_fields
from ..results.elsewhere import ResultElsewhere
from ..results.files.checkpoint_heads import place_of
from ..results.report import versions
from ..results.result import Maximum, Result
from ..scene.scene import Scene
from ..schemes.explicit.body_view import BodyView
from ..schemes.explicit.rank_state import RankState
from .body_search import body_search
from .checkpoint import Checkpoint, contents, store
from .checkpoint.fingerprint import compare, fingerprint
from .checkpoint.keeper import Start, start_of
from .device_room import check_same
from .end_state import forces_and_points, motion
from .folder_lock import locked, made_and_locked, make_folder
from .guards import Guards
from .initial_faces import with_kept_faces
from .initial_state import start_of_scene
from .law_checks import check_laws
from .loop import Run
from .part_mesh import RankMesh
from .part_recorder import PartRecorder, goes_on_with_parts
from .prepared import checkpoint_head, finished_plan, start_terms
from .progress import ProgressBar
from .rank_asked import Asked
from .rank_devices import check_as_many, sharing, start_on_ranks
from .rank_files import RankKeeper, RankRecorder, SilentRecorder, latest_of_all, on_all, on_first
from .rank_lead import RankGuards, RankLooks
from .rank_plan import plan_and_parts
from .rank_recut import other_ranks, restore_parts
from .rank_snapshot import WholeBodies, WholeSnapshot
from .recorder import Recorder, check_folder
from .snapshot import Snapshot
from .watches.looks import Looks
from .written_run import carry_out

LARGE = 1 << 17  # nodes of all bodies, from which on ranks give free memory back


class RankRun(Run):
    """`Run` with the states of this rank's parts; parts: of all domains.

    The plan of ranks other than the first is an outline, and their result has no values of nodes and cells.
    """

    def __init__(self, team: Team, parts: Sequence[DomainPart], *given: Any) -> None:
        self.team, self.parts = team, parts
        super().__init__(*given)

    def made_states(self, displacement: list[np.ndarray], velocity: list[np.ndarray]) -> list[Any]:
        """Make the state of this rank's part of every domain.

        Before, what needs cells of whole bodies is made, and they are forgotten.
        """
        self._whole = [body_search(self, plan) if self.team.leads else None for plan in self.planned.bodies]
        self.forget()
        found = []
        for part in self.parts:
            u, v = ([values[number] for number in part.whole.numbers] for values in (displacement, velocity))
            found.append(RankState(self.scene, part, u, v, self.planned.layout, self.team))
        return found

    def forget(self) -> None:
        """Forget cells and positions of whole bodies, which only the first rank may have."""
        forget_cells(self.planned)
        forget_places(self.planned)
        self._give_back()

    def _give_back(self) -> None:
        """Give free memory back, where that is much: it takes a tenth of a second."""
        if sum(plan.node_count for plan in self.planned.bodies) >= LARGE:
            give_back()

    def searches(self) -> list[Any]:
        """Make the search for the stable step of every domain."""
        self._give_back()  # what the states needed on the way
        whole = dict(zip(map(id, self.planned.bodies), self._whole, strict=True))
        del self._whole
        return [domain.searches([whole[id(view.plan)] for view in domain.views]) for domain in self.domains]

    def watches(self) -> tuple[Guards, Looks]:
        """Make the guards and the looks of the run."""
        lead = self.team.lead
        return RankGuards(lead, self.scene, self.states, self.scheme), RankLooks(lead, self)

    @property
    def bodies_here(self) -> list[tuple[int, BodyPart, BodyView]]:
        """The bodies of which this rank has nodes: number in the scene, ascending, part and view of it."""
        found = []
        for state, part in zip(self.domains, self.parts, strict=True):
            for view, number in zip(state.own_views, part.there, strict=True):
                found.append((part.whole.numbers[number], part.bodies[number], view))
        return sorted(found, key=lambda one: one[0])

    def warn(self, text: str, kind: type[Warning] = RuntimeWarning) -> None:
        """Warn on the first rank; if the user has made an error of that, all ranks stop after the next step."""
        try:
            super().warn(text, kind)
        except Warning as error:
            self.refused = self.refused or error

    def raise_refused(self, result: Result) -> None:
        """Raise the first rank's warning that the user has turned into an error on all ranks."""
        self.refused = self.team.from_first(self.refused)
        if self.refused is not None:
            self.team.agreed = self.refused
        super().raise_refused(result)

    def _result(self, *given: Any, **named: Any) -> Result:
        """Make the result; its warnings are those of all ranks, on each of them, its message that of the first one."""
        result = super()._result(*given, **named)
        vars(result)["message"] = self.team.from_first(result.message)  # which names the folder of the run
        told = self.team.comm.allgather(self.warnings)
        for text in dict.fromkeys(text for own in told[1:] for text in own if text not in told[0]):
            if self.team.leads:
                self.warn(text)
        self.warnings[:] = self.team.from_first(self.warnings)
        return result

    def snapshot(self, before: float, after: float) -> Snapshot:
        """Take the state of what this rank has at the present level."""
        views = [view for _, _, view in self.bodies_here]
        return Snapshot(views, before, after, self.dt, self.scheme.implicit)

    def _whole_bodies(self, here: Sequence[tuple[int, BodyPart, Any]]) -> WholeBodies:
        """Return what puts values of the nodes of all ranks together; here: `bodies_here`."""
        sizes = [plan.node_count for plan in self.planned.bodies]
        return WholeBodies(self.team, sizes, [(number, part) for number, part, _ in here])

    def whole_snapshot(self, own: Snapshot) -> WholeSnapshot | None:
        """Return the state of all bodies on the first rank, None on the others; all ranks call it."""
        whole = self._whole_bodies(self.bodies_here)
        velocities = [part.values() for part in own.velocity_field().parts]
        found = WholeSnapshot(self.states, whole.of(own.displacements), whole.of(velocities))
        return found if self.team.leads else None

    @property
    def result_type(self) -> Any:
        """Return what makes the result of its fields."""
        return Result if self.team.leads else partial(ResultElsewhere.on, self.team.rank)

    def end_state(self, last: Snapshot) -> dict[str, Any]:
        """Return the fields of the result with values of nodes and cells, on the first rank.

        The steps are done: all ranks forget their states before the first one makes room for whole bodies.
        """
        self._give_back()
        others = self.team.lead.alone(lambda: forces_and_points(self.scene, self.states))
        here, (displacements, velocities) = self.bodies_here, last.last_values()
        for domain in self.domains:
            domain.forget()
        self._give_back()
        whole = self._whole_bodies(here)
        found = WholeSnapshot([], whole.of(displacements), whole.of(velocities))
        return {} if others is None else motion(self.scene, found) | others

    def cut_by(self, signal: str) -> str:
        """Return what a rank told of with its last rows that stops the run, "" without."""
        self.team.moment = ""
        for domain in self.domains:
            domain.asks_to_end = bool(signal) or self.refused is not None
        if not self.domains[0].ending:
            return ""
        return self.team.first_of(super().cut_by(signal) or None) or ""

    def moves_finitely(self) -> bool:
        """Return whether all displacements of all ranks are finite."""
        return not self.team.any(not super().moves_finitely())

    def largest(self) -> dict[str, Maximum]:
        """Return the maxima of all ranks; of equal values the one that a run on one rank finds."""
        found: dict[str, Maximum] = {}
        for name in self.scene.maxima:
            own = []
            for place, (state, part) in enumerate(zip(self.domains, self.parts, strict=True)):
                for number in (n for n in part.there if name in state.sensors.maxima):
                    value, time, label, cell = state.sensors.maxima[name]
                    if label == part.whole.bodies[number].label:
                        cells = part.bodies[number].part.cells
                        own.append((-value, place, time, number, int(cells[cell]), label))
            known = [one for several in self.team.comm.allgather(own) for one in several]
            if known:
                value, _, time, _, cell, label = min(known)
                found[name] = Maximum(-value, time, label, cell)
        return found


class RecutRun(RankRun):
    """`RankRun` that goes on with checkpoints of another number of ranks, for which its plan keeps the cells."""

    def forget(self) -> None:
        """Forget nothing."""


def simulate_on_ranks(
    team: Team,
    asked: Asked,
    out: str | Path | None,
    options: Checkpoint | None,
    kept: Start | None,
    threads: int | None,
    progress: bool,
) -> Result:
    """Run a scene on all ranks and return its `Result`, whole on the first one (results/elsewhere.py).

    out, threads, progress: as in `simulate`; options: of its checkpoints; kept: the start that they hold, None for that
    of the scene.
    """
    started, scene = perf_counter(), asked.scene
    with ExitStack() as ending:
        _quiet(team, ending)
        folder = None if out is None else on_first(team, lambda: check_folder(out))
        if folder is not None:
            on_first(team, lambda: frame_fields.check_room(folder, scene, asked.frames, asked.fields))
        stages.say("planning")
        fields = () if folder is None else asked.fields
        planned, parts, unshared = plan_and_parts(
            team,
            scene,
            lambda: finished_plan(scene, asked.scheme, asked.precision, fields),
            sharing(asked.contact_ranks, asked.arch),
        )
        stages.say("starting the compiler")
        start_on_ranks(team, scene, parts, asked.arch, threads)
        on_all(team, lambda: check_laws(scene, asked.scheme))
        on_first(team, lambda: check_starts(planned.domains, asked.start[0]))  # type: ignore[arg-type]
        if folder is not None:
            on_first(team, lambda: ending.enter_context(made_and_locked(folder)))
        run = _made(RankRun, team, planned, parts, asked)
        said = run.history.forecast(scene.duration / run.dt, sum(record.row_size for _, record in run.pressures))
        for text in [*asked.told, *unshared, *([] if said is None else [said])]:
            run.warn(text)
        run.handover = asked.handover
        recorder = keeper = None
        if folder is not None:
            on_first(team, lambda: check_folder(folder))
            recorder = _recorder(team, folder, run, asked.fields)
            if options is not None:
                about = (asked.fields, asked.history, asked.pressures, asked.precision)
                head = checkpoint_head(scene, asked.scheme, options, *about) | {"ranks": team.size}
                head["contact_ranks"] = asked.contact_ranks
                new = contents.prints(run)
                if asked.points:
                    new = {path: known for path, known in new.items() if not path.endswith("internal_force.memory")}
                keeper = _keeper(team, options, folder, new, recorder, head, kept)
        start_terms(run, asked.layers, asked.pairs, kept is not None)
        with ProgressBar(scene.duration, "simulate", progress and team.leads) as bar:
            if recorder is None or folder is None:
                result = run.go(asked.frames, None, bar, started)
                run.raise_refused(result)
                return result
            return _carry_out(run, asked.frames, folder, recorder, keeper, bar, started)


def resume_on_ranks(
    team: Team,
    folder: Path,
    scene: Scene,
    scheme: Any,
    threads: int | None,
    progress: bool,
    options: Checkpoint | None,
    precision: str | None,
    arch: str = "cpu",
) -> Result:
    """Go on with a run, see `resume`: with the bits of one that never stopped where as many ranks have started it.

    Raises `InputError` on all ranks.
    """
    started = perf_counter()
    with ExitStack() as ending:
        _quiet(team, ending)
        on_first(team, lambda: ending.enter_context(locked(folder)))
        stored = latest_of_all(folder, team)
        head, start = dict(stored[0].head), start_of(stored[0])
        before = stored[0].ranks

        def check() -> None:
            compare(head["physics"], fingerprint(scene, scheme))
            if precision not in (None, head["precision"]):
                raise InputError("precision", precision, f"the run computes in {head['precision']!r}; resume it so")
            check_same(head, arch)
            check_as_many(before, team.size, arch)

        on_all(team, check)
        scene = with_kept_faces(scene, start, scheme.implicit)

        def make() -> Plan:
            found = finished_plan(scene, scheme, head["precision"], head["fields"])
            for domain in found.domains:
                domain.chunks = head["chunks"]
            return found

        shared = sharing(head.get("contact_ranks"), arch)
        planned, parts, _ = plan_and_parts(team, scene, make, shared, before != team.size)
        start_on_ranks(team, scene, parts, arch, threads)
        history = head["history_every"], head["history_rows"]
        begin = (start or start_of_scene(scene))[:2]
        kept = head["fields"], history, head["pressures"], head["precision"], head.get("contact_ranks")
        asked = Asked(scene, scheme, begin, (), (), None, 0, *kept)
        run = _made(RankRun if before == team.size else RecutRun, team, planned, parts, asked)
        new = contents.prints(run)
        if before == team.size:
            on_all(team, lambda: _take_over(run, stored[0]))
        else:
            restore_parts(run, planned, stored, team)  # type: ignore[arg-type]
            run.warnings.append(text := other_ranks(before, team.size))
            on_first(team, lambda: warnings.warn(text, RuntimeWarning, stacklevel=5))
        recorder = _recorder(team, folder, run, head["fields"], head["frames"])
        head |= {"versions": versions(), "ranks": team.size}
        if options is not None:
            head |= {"origin": dict(options.origin) or head["origin"], "keep": options.keep or head["keep"]}
        keeper = _keeper(team, options, folder, new, recorder, head, start)
        keeper.restored(stored[0].place)
        store.remove_later(folder, stored[0].place, team.rank, team.size)
        with ProgressBar(scene.duration, "resume", progress and team.leads) as bar:
            bar.update(run.course.time)
            return _carry_out(run, run.course.frames, folder, recorder, keeper, bar, started)


def _take_over(run: RankRun, stored: store.Stored) -> None:
    """Give a run the state of a checkpoint that this rank has written. Raises `InputError` where it has not that."""
    with store.taken_over(stored):
        contents.restore(run, stored.found, stored.values)


def _quiet(team: Team, ending: ExitStack) -> None:
    """Let the first rank alone warn; give back what MPI holds at the end."""
    ending.callback(team.free)
    if not team.leads:
        ending.enter_context(warnings.catch_warnings())
        warnings.simplefilter("ignore")


def _made(
    kind: type[RankRun], team: Team, planned: Plan | PlanOutline, parts: list[DomainPart], asked: Asked
) -> RankRun:
    """Make the run of this rank."""
    scene, (every, most) = asked.scene, asked.history
    given = (scene, planned, asked.scheme, *asked.start, every, asked.pressures, most, asked.points)
    return kind(team, parts, *given)


def _recorder(
    team: Team, folder: Path, run: RankRun, fields: Sequence[str], frames: int | None = None
) -> PartRecorder | RankRecorder:
    """Make the recorder of this rank; frames: number of those to keep, None for a new file.

    Each rank writes its part, unless the run goes on from one that other ranks, or one process, have begun.
    """
    mesh, title = RankMesh(team, run.scene, run.parts), " + ".join(run.planned.terms)
    if frames is None or goes_on_with_parts(team, folder, mesh):
        views = [view for _, _, view in run.bodies_here]
        return PartRecorder.started(team, mesh, folder, run.scene, views, title, fields, frames)
    kind = RankRecorder if team.leads else SilentRecorder
    found = on_all(team, lambda: kind(folder, run.scene, run.states, title, fields, frames))
    found.team, found.whole = team, run.whole_snapshot
    return found


def _keeper(
    team: Team,
    options: Checkpoint | None,
    folder: Path,
    new: contents.Prints,
    recorder: Recorder,
    head: dict[str, Any],
    start: Start | None,
) -> RankKeeper:
    """Make the keeper of the checkpoints of this rank."""
    place = place_of(folder, team.rank)
    on_all(team, lambda: make_folder(place))
    keeper = RankKeeper(options, place, new, recorder, head, start)
    keeper.team = team
    return keeper


def _carry_out(
    run: RankRun,
    frames: int,
    folder: Path,
    recorder: Recorder,
    keeper: RankKeeper | None,
    bar: ProgressBar,
    started: float,
) -> Result:
    """Carry out a run whose first rank writes, see `written_run.carry_out`."""
    writer = partial(on_first, run.team)
    return carry_out(run, frames, folder, recorder, keeper, bar, started, writer, ranks=run.team.size)
