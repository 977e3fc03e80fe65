"""Decide when to write a checkpoint, and write it."""

from __future__ import annotations

from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from ...results.files.checkpoint_heads import Place, place_in_run
from ..watched import Run
from . import contents, store
from .options import Checkpoint

if TYPE_CHECKING:
    from ..recorder import Recorder

SHARE = 0.01  # largest share of the wall time for checkpoints


START = "start:"

# of all bodies: displacements [m], velocities [m/s], contact faces, removals in the run before
Start = tuple[list[np.ndarray], ...]


def start_of(stored: store.Stored) -> Start | None:
    """Remove the start from the arrays of a checkpoint and return it; None if it is that of the scene."""
    parts: Start = ([], [], [], [])
    for name in [name for name in stored.found if name.startswith(START)]:
        parts[int(name[len(START)])].append(stored.found.pop(name))
    return tuple(part for part in parts if part) or None


class Keeper:
    """Writes the checkpoints of one run into its folder.

    options: when to write, None = only before a run stops for a signal; new: fingerprints of the arrays of the new run;
    head: data for `resume`: fingerprint, options, origin of the run; start: displacements [m], velocities [m/s],
    contact faces and the removal before, if they are not those of the scene.
    """

    def __init__(
        self,
        options: Checkpoint | None,
        folder: Path,
        new: contents.Prints,
        recorder: Recorder,
        head: dict[str, Any],
        start: Start | None = None,
    ) -> None:
        self.every_seconds = None if options is None else options.every_seconds
        self.every_steps = None if options is None else options.every_steps
        self.folder, self.recorder, self.head, self.new = folder, recorder, head, new
        self.keep = bool(head["keep"])
        self._start = (
            {} if start is None else {f"{START}{k}/{i}": a for k, own in enumerate(start) for i, a in enumerate(own)}
        )
        self.written = 0  # complete ones
        self._last: Place | None = None  # the last complete one
        self._warned = False
        self._next_row, self._next_time = self.every_steps or 0, self._wait(perf_counter(), 0.0)

    def due(self, row: int, stopping: bool, ended: bool) -> bool:
        """Return whether a checkpoint is due before the step that starts at `row`.

        stopping: a signal stops the run; ended: the run has ended.
        """
        if stopping or (ended and self.keep):
            return True
        if self.every_steps is not None and row >= self._next_row:
            return row > 0
        return self.every_seconds is not None and perf_counter() >= self._next_time

    def restored(self, place: Place) -> None:
        """Note that the run continues from the checkpoint at that place, which stays until the next one is complete."""
        self._last = place
        if self.every_steps is not None:
            self._next_row = place[0] + self.every_steps

    def failure(self, own: str) -> str:
        """Return where the present checkpoint could not be written, "" where it is complete; own: in this process."""
        return own

    def save(self, run: Run, row: int) -> None:
        """Write a checkpoint; if that fails, warn and let the run continue.

        The last complete one stays until the next one is complete; the next one goes over what a failure has left.
        """
        began = perf_counter()
        found, values = contents.collect(run, self.new)
        head = self.head | {"row": row, "frames": len(self.recorder.file), "new": self.new}
        failure = ""
        try:
            self.recorder.file.sync()
            store.write(self.folder, head, values, found | self._start, self._last)
        except OSError as error:
            failure = f"{self.folder} ({error.strerror})"
        failure = self.failure(failure)
        if not failure:
            self.written += 1
            self._last = place_in_run(head)
        elif not self._warned:
            self._warned = True
            run.warn(f"no checkpoint could be written into {failure}; free some space there")
        ended = perf_counter()
        self._next_time = self._wait(ended, ended - began)
        if self.every_steps is not None:
            self._next_row = row + self.every_steps

    def _wait(self, now: float, cost: float) -> float:
        """Return the time of the next checkpoint; cost [s]: wall time of the last one."""
        return now + max(self.every_seconds or 0.0, cost / SHARE)
