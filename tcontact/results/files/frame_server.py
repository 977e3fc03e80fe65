"""What the process of `frame_process.py` does: it appends frames from shared memory to a result file until it is told
to close it, or until the run is gone.
"""

from __future__ import annotations

import mmap
import os
import signal
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np

from .vtkhdf import ResultFile

Part = tuple[str, str, str, tuple[int, ...], int]  # point or cell, name, type, shape, place [bytes]


class _Server:
    """A result file and the memory of its frames; every method does what the message of its name asks for."""

    def __init__(self, memory: int) -> None:
        self._memory = memory
        self._room: mmap.mmap | None = None
        self.file: ResultFile | None = None

    def open(self, path: str, frames: int, attributes: dict[str, Any]) -> None:
        """Go on with a file behind so many frames."""
        self.file = ResultFile.reopen(Path(path), frames, attributes)

    def room(self, size: int) -> None:
        """Read frames from here on from memory of another size."""
        self._room = mmap.mmap(self._memory, os.fstat(self._memory).st_size)

    def append(self, time: float, parts: list[Part]) -> None:
        """Append a frame."""
        assert self.file is not None
        assert self._room is not None
        data: dict[str, dict[str, np.ndarray]] = {"point": {}, "cell": {}}
        for kind, name, dtype, shape, at in parts:
            count = int(np.prod(shape))
            data[kind][name] = np.frombuffer(self._room, dtype, count, at).reshape(shape)
        self.file.append(time, data["point"], data["cell"])

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


SILENT = {"open", "room"}  # messages without an answer; what fails in them is the answer to the next frame


def serve(line: int, memory: int) -> None:
    """Do what the run asks for through the line, and end with it.

    Signals that stop the run are its own matter: it then closes the line.
    """
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    server, failed = _Server(memory), None
    talk = Connection(line)
    talk.send("ready")
    try:
        while True:
            what, *arguments = talk.recv()
            if failed is None:
                try:
                    getattr(server, what)(*arguments)
                except Exception as error:
                    failed = error
            if what not in SILENT:
                _answer(talk, failed)
    except EOFError:
        pass
    finally:
        server.close()


def _answer(talk: Connection, failed: Exception | None) -> None:
    """Say what came of it; a run that is gone does not hear it, and its other frames follow."""
    try:
        talk.send(failed)
    except OSError:
        return
