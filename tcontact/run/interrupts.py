"""Turn Ctrl-C, SIGTERM and SIGHUP into a flag, so that a run stops between two steps with its results.

Batch systems send SIGTERM some seconds before they kill; SIGHUP comes where a terminal or a connection is closed, often
twice (by the shell and by the system), and is not there on every platform. If the program handles or ignores one of the
two itself, as `nohup` does with SIGHUP, that signal does not stop a run. Signals are watched in the main thread only. A
worker of a pool ends after a run that one of the two has stopped (`device/workers.py`).
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from ..device import workers

HANGUP = getattr(signal, "SIGHUP", None)
ENDINGS = tuple(number for number in (signal.SIGTERM, HANGUP) if number is not None)
NAMES = {signal.SIGINT: "the user (Ctrl-C)"} | {number: f"the signal {number.name}" for number in ENDINGS}


_terminated = False  # by SIGTERM or SIGHUP, a run of this process


class Terminated(KeyboardInterrupt):
    """SIGTERM or SIGHUP has come outside of the steps of a run, for the command line; the text is its name."""


@contextmanager
def interrupts() -> Iterator[Callable[[], str]]:
    """Yield a function that returns the name of the signal that stops the run, or "".

    The first signal is stored; the second one has its usual effect at once, but a second SIGHUP has none.
    """
    sender = [""]
    if threading.current_thread() is not threading.main_thread():
        yield lambda: ""
        return
    before = {number: handler for number in NAMES if _ours(number, handler := signal.getsignal(number))}

    def remember(number: int, _frame: Any) -> None:
        global _terminated
        sender[0] = NAMES[signal.Signals(number)]
        _terminated |= number in ENDINGS
        for known, handler in before.items():
            signal.signal(known, signal.SIG_DFL if handler is _raise else handler)
        _ignore_hangups(number)

    for number in before:
        signal.signal(number, remember)
    try:
        yield lambda: sender[0]
    finally:
        for number, handler in before.items():
            closed = number == HANGUP and handler is _raise and sender[0] == NAMES[number]
            signal.signal(number, signal.SIG_IGN if closed else handler)  # a command goes on without its terminal


@contextmanager
def pools_served() -> Iterator[None]:
    """Let a worker of a pool end with the block, once all is stored, if SIGTERM or SIGHUP has stopped a run inside."""
    try:
        yield
    finally:
        if _terminated and workers.in_pool():
            workers.end()


@contextmanager
def terminations() -> Iterator[None]:
    """Make SIGTERM and SIGHUP raise `Terminated` in the block, so that a command can clean up."""
    main = threading.current_thread() is threading.main_thread()
    ours = [number for number in ENDINGS if main and signal.getsignal(number) is signal.SIG_DFL]
    for number in ours:
        signal.signal(number, _raise)
    try:
        yield
    finally:
        for number in ours:
            signal.signal(number, signal.SIG_DFL)


def _raise(number: int, _frame: Any) -> None:
    _ignore_hangups(number)
    raise Terminated(signal.Signals(number).name)


def _ignore_hangups(number: int) -> None:
    """Ignore further ones after a SIGHUP: a terminal that closes may send several, and only once it is gone."""
    if number == HANGUP:
        signal.signal(number, signal.SIG_IGN)


def _ours(number: int, handler: Any) -> bool:
    """Return whether to handle a signal: Ctrl-C, unless handled outside of Python; others, unless handled at all."""
    if number == signal.SIGINT:
        return handler is not None
    return handler in (signal.SIG_DFL, _raise, workers.end)
