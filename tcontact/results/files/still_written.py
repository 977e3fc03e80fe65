"""Read a file that a run may be writing: what does not go together is read again, unless the file stays as it is.

A commit changes the file in place within some milliseconds. A reader that has it open meanwhile sees parts of both
states, which checksums and lengths tell.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from ...base.errors import InputError
from ...device.atomic_file import undo_path

Value = TypeVar("Value")
TRIES, PAUSE = 20, 0.02  # pause [s]: longer than the clock of a file system ticks


def settled(path: Path, read: Callable[[], Value], failures: tuple[type[Exception], ...]) -> Value:
    """Return what a function reads from a file.

    failures: its errors where something does not go together; the last one is raised if the file has not changed since
    the try before, `InputError` if it keeps changing.
    """
    known = None
    for _ in range(TRIES):
        now = _state(path)
        try:
            return read()
        except failures:
            if now == known or not os.path.isfile(path):  # unlike a path's method it takes any name
                raise
        known = now
        time.sleep(PAUSE)
    raise InputError("path", str(path), "a run is writing it and has changed it at each try; read it again")


def _state(path: Path) -> tuple[Any, ...]:
    """Return what tells that a file has been written: sizes and times of it and of its undo file."""
    found: list[Any] = []
    for place in (lambda: path, lambda: undo_path(path)):
        try:
            about = place().stat()
            found.append((about.st_size, about.st_mtime_ns, about.st_ino))
        except (OSError, ValueError):  # not there, or no name of a file
            found.append(None)
    return tuple(found)
