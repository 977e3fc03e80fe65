"""Resume a run from the last complete checkpoint in its folder, bit for bit as if it had never stopped."""

from __future__ import annotations

import warnings
from pathlib import Path
from time import perf_counter
from typing import Any

from ..base import validate
from ..base.errors import InputError
from ..device import runtime
from ..device.ending import BEFORE, ending_all
from ..device.team import team
from ..planning.planning import plan
from ..results.files.checkpoint_heads import last_complete, others, place_of
from ..results.files.vtkhdf import ResultData
from ..results.report import versions
from ..results.result import Result
from ..scene.scene import Scene
from ..schemes import scheme_of
from .checkpoint import Checkpoint, contents, store
from .checkpoint.fingerprint import compare, fingerprint
from .checkpoint.keeper import Keeper, start_of
from .checkpoint.options import checked
from .device_room import check_device, check_same, check_scheme
from .folder_lock import locked
from .initial_faces import with_kept_faces
from .initial_state import start_of_scene
from .interrupts import pools_served
from .loop import Run
from .no_checkpoint import NOT_ON_ALL, nothing, warn_of_damage
from .precision import check_precision, set_precision
from .prepared import record_friction
from .progress import ProgressBar
from .rank_checks import check_alike, check_ranks
from .rank_devices import check_as_many
from .rank_files import on_all
from .rank_recut import other_ranks, restore_parts
from .rank_run import resume_on_ranks
from .recorder import FILE, Recorder, writing_beside
from .written_run import carry_out


def resume(
    folder: str | Path,
    scene: Scene,
    scheme: Any = "central-difference",
    threads: int | None = None,
    arch: str = "cpu",
    progress: bool = False,
    checkpoint: float | dict[str, Any] | Checkpoint | None = 60.0,
    precision: str | None = None,
    comm: Any = None,
) -> Result:
    """Resume the run that stopped in `folder` and return its `Result`, with history and frames from its start.

    scene, scheme: the same as before; the other options of `simulate` (frames, history, pressures) are in the
    checkpoint; threads, arch, progress, checkpoint, comm: as in `simulate` (any number of threads gives the same bits);
    as many processes (`mpiexec`) as before give the same bits too, another number goes on with a warning that the last
    digits differ; checkpoint=None writes one only if a signal stops the run; precision: that of the run, which
    another one cannot continue (None: whatever it is). A damaged checkpoint is replaced by the older one, with a
    warning.

    Raises `InputError` if the scene differs, naming the difference, if there is no checkpoint, or if another
    process runs in the folder. All fields of the scene and the scheme are compared. A function of time is compared by
    its values at 4096 times over the duration, and at the times at which the run has evaluated it so far (all of them
    up to 32768 calls, then evenly thinned ones). A function that differs between these times alone, for less than
    1/4096 of the duration, goes unnoticed.
    """
    started, together = perf_counter(), team(comm)

    def check() -> tuple[Scene, Any, Checkpoint | None, Path]:
        if not isinstance(scene, Scene):
            raise InputError("scene", scene, "give the tcontact.Scene that was run")
        validate.flag("progress", progress)
        own, options = scheme_of(scheme), checked(checkpoint, folder)
        return scene.for_scheme(getattr(own, "implicit", False)), own, options, checked_folder(folder)

    with ending_all(together, BEFORE):
        scene, scheme, options, path = on_all(together, check)
        if together is not None:
            check_alike(together, scene, scheme, {"arch": arch, "checkpoint": options, "precision": precision})
            ranks = together.size
            on_all(together, lambda: check_ranks(scene, scheme, arch, ranks))
            return resume_on_ranks(together, path, scene, scheme, threads, progress, options, precision, arch)
    with pools_served(), runtime.turn, locked(path):
        every = latest(path)
        stored = every[0]
        physics = fingerprint(scene, scheme)
        compare(stored.head["physics"], physics)
        kept = stored.head.get("precision", "f64")
        if precision is not None and precision != kept:
            raise InputError("precision", precision, f"the run computes in {kept!r}; resume it so, or run again")
        check_precision(kept, scheme, arch)
        check_same(stored.head, arch)
        check_as_many(stored.ranks, 1, arch)
        check_scheme(scheme, arch)
        start = start_of(stored)
        scene = with_kept_faces(scene, start, scheme.implicit)
        planned = plan(scene)
        scheme.check(planned)
        set_precision(planned, kept)
        check_device(planned, arch)
        runtime.start(arch, threads)
        displacement, velocity = (start or start_of_scene(scene))[:2]
        names = ("physics", "history_every", "history_rows", "pressures", "fields", "keep", "chunks")
        head = {name: stored.head[name] for name in names} | {"precision": kept}
        rows = head["history_every"], head["pressures"], head["history_rows"]
        for domain in planned.domains:  # the same bits on a machine with another number of threads
            domain.chunks = head["chunks"]
        record_friction(planned, head["fields"])
        run = Run(scene, planned, scheme, displacement, velocity, *rows)
        new = contents.prints(run)
        if stored.ranks > 1:
            warnings.warn(other_ranks(stored.ranks, 1), RuntimeWarning, stacklevel=2)
        elif contents.differs(stored.head["new"], new, stored.found):
            made = f"numpy {stored.head['versions']['numpy']}, tcontact {stored.head['versions']['tcontact']}"
            text = f"prepared the scene a little differently than the run did ({made}): the last digits may differ"
            warnings.warn(f"this machine {text}", RuntimeWarning, stacklevel=2)
        with store.taken_over(stored):
            if stored.ranks > 1:
                restore_parts(run, planned, every, None)
                run.warnings.append(other_ranks(stored.ranks, 1))
            else:
                contents.restore(run, stored.found, stored.values)
        recorder = Recorder(path, scene, run.states, " + ".join(planned.terms), head["fields"], stored.head["frames"])
        head |= {"origin": stored.head["origin"], "versions": versions()}
        head |= {"contact_ranks": stored.head.get("contact_ranks"), "arch": arch}
        if options is not None:
            head |= {"origin": dict(options.origin) or head["origin"], "keep": options.keep or head["keep"]}
        keeper = Keeper(options, path, new, recorder, head, start)
        keeper.restored(stored.place)
        store.remove_later(path, stored.place)
        writing = writing_beside(path, scene, head["fields"], run.course.left + 1)
        with writing as recorder.process, ProgressBar(scene.duration, "resume", progress) as bar:
            bar.update(run.course.time)
            return carry_out(run, run.course.frames, path, recorder, keeper, bar, started)


def checked_folder(folder: Any) -> Path:
    """Check and return the folder of a run. Raises `InputError`."""
    path = validate.path("folder", folder, "give the folder of a run")
    if not validate.is_folder(path):
        raise InputError("folder", str(path), "no such folder; give the folder of a run that stopped")
    return path


def latest(folder: Path) -> list[store.Stored]:
    """Return the latest complete checkpoint whose frames are in the result file, one of every rank of the run.

    Raises `InputError` without any.
    """
    good, bad = store.read_all(folder)
    warn_of_damage(bad)
    if not good:
        raise InputError("folder", str(folder), nothing(folder, bool(bad)))
    frames = len(ResultData.open(folder / FILE))
    usable = [one for one in good if one.head["frames"] <= frames]
    if not usable:
        raise InputError("folder", str(folder), f"{FILE} holds {frames} frames, fewer than its checkpoints; run again")
    if usable[0].ranks == 1:
        return usable[:1]
    known = {0: usable}
    for rank in others(folder):
        known[rank], bad = store.read_all(place_of(folder, rank))
        warn_of_damage(bad)
    last = last_complete((rank, one.row, one.ranks) for rank, own in known.items() for one in own)
    if last is None:
        raise InputError("folder", str(folder), NOT_ON_ALL)
    return [store.at(folder, rank, last, known[rank]) for rank in range(last[1])]
