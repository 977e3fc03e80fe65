"""Write frames in a process of its own, so that a run goes on while they are put together, checked and stored.

A thread would not do: Taichi holds Python's global lock as long as a kernel runs. The run puts the arrays of a frame
into one of a few places of shared memory and sends what they are; the process, which imports neither Taichi nor the
rest of the program (`frame_server.py`), makes the fields of them, appends them to the result file and says so. A
process that ends, however it does, leaves the frames it was sent: the other one reads them to their end, stores them
and goes.
"""

from __future__ import annotations

import errno
import mmap
import os
import socket
import subprocess
import sys
from collections.abc import Mapping, Sequence
from contextlib import suppress
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np

from .late_fields import LateField, Part
from .vtkhdf import ResultFile

PLACES = 4  # frames in shared memory: some are written together, the next one is made
LARGE = 2**26  # bytes of a frame above which there are two
LEAST = 10**8  # bytes of all frames from which a process is started: 0.4 s of writing, more than its start costs
FEWEST = 8  # frames
ALIGNMENT = 64  # bytes, of the arrays of a frame
START = (  # the package is found without being run: that would import all of the program
    "import sys, types\n"
    "place, sys.path[:] = sys.argv[3], sys.argv[4:]\n"
    "package = sys.modules['tcontact'] = types.ModuleType('tcontact')\n"
    "package.__path__ = [place]\n"
    "from tcontact.results.files.frame_server import serve\n"
    "serve(int(sys.argv[1]), int(sys.argv[2]))\n"
)
ENDED = "the process that writes it has ended"
Fields = Mapping[str, np.ndarray]
LateFields = Mapping[str, np.ndarray | LateField]


class FrameProcess:
    """A result file that another process writes; used like `ResultFile`, whose file it takes over.

    Errors come with a later call: `append`, `wait`, `sync`, `write_history`, `write_attributes`, `close` raise the
    `OSError` of the first frame that could not be written. len(): frames that were sent; kept: those on disk.
    """

    def __init__(self, line: Connection, memory: int, process: subprocess.Popen[bytes]) -> None:
        """Use `start` instead."""
        self._line, self._memory, self._process = line, memory, process
        self._map: mmap.mmap | None = None
        self._room = self._sent = self._first = 0
        self._places = PLACES
        self._fixed: dict[int, tuple[int, np.ndarray]] = {}
        self.kept = 0
        self._ready = self._open = False
        self._failed: OSError | None = None

    @classmethod
    def start(cls, size: int, frames: int, inherited: Sequence[int] = ()) -> FrameProcess | None:
        """Start the process for so many frames of `size` [bytes]; None where it would not pay or cannot be started.

        inherited: files that stay open, and locked, as long as it writes.
        """
        if frames < FEWEST or size * frames < LEAST or _processors() < 2 or not sys.executable:
            return None
        try:
            memory = os.memfd_create("frames")
        except (AttributeError, OSError):  # not Linux
            return None
        ours, theirs = socket.socketpair()
        package = Path(__file__).resolve().parents[2]
        options = ["-I", *(["-B"] if sys.dont_write_bytecode else []), "-c", START]
        numbers = [str(theirs.fileno()), str(memory)]
        try:
            process = subprocess.Popen(
                [sys.executable, *options, *numbers, str(package), *sys.path],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                pass_fds=(theirs.fileno(), memory, *inherited),
                start_new_session=True,  # Ctrl-C reaches the run alone, which then says when to end
            )
        except (OSError, ValueError):
            os.close(memory)
            ours.close()
            return None
        finally:
            theirs.close()
        return cls(Connection(ours.detach()), memory, process)

    def ready(self) -> bool:
        """Return whether the process has started; until then the run writes by itself."""
        if not self._ready and self._memory >= 0 and self._line.poll():
            try:
                self._ready = self._line.recv() == "ready"
            except (OSError, EOFError):  # it could not start
                self.close()
        return self._ready

    def take_over(self, file: ResultFile, path: Path, attributes: Mapping[str, Any]) -> None:
        """Close a file and let the process, which is ready, go on with it. Raises `OSError`."""
        self._first = self.kept = self._sent = len(file)
        file.close()
        self._send("open", str(path), len(file), dict(attributes))
        self._open = True

    def append(self, time: float, point_data: LateFields | None = None, cell_data: LateFields | None = None) -> None:
        """Add a frame, see `ResultFile.append`; the arrays may change at once, except those that a part calls fixed."""
        fields = {("point", name): _parts(field) for name, field in (point_data or {}).items()}
        fields |= {("cell", name): _parts(field) for name, field in (cell_data or {}).items()}
        size = sum(_whole(array.nbytes) for parts in fields.values() for part in parts for array in part.now)
        self._make_room(size)
        self._listen(self._places - 1)
        at, sent = self._room * ((self._sent - self._first) % self._places), []
        for key, parts in fields.items():
            described = []
            for part in parts:
                arrays = []
                for array in part.now:
                    there = np.frombuffer(self._map, array.dtype, array.size, at).reshape(array.shape)  # type: ignore[arg-type]
                    there[...] = array
                    arrays.append((array.dtype.str, array.shape, at))
                    at += _whole(array.nbytes)
                described.append((part.rule, arrays, [self._known(array) for array in part.fixed], part.numbers))
            sent.append((*key, described))
        self._send("append", float(time), sent)
        self._sent += 1

    def _make_room(self, size: int) -> None:
        """Make the places in shared memory larger if a frame of so many bytes needs it."""
        if self._map is not None and size <= self._room:
            return
        self._listen(0)
        self._room = size
        self._places = PLACES if size <= LARGE else 2
        os.ftruncate(self._memory, self._places * self._room)
        self._map = mmap.mmap(self._memory, self._places * self._room)
        self._first = self._sent
        self._send("room", self._room)

    def _known(self, array: np.ndarray) -> int:
        """Return the number by which the process knows an array that stays as it is, and send it once."""
        if id(array) not in self._fixed:
            self._fixed[id(array)] = len(self._fixed), array
            self._send("fixed", array)
        return self._fixed[id(array)][0]

    def wait(self) -> None:
        """Wait until the process has written every frame."""
        self._listen(0)

    def sync(self) -> None:
        """Wait until the device holds all that was written so far."""
        self._ask("sync")

    def write_history(self, history: Fields) -> None:
        """Store per-step arrays, see `ResultFile`."""
        self._ask("history", {name: np.asarray(array) for name, array in history.items()})

    def write_attributes(self, attributes: Mapping[str, Any]) -> None:
        """Store attributes, see `ResultFile`."""
        self._ask("attributes", dict(attributes))

    def close(self) -> None:
        """Let the process close the file and end; calling it again is harmless."""
        if self._memory < 0:
            return
        try:
            if self._open and self._failed is None:
                self._ask("close")
        finally:
            self._end()

    def __len__(self) -> int:
        return self._sent

    def _ask(self, what: str, *arguments: Any) -> None:
        """Let the process do something behind the frames, and wait for it."""
        self._listen(0)
        self._send(what, *arguments)
        self._answer()

    def _listen(self, most: int) -> None:
        """Read what the process says, until at most so many frames are unwritten. Raises `OSError`."""
        while self._failed is None and self._sent > self.kept and (self._sent - self.kept > most or self._heard()):
            self._answer()
            self.kept += 1
        if self._failed is not None:
            raise self._failed

    def _heard(self) -> bool:
        """Return whether there is an answer, or the line is cut."""
        try:
            return self._line.poll()
        except OSError:
            return True

    def _answer(self) -> None:
        try:
            found = self._line.recv()
        except (OSError, EOFError) as error:
            self._failed = OSError(errno.EIO, ENDED)
            raise self._failed from error
        except BaseException:  # Ctrl-C amid an answer: the next one would begin in its middle
            self._failed = OSError(errno.EINTR, ENDED)
            raise
        if found is not None:
            self._failed = found if isinstance(found, OSError) else None
            raise found

    def _send(self, *message: Any) -> None:
        try:
            self._line.send(message)
        except (BrokenPipeError, ConnectionError) as error:
            with suppress(EOFError):
                self._answer()  # why it ended
            self._failed = OSError(errno.EIO, ENDED)
            raise self._failed from error

    def _end(self) -> None:
        """Let the process end: it still writes the frames that it was sent."""
        self._line.close()
        if self._memory >= 0:
            os.close(self._memory)
            self._memory, self._map = -1, None
        if not self._open:
            self._process.kill()
        self._process.wait()


def _parts(field: np.ndarray | LateField) -> tuple[Part, ...]:
    """Return the parts of a field; a whole one is a part as it is."""
    return field.parts if isinstance(field, LateField) else (Part("as they are", (np.asarray(field),)),)


def _processors() -> int:
    """Return the number of processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _whole(size: int) -> int:
    """Return the bytes that an array of so many bytes takes in shared memory."""
    return -(-size // ALIGNMENT) * ALIGNMENT
