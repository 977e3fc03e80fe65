"""Simulate a scene: check the input, plan, start the runtime, run the loop, write the results."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from time import perf_counter
from typing import Any

from ..base import stages, validate
from ..base.errors import InputError
from ..contact.pairs.pair_contact import check_starts
from ..device import runtime
from ..device.ending import BEFORE, ending_all
from ..device.kernel_counts import counted
from ..device.team import team
from ..planning.planning import Plan
from ..results import frame_fields
from ..results.result import Result
from ..scene.later_start import from_own_start
from ..scene.scene import Scene
from ..schemes import scheme_of
from .checkpoint import Checkpoint, contents
from .checkpoint.keeper import Keeper, Start
from .checkpoint.options import checked
from .device_room import check_device, check_scheme
from .folder_lock import locked, made_folder
from .handover import Handover, handover
from .history import MOST_ROWS
from .initial_faces import kept_start, scene_of_start
from .initial_layers import layers_of
from .initial_state import check_initial, points_of, start_from
from .interrupts import pools_served
from .law_checks import check_laws
from .loop import Run
from .precision import check_precision
from .prepared import checkpoint_head, finished_plan, start_terms
from .progress import ProgressBar
from .rank_asked import Asked
from .rank_checks import check_alike, check_ranks, check_same_start
from .rank_files import on_all
from .rank_run import simulate_on_ranks
from .recorder import Recorder, check_folder, writing_beside
from .written_run import carry_out


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
    checkpoint: float | dict[str, Any] | Checkpoint | None = None,
    fields: Sequence[str] | str | None = None,
    history_rows: int = MOST_ROWS,
    precision: str = "f64",
    comm: Any = None,
    contact_ranks: int | None = None,
) -> Result:
    """Run a scene and return its `Result`.

    scheme: a name or an object with its options; out: folder for result.vtkhdf, history.csv and summary.json (must not
    hold another run); frames: how many states are written, first and last included; threads: CPU threads (None = all);
    arch: "cpu" or "cuda"; progress: a bar on a terminal; history_every: keep every so many rows (docs/COLUMNS.md says
    which numbers still count every step); initial: start from the end of another run of the same bodies, whatever
    velocity and displacement they name: positions, velocities, friction layers (their own side alone on an obstacle of
    another metal than there) and the rows of bodies in contact go on, with contact="auto" the contact faces of that
    run, and those that may meet from its end (a warning names bodies that have more so), with removal="auto" the
    removal of that run (where it cannot stay, a `RemovalWarning` says how momentum and energy jump),
    while time starts at 0 again for moving obstacles and the sums of the history, and a scene without `FrictionLayer`
    drops the layers (a scene whose obstacle has moved to where the meshes would be inside it gives the bodies a
    displacement out of it); pressures: keep the pressures of the contact nodes at every row of the history
    (`Result.contact_pressures`); checkpoint: seconds of wall time between checkpoints in `out` (or a `Checkpoint`, or
    its options as a dictionary), from which `tcontact.resume` goes on after a crash or Ctrl-C; they are removed when
    the run has finished; fields: what frames hold (names in `tcontact.results.frame_fields`; the displacement always),
    None = what costs nothing during the run, "all" = also the pressure of cells, and of contact nodes with friction
    "slip_distance" [m], the path along which they slid on what they touched, and "friction_work" [J/m^2], its work over
    the area weight of the node (`plan(scene).bodies[i].contact_areas()`), both between two bodies on the slave;
    history_rows: largest number of rows beside the last one, which is always kept: beyond it every second one is
    dropped and `history_every` doubles (sums over time, `Result.maxima` and `Result.peaks` still include every step,
    other largest values the rows that are kept; a message before the run says so); precision: "f64", or "mixed":
    float32 arithmetic in the ordinary cells, on differences of displacements that are formed in float64, all else in
    float64 (`tcontact.kernels.cells.mixed_cells` says what that does to the errors).
    Under `mpiexec -n P` the processes share the scene (docs/SCALING.md): each returns a result, the first a whole one
    (`Result.on_all_ranks`).
    comm: the communicator of mpi4py whose processes do so, None = of all that the launcher has started. With
    `MPI.COMM_SELF` each process runs a scene of its own, in a folder of its own, with a part of a split communicator
    several processes do. contact_ranks: how many of them share the contact (docs/SCALING.md), None = as many as
    make the step short.
    Ctrl-C stops after the present step with everything kept, and so do SIGTERM and SIGHUP (a closed terminal) unless
    the program handles or ignores them; the second signal has its usual effect at once (signals reach runs in the main
    thread only). They stop this run: a program with several runs checks the reason "interrupted" before the next one.

    Raises `InputError` before anything is started or written, `OutputError` where output cannot be written (its
    `result` is what was computed up to then).
    """
    started, together = perf_counter(), team(comm)

    def check() -> tuple[Scene, Any, Checkpoint | None]:
        chosen, own = _prepared(scene, scheme)
        validate.whole("frames", frames, 0, 10**6)
        validate.whole("history_every", history_every, 1)
        validate.whole("history_rows", history_rows, 2)
        for name, value in (("progress", progress), ("pressures", pressures)):
            validate.flag(name, value)
        if contact_ranks is not None:
            validate.whole("contact_ranks", contact_ranks, 1)
        check_precision(precision, own, arch)
        check_scheme(own, arch)
        check_initial(initial)
        return chosen, own, checked(checkpoint, out)

    def begin() -> tuple[Start, Scene, list[str], Handover | None, Start | None, Any, Any]:
        places = start_from(scene, initial)
        if initial is None:
            return places, scene, [], None, None, (), ()
        later, said = scene_of_start(scene, places, initial, getattr(scheme, "implicit", False))
        taken = kept_start(later, *places), layers_of(later, initial), points_of(later, initial)
        return places, later, said, handover(later, initial), *taken

    with ending_all(together, BEFORE):
        scene, scheme, options = on_all(together, check)
        if together is not None:
            alike = {"out": out is not None, "frames": frames, "arch": arch, "fields": fields, "pressures": pressures}
            alike |= {
                "contact_ranks": contact_ranks,
                "history_every": history_every,
                "history_rows": history_rows,
                "precision": precision,
            }
            check_alike(together, scene, scheme, alike | {"initial": initial is not None, "checkpoint": options})
            ranks = together.size
            on_all(together, lambda: check_ranks(scene, scheme, arch, ranks))
            if initial is not None:
                check_same_start(together, initial)
                initial = initial.shared_by(together)
        (displacement, velocity), scene, told, jump, kept, layers, points = on_all(together, begin)
        pairs = None if initial is None else initial.pairs
        if together is not None:
            wanted, start = frame_fields.chosen(scene, fields), (displacement, velocity)
            rows = history_every, history_rows
            others = pressures, precision, contact_ranks, arch
            asked = Asked(scene, scheme, start, layers, points, pairs, frames, wanted, rows, *others, told, jump)
            return simulate_on_ranks(together, asked, out, options, kept, threads, progress)
    folder = None if out is None else check_folder(out)
    wanted = frame_fields.chosen(scene, fields)
    if folder is not None:
        frame_fields.check_room(folder, scene, frames, wanted)
    stages.say("planning")
    planned = finished_plan(scene, scheme, precision, () if folder is None else wanted)
    check_device(planned, arch)
    with ExitStack() as ending:
        ending.enter_context(pools_served())
        ending.enter_context(runtime.turn)
        stages.say("starting the compiler")
        runtime.start(arch, threads)
        check_starts(planned.domains, displacement)
        check_laws(scene, scheme)
        if folder is not None:
            ending.enter_context(made_folder(folder))
        ending.enter_context(counted(_kind(planned, scheme, arch, precision, folder is not None and frames > 0)))
        process = None
        if folder is not None:
            ending.enter_context(locked(folder))
            process = ending.enter_context(writing_beside(folder, scene, wanted, frames))
        run = Run(scene, planned, scheme, displacement, velocity, history_every, pressures, history_rows, points)
        said = run.history.forecast(scene.duration / run.dt, sum(record.row_size for _, record in run.pressures))
        for text in [*told, *([] if said is None else [said])]:
            run.warn(text)
        run.handover = jump
        if folder is None:
            start_terms(run, layers, pairs, initial is not None)
            with ProgressBar(scene.duration, "simulate", progress) as bar:
                result = run.go(frames, None, bar, started)
            run.raise_refused(result)
            return result
        check_folder(folder)
        recorder = Recorder(folder, scene, run.states, " + ".join(planned.terms), wanted)
        recorder.process = process
        keeper = None
        if options is not None:
            history = history_every, history_rows
            head = checkpoint_head(scene, scheme, options, wanted, history, pressures, precision)
            head["contact_ranks"] = contact_ranks  # for ranks that go on
            new = contents.prints(run)
            if points:  # a run made again for `resume` starts without them: checkpoints always hold the state
                new = {path: known for path, known in new.items() if not path.endswith("internal_force.memory")}
            keeper = Keeper(options, folder, new, recorder, head, kept)
        start_terms(run, layers, pairs, initial is not None)  # after the fingerprints of the new run
        with ProgressBar(scene.duration, "simulate", progress) as bar:
            return carry_out(run, frames, folder, recorder, keeper, bar, started)


def _prepared(scene: Any, scheme: Any) -> tuple[Scene, Any]:
    """Return a scene as its scheme takes it, and the scheme. Raises `InputError` if one of them is none."""
    if not isinstance(scene, Scene):
        raise InputError("scene", scene, "give a tcontact.Scene")
    scheme = scheme_of(scheme)
    scene = from_own_start(scene).for_scheme(getattr(scheme, "implicit", False))
    if getattr(scheme, "dt", None) is not None:
        validate.step_count("scheme.dt", scheme.dt, scene.duration)
    return scene, scheme


def _kind(planned: Plan, scheme: Any, arch: str, precision: str, pictured: bool) -> str:
    """Return what decides which kernels a run has; pictured: it writes frames. Looks at plain data alone."""
    bodies = [
        ([(block.element, block.material.law) for block in plan.body.blocks], plan.contact and plan.contact.removal)
        for plan in planned.bodies
    ]
    shapes = sorted({obstacle.shape for obstacle in planned.scene.obstacles})
    return repr((planned.terms, bodies, shapes, type(scheme).__name__, arch, precision, pictured))
