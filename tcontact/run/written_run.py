"""Runs that write into a folder: the loop, then result file, history and summary; at last checkpoints go."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

from ..base.errors import OutputError
from ..results.report import run_attributes, write_history, write_json
from ..results.result import Result
from .checkpoint import store
from .checkpoint.keeper import Keeper
from .loop import Run
from .progress import ProgressBar
from .recorder import FILE, Recorder, unwritten


def carry_out(
    run: Run,
    frames: int,
    folder: Path,
    recorder: Recorder,
    keeper: Keeper | None,
    bar: ProgressBar,
    started: float,
    on_writer: Callable[[Callable[[], None]], Any] = lambda write: write(),
    **attributes: Any,
) -> Result:
    """Run, write result file, history and summary to the folder, and remove checkpoints without further use.

    started: `perf_counter` at the start [s]; on_writer: calls a function on the rank that writes, and raises its error
    on all of them; attributes: further ones of the summary. Raises `OutputError`, whose `result` is that of the run;
    where history.csv and summary.json still find room, they have its rows up to there. Raises a warning that the user
    has turned into an error when everything is written.
    """

    def write(result: Result, about: dict[str, Any]) -> None:
        try:
            write_history(folder / "history.csv", result.history)
            write_json(folder / "summary.json", about)
        except OSError as error:
            raise unwritten(folder, "history.csv or summary.json", "all frames are", error) from error

    result: Result | None = None
    try:
        try:
            result = run.go(frames, recorder, bar, started, keeper)
            vars(result)["file"] = folder / FILE  # results are frozen, and those of other ranks have not all fields
            about = run_attributes(result) | attributes
            recorder.close(result.history, about)
        finally:
            recorder.abandon()
    except OutputError as error:
        error.result = result if error.result is None else error.result
        if error.result is not None:
            with suppress(OutputError):
                on_writer(partial(write, error.result, run_attributes(error.result) | attributes))
                error.args = (f"{error}; history.csv has the rows up to there",)
        raise
    ended = result

    def finish() -> None:
        write(ended, about)
        if ended.reason != "interrupted" and not (keeper is not None and keeper.keep):
            store.remove(folder)

    try:
        on_writer(finish)
    except OutputError as error:
        error.result = result
        raise
    run.raise_refused(result)
    return result
