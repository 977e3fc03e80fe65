"""Stages of a run, such as planning or compiling, told to whoever listens, and to the logger "tcontact" as INFO."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager

LOGGER = logging.getLogger("tcontact")
LOGGER.addHandler(logging.NullHandler())  # a program that sets up no logging sees nothing
_listeners: list[Callable[[str], None]] = []


def say(stage: str) -> None:
    """Tell in a few words what begins now; "": nothing that takes time, or something that shows its own progress."""
    if stage:
        LOGGER.info(stage)
    for listener in _listeners:
        listener(stage)


def detail(line: str) -> None:
    """Report what a user asked for: to the logger where the program shows its INFO, else print it."""
    if LOGGER.isEnabledFor(logging.INFO):
        LOGGER.info(line)
    else:
        print(line)


@contextmanager
def heard(listener: Callable[[str], None]) -> Iterator[None]:
    """Call a function with every stage that begins inside."""
    _listeners.append(listener)
    try:
        yield
    finally:
        _listeners.remove(listener)
