"""Standard streams that may be closed, full or read by nobody: a command does its work all the same.

A reader that has gone (`tcontact list | head -1`) is nothing to speak of. Anything else that keeps the words of a
command from being written (a full disk) is said on standard error, and the exit code is 1 instead of 0. Standard error
itself goes silent where it cannot be written, as that of a terminal that was closed during a run.
"""

from __future__ import annotations

import errno
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any, TextIO

GONE = (errno.EPIPE, errno.EBADF)


class Output:
    """A text stream that goes silent when it cannot be written; error: the reason, None if its reader has gone.

    Letters that its encoding lacks become question marks.
    """

    def __init__(self, stream: TextIO) -> None:
        self.stream, self.silent = stream, False
        self.error: OSError | None = None

    def write(self, text: str) -> int:
        """Write the text, or nothing once the stream is silent."""
        if not self.silent:
            try:
                try:
                    return self.stream.write(text)
                except UnicodeEncodeError as error:  # a terminal or pipe without these letters
                    return self.stream.write(text.encode(error.encoding, "replace").decode(error.encoding))
            except OSError as error:
                self._stop(error)
        return len(text)

    def flush(self) -> None:
        """Bring what was written to the device."""
        if not self.silent:
            try:
                self.stream.flush()
            except OSError as error:
                self._stop(error)

    def _stop(self, error: OSError) -> None:
        self.silent = True
        self.error = None if error.errno in GONE else error
        with suppress(OSError, ValueError):  # the rest of the buffer goes there when the process ends
            os.dup2(os.open(os.devnull, os.O_WRONLY), self.stream.fileno())

    def __getattr__(self, name: str) -> Any:
        return getattr(self.stream, name)


@contextmanager
def safe_output() -> Iterator[Output]:
    """Make both standard streams an `Output` in the block, and yield the one for standard output.

    Closed standard streams are opened to nowhere for good.

    Else the next file that is opened would get the number of a closed one, and whatever is printed would go there.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # it takes the lowest free number
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115 - for as long as the process lives
    before = sys.stdout, sys.stderr
    output, errors = (Output(stream) for stream in before)
    sys.stdout, sys.stderr = output, errors
    try:
        yield output
    finally:
        output.flush()
        errors.flush()
        sys.stdout, sys.stderr = before
