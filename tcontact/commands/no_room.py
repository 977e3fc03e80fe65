"""What is said where the disk does not take what is drawn of a run that has ended, and what makes that good."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ..base.errors import InputError, OutputError
from ..results.files.checkpoint_heads import goes_on
from ..results.stored import read_summary


@contextmanager
def kept_all_the_same(out: Path, remedy: Callable[[], str]) -> Iterator[None]:
    """Raise `OutputError` with the remedy where the disk does not take what the block draws of a run in `out`."""
    try:
        yield
    except (OSError, InputError) as error:
        cause = error if isinstance(error, OSError) else error.__cause__
        if not isinstance(cause, OSError) or isinstance(error, OutputError):
            raise
        text = f"its summary, curves or pictures cannot be written ({cause.strerror or cause}); the run has ended and"
        raise OutputError(f"{out}: {text} is kept; make room, {remedy()}") from error


def remedy_of_run(out: Path, origin: Mapping[str, Any], frames: bool) -> str:
    """Return what writes and draws all that a run lacks; frames: whether it has pictures of frames.

    `render` draws by what summary.json says of the run; where that was not written, its checks are lost too.
    """
    if goes_on(out):
        go_on = f"then `tcontact resume {out}`"
    elif read_summary(out).get("origin") == origin:
        pictures = f" and `tcontact render {out}`" if frames else ""
        go_on = f"then `tcontact render {out} --plots`{pictures}"
    else:
        return "then run again with --force: its checks are not written"
    return go_on + ("; the comparison has to be run again, with --force" if origin.get("label") else "")


def remedy_of_comparison(out: Path) -> str:
    """Return what draws the runs of a comparison side by side."""
    if "runs" in read_summary(out):
        return f"then `tcontact render {out} --plots`"
    return "then run the comparison again, with --force"
