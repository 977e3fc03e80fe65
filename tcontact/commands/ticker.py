"""A line on the terminal that says what a command is doing and for how long.

A process of its own writes it: the compiler of the kernels keeps all threads of a Python process waiting for seconds.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from ..base import stages

WRITER = r"""
import os, select, signal, sys, time
signal.signal(signal.SIGINT, signal.SIG_IGN)
signal.signal(signal.SIGTERM, signal.SIG_IGN)
text, since, drawn, shown, buffer = "", time.monotonic(), time.monotonic(), False, b""
while True:
    if select.select([0], [], [], 0.25)[0]:
        piece = os.read(0, 65536)
        if not piece:
            break
        *lines, buffer = (buffer + piece).split(b"\n")
        if lines:
            text, since = lines[-1].decode(errors="replace"), time.monotonic()
            if shown and not text:
                sys.stderr.write("\r\x1b[2K")
                sys.stderr.flush()
                shown = False
    now = time.monotonic()
    passed = now - since
    if text and now - drawn >= 0.25:
        drawn = now
        sys.stderr.write("\r\x1b[2K" + text + (f", {passed:.0f} s" if passed >= 1 else "") + "\r")
        sys.stderr.flush()
        shown = True
if shown:
    sys.stderr.write("\r\x1b[2K")
    sys.stderr.flush()
"""


@contextmanager
def ticking(enabled: bool) -> Iterator[None]:
    """Show the stages that begin inside, with the seconds since they began, if standard error is a terminal."""
    if not (enabled and sys.platform != "win32" and sys.stderr is not None and sys.stderr.isatty()):
        yield
        return
    try:
        writer = subprocess.Popen([sys.executable, "-I", "-S", "-c", WRITER], stdin=subprocess.PIPE)
    except OSError:  # no process is to be had: the command works without the line
        yield
        return
    assert writer.stdin is not None
    pipe = writer.stdin

    def tell(stage: str) -> None:
        with suppress(OSError, ValueError):
            pipe.write(stage.replace("\n", " ").encode() + b"\n")
            pipe.flush()

    try:
        with stages.heard(tell):
            yield
    finally:
        with suppress(OSError):
            pipe.close()
        writer.wait()
