"""Ctrl-C and SIGTERM as a flag, so that a run stops between two steps with everything kept.

Batch systems send SIGTERM some seconds before they kill. A program that handles or ignores SIGTERM itself keeps its
way: then that signal does not stop a run. In other threads than the main one no signal is watched.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

NAMES = {signal.SIGINT: "the user (Ctrl-C)", signal.SIGTERM: "the signal SIGTERM"}


class Terminated(KeyboardInterrupt):
    """SIGTERM outside of the steps of a run, for the command line."""


@contextmanager
def interrupts() -> Iterator[Callable[[], str]]:
    """Gives a function that says who wants the run to stop, "" if nobody does.

    The first Ctrl-C or SIGTERM is remembered; the second one has its usual effect at once.
    """
    sender = [""]
    if threading.current_thread() is not threading.main_thread():
        yield lambda: ""
        return
    before = {number: handler for number in NAMES if _ours(number, handler := signal.getsignal(number))}

    def remember(number: int, _frame: Any) -> None:
        sender[0] = NAMES[signal.Signals(number)]
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
def terminations() -> Iterator[None]:
    """SIGTERM raises `Terminated` in the block, so that what a command has begun is left in order."""
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
    """Whether a signal may be taken: Ctrl-C, unless it is handled outside of Python; SIGTERM if nobody handles it."""
    if number == signal.SIGINT:
        return handler is not None
    return handler in (signal.SIG_DFL, _raise)
