"""Turn Ctrl-C and SIGTERM into a flag, so that a run stops between two steps with its results.

Batch systems send SIGTERM some seconds before they kill. If the program handles or ignores SIGTERM itself, that signal
does not stop a run. Signals are watched in the main thread only. A worker of a pool ends after a run that SIGTERM has
stopped (`device/workers.py`).
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from ..device import workers

NAMES = {signal.SIGINT: "the user (Ctrl-C)", signal.SIGTERM: "the signal SIGTERM"}


_terminated = False  # by SIGTERM, a run of this process


class Terminated(KeyboardInterrupt):
    """SIGTERM has come outside of the steps of a run, for the command line."""


@contextmanager
def interrupts() -> Iterator[Callable[[], str]]:
    """Yield a function that returns the name of the signal that stops the run, or "".

    The first Ctrl-C or SIGTERM is stored; the second one has its usual effect at once.
    """
    sender = [""]
    if threading.current_thread() is not threading.main_thread():
        yield lambda: ""
        return
    before = {number: handler for number in NAMES if _ours(number, handler := signal.getsignal(number))}

    def remember(number: int, _frame: Any) -> None:
        global _terminated
        sender[0] = NAMES[signal.Signals(number)]
        _terminated |= number == signal.SIGTERM
        for known, handler in before.items():
            signal.signal(known, signal.SIG_DFL if handler is _raise else handler)

    for number in before:
        signal.signal(number, remember)
    try:
        yield lambda: sender[0]
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def pools_served() -> Iterator[None]:
    """Let a worker of a pool end with the block, once all is stored, if SIGTERM has stopped a run inside."""
    try:
        yield
    finally:
        if _terminated and workers.in_pool():
            workers.end()


@contextmanager
def terminations() -> Iterator[None]:
    """Make SIGTERM raise `Terminated` in the block, so that a command can clean up."""
    main = threading.current_thread() is threading.main_thread()
    if not main or signal.getsignal(signal.SIGTERM) is not signal.SIG_DFL:
        yield
        return
    signal.signal(signal.SIGTERM, _raise)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_DFL)


def _raise(_number: int, _frame: Any) -> None:
    raise Terminated


def _ours(number: int, handler: Any) -> bool:
    """Return whether to handle a signal: Ctrl-C, unless handled outside of Python; SIGTERM, unless handled at all."""
    if number == signal.SIGINT:
        return handler is not None
    return handler in (signal.SIG_DFL, _raise, workers.end)
