"""What the process of `frame_process.py` does: it appends frames from shared memory to a result file until it is told
to close it, or until the run is gone.
"""

from __future__ import annotations

import mmap
import os
import signal
from collections.abc import Callable
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np

from .late_fields import LateField, Part
from .vtkhdf import ResultFile

Array = tuple[str, tuple[int, ...], int]  # type, shape, place [bytes]
Sent = tuple[str, list[Array], list[int], tuple[float, ...]]  # rule, arrays of now, numbers of fixed ones, numbers


class _Server:
    """A result file and the memory of its frames; every method does what the message of its name asks for."""

    def __init__(self, memory: int) -> None:
        self._memory = memory
        self._room: mmap.mmap | None = None
        self._fixed: list[np.ndarray] = []
        self.file: ResultFile | None = None

    def open(self, path: str, frames: int, attributes: dict[str, Any]) -> None:
        """Go on with a file behind so many frames."""
        self.file = ResultFile.reopen(Path(path), frames, attributes)

    def room(self, size: int) -> None:
        """Read frames from here on from memory of another size."""
        self._room = mmap.mmap(self._memory, os.fstat(self._memory).st_size)

    def fixed(self, array: np.ndarray) -> None:
        """Keep an array that parts of fields name by its number."""
        self._fixed.append(array)

    def append(self, time: float, fields: list[tuple[str, str, list[Sent]]]) -> None:
        """Append a frame, which `commit` brings to disk."""
        assert self.file is not None
        data: dict[str, dict[str, np.ndarray]] = {"point": {}, "cell": {}}
        for kind, name, parts in fields:
            data[kind][name] = LateField(tuple(self._part(*part) for part in parts)).values()
        self.file.append(time, data["point"], data["cell"], commit=False)

    def commit(self) -> None:
        """Bring all frames to disk."""
        assert self.file is not None
        self.file.commit()

    def _part(self, rule: str, now: list[Array], fixed: list[int], numbers: tuple[float, ...]) -> Part:
        """Return a part of a field."""
        assert self._room is not None
        found = []
        for dtype, shape, at in now:
            found.append(np.frombuffer(self._room, dtype, int(np.prod(shape)), at).reshape(shape))
        return Part(rule, tuple(found), tuple(self._fixed[number] for number in fixed), numbers)

    def sync(self) -> None:
        """Wait for the device."""
        assert self.file is not None
        self.file.sync()

    def history(self, history: dict[str, np.ndarray]) -> None:
        """Store the history."""
        assert self.file is not None
        self.file.write_history(history)

    def attributes(self, attributes: dict[str, Any]) -> None:
        """Store the attributes."""
        assert self.file is not None
        self.file.write_attributes(attributes)

    def close(self) -> None:
        """Close the file."""
        if self.file is not None:
            self.file.close()


TOGETHER = 3  # frames at most that are brought to disk at once
SILENT = {"open", "room", "fixed"}  # messages without an answer; what fails in them is the answer to the next frame


def serve(line: int, memory: int) -> None:
    """Do what the run asks for through the line, and end with it.

    Signals that stop the run are its own matter: it then closes the line.
    """
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    server, failed = _Server(memory), None
    talk = Connection(line)
    talk.send("ready")
    waiting = 0  # frames that are not on the disk: those that come while one is written go there together
    try:
        while True:
            if waiting and (failed is not None or waiting == TOGETHER or not talk.poll()):
                failed = failed or _tried(server.commit)
                for _ in range(waiting):
                    _answer(talk, failed)
                waiting = 0
            what, *arguments = talk.recv()
            failed = failed or _tried(getattr(server, what), *arguments)
            if what == "append":
                waiting += 1
            elif what not in SILENT:
                _answer(talk, failed)
    except EOFError:
        pass
    finally:
        server.close()


def _tried(what: Callable[..., None], *arguments: Any) -> Exception | None:
    """Do something; return what failed in it, or None."""
    try:
        what(*arguments)
    except Exception as error:
        return error
    return None


def _answer(talk: Connection, failed: Exception | None) -> None:
    """Say what came of it; a run that is gone does not hear it, and its other frames follow."""
    try:
        talk.send(failed)
    except OSError:
        return
