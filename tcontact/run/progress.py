"""A progress bar with the remaining time, on a terminal only."""

from __future__ import annotations

import sys
from contextlib import suppress
from types import TracebackType
from typing import TYPE_CHECKING

from ..base import stages

if TYPE_CHECKING:
    from rich.progress import Progress


class ProgressBar:
    """Shows the progress of a run. Use as a context manager; `update` is cheap, the bar is drawn ten times a second.

    duration: simulated time at the end [s]; label: words before the bar; enabled: False draws nothing. Nothing is drawn
    unless standard error is a terminal.
    """

    def __init__(self, duration: float, label: str = "", enabled: bool = True) -> None:
        self._duration = duration
        self._label = label
        self._enabled = enabled and sys.stderr is not None and sys.stderr.isatty()
        self._bar: Progress | None = None
        self._task = None

    def __enter__(self) -> ProgressBar:
        return self

    def _start(self) -> None:
        """Draw the bar: at the first step, when everything is compiled."""
        if self._enabled:
            stages.say("")
            from rich.console import Console
            from rich.progress import (
                BarColumn,
                Progress,
                TaskProgressColumn,
                TextColumn,
                TimeElapsedColumn,
                TimeRemainingColumn,
            )

            columns = (
                TextColumn("{task.description}"),
                BarColumn(),
                TaskProgressColumn(),
                TimeElapsedColumn(),
                TextColumn("left"),
                TimeRemainingColumn(),
                TextColumn("{task.fields[note]}"),
            )
            self._bar = Progress(*columns, console=Console(stderr=True), transient=True, refresh_per_second=10)
            self._task = self._bar.add_task(self._label, total=self._duration, note="")  # type: ignore[assignment]
            self._bar.start()

    def update(self, time: float, note: str = "") -> None:
        """Move to the simulated time [s]; note: a few words after the bar."""
        if self._bar is None and self._enabled and time > 0.0:
            self._start()
        if self._bar is not None and self._task is not None:
            self._bar.update(self._task, completed=min(time, self._duration), note=note)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._bar is not None:
            with suppress(OSError):  # the terminal was closed
                self._bar.stop()
            self._bar = None
            self._enabled = False
