"""Checkpoints of a run on several ranks, one of each, and frames of one that other ranks have begun.

A checkpoint is a file of every rank, those of the first one in the folder of the run, those of the others below it in
`checkpoint-ranks`. All are of the same row: `latest_of_all` finds the last one that every rank has whole.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np

from ..base.errors import InputError, OutputError
from ..device.team import Team
from ..results.files.checkpoint_heads import last_complete, others, place_of
from ..results.files.vtkhdf_reader import glance
from .checkpoint import store
from .checkpoint.keeper import Keeper
from .no_checkpoint import NOT_ON_ALL, nothing, warn_of_damage
from .rank_snapshot import WholeSnapshot
from .recorder import FILE, Recorder
from .snapshot import Snapshot

Value = TypeVar("Value")


class RankRecorder(Recorder):
    """The recorder of the first rank, which collects the fields and writes them; whole: collects the state of bodies.

    For runs that go on from other numbers of ranks; else every rank writes its part (part_recorder.py).
    """

    team: Team
    whole: Callable[[Snapshot], WholeSnapshot | None]

    def prepare(self) -> None:
        """Prepare for the fields of the frames, before the first one."""
        self.team.lead.alone(super().prepare)

    def frame(self, time: float, snapshot: Snapshot) -> None:
        """Append the state at `time` [s]. Raises `OutputError` on all ranks."""
        whole: Any = self.whole(snapshot)
        self.team.lead.alone(lambda: super(RankRecorder, self).frame(time, whole))

    def settle(self) -> None:
        """Wait until every frame is in the file. Raises `OutputError` on all ranks."""
        on_all(self.team, super().settle)

    def close(self, history: dict[str, np.ndarray], attributes: dict[str, Any]) -> None:
        """Store the history and the scalars of the run, and close the file. Raises `OutputError` on all ranks."""
        on_all(self.team, lambda: super(RankRecorder, self).close(history, attributes))


class NoFile:
    """The result file of the ranks that write none; it counts the frames, `count` of them at the start."""

    def __init__(self, count: int) -> None:
        self.count = count

    def __len__(self) -> int:
        return self.count

    def append(self) -> None:
        """Count a frame."""
        self.count += 1

    def sync(self) -> None:
        """Do nothing."""


class SilentRecorder(RankRecorder):
    """The recorder of a rank that writes nothing, while the first one does."""

    def __init__(self, *given: Any) -> None:
        self.file: Any = NoFile(given[-1] or 0)

    def prepare(self) -> None:
        """Follow the first rank."""
        self.team.lead.alone(lambda: None)

    def frame(self, time: float, snapshot: Snapshot) -> None:
        """Follow the first rank, and count the frame."""
        self.whole(snapshot)
        self.prepare()
        self.file.append()

    def settle(self) -> None:
        """Follow the first rank."""
        self.team.agree(None)

    def close(self, history: dict[str, np.ndarray], attributes: dict[str, Any]) -> None:
        """Follow the first rank."""
        self.team.agree(None)

    def abandon(self) -> None:
        """Do nothing."""


class RankKeeper(Keeper):
    """The checkpoints of a rank; the first one decides when all write theirs."""

    team: Team

    def due(self, row: int, stopping: bool, ended: bool) -> bool:
        """Return whether a checkpoint is due on all ranks before the step that starts at `row`."""
        return self.team.from_first(super().due(row, stopping, ended))

    def failure(self, own: str) -> str:
        """Return where the lowest rank that fails could not write its file, "" where all have; all ranks call it."""
        return self.team.first_of(f"{own} on rank {self.team.rank}" if own else None) or ""


def on_all(team: Team | None, act: Callable[[], Value]) -> Value:
    """Run a function on every rank, or the only one (None); return what it gives there.

    Raises the `InputError` or `OutputError` of any rank on all of them, and a warning that the user has made an error:
    one that a rank raises alone, and that a script catches, would leave the others waiting for it.
    """
    if team is None:
        return act()
    error: Exception | None = None
    found: Any = None
    try:
        found = act()
    except (InputError, OutputError, Warning) as own:
        error = own
    team.agree(error)
    return cast(Value, found)


def on_first(team: Team, act: Callable[[], Any]) -> Any:
    """Run a function on the first rank; return on all ranks what it gives, or raise its error or warning of a user.

    Such an error is an `InputError`, an `OutputError`, or a warning that the user has made one. Unlike `Lead.decide` it
    calls no collective methods.
    """
    error: Exception | None = None
    found = None
    if team.leads:
        try:
            found = act()
        except (InputError, OutputError, Warning) as own:
            error = own
    team.agree(error)
    return team.from_first(found)


def latest_of_all(folder: Path, team: Team) -> list[store.Stored]:
    """Return the last checkpoint that all ranks of its run have written, on all ranks.

    That of this rank where as many ranks had it, else those of all of them. Raises `InputError` on all ranks.
    """
    numbers = [0, *others(folder)]
    error: InputError | None = None
    mine: dict[int, list[store.Stored]] = {}
    damaged: list[Path] = []
    try:
        for one in numbers[team.rank :: team.size]:
            mine[one], bad = store.read_all(place_of(folder, one))
            damaged += bad
    except InputError as found:
        error = found
    team.agree(error)
    bad = sorted(path for part in team.comm.allgather(damaged) for path in part)
    on_first(team, lambda: warn_of_damage(bad))
    if not team.any(any(mine.values())):
        raise InputError("folder", str(folder), on_first(team, lambda: nothing(folder, bool(bad))))
    frames = on_first(team, lambda: len(glance(folder / FILE)[0]) if (folder / FILE).exists() else 0)
    rows = [(rank, one.row, one.ranks) for rank, own in mine.items() for one in own if one.head["frames"] <= frames]
    last = last_complete(row for part in team.comm.allgather(rows) for row in part)
    if last is None:
        raise InputError("folder", str(folder), NOT_ON_ALL)
    wanted = [team.rank] if last[1] == team.size else range(last[1])
    return [store.at(folder, rank, last, mine.get(rank)) for rank in wanted]
