"""The last words of a rank that ends with an error: told once where all ranks have it, and never left waiting.

A rank cannot know whether the others have its error too, or wait for it in a message of a step. So the first rank tells
its error at once. The others tell it their error and wait some seconds for an answer: if all ranks have one, those that
it has not told are told too, and all end. Else the ranks that have an error end all. These messages are from rank to
rank, which no collective call of a rank that goes on can take for its own.
"""

from __future__ import annotations

import os
import signal
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from ..base.errors import InputError
from . import ranks

TAG = 2  # of the messages; exchange.py has 1
PATIENCE, STARTING = 3.0, 30  # seconds that a rank waits for the others, and for MPI to start


def told(error: BaseException, tell: Callable[[], None], code: int = 1, patience: float = PATIENCE) -> None:
    """Tell of an error that ends this process; where it is one of several ranks see above.

    tell: writes the error to standard error; code: exit code of the processes that this one ends; patience [s]: how
    long it waits for the others. Returns where it is the only rank, or all ranks have an error, and else not at all.
    """
    if ranks.launched()[0] == 1:
        tell()
        return
    if ranks.is_first_rank():
        _say(tell)
    try:
        with _no_longer_than(STARTING):
            world = ranks.communicator()
    except InputError:  # there is no MPI between the ranks; the first one has told it
        return
    own = f"{type(error).__name__}: {error}"[:2000]
    of_first = _met(world, own, patience)
    if of_first is not None:
        if own != of_first:
            _say(tell)
        return
    if world.Get_rank():
        _say(tell)
    print(f"tcontact: rank {world.Get_rank()} of {world.Get_size()} failed, which ends all ranks", file=sys.stderr)
    ranks.passed_on(sys.stderr)
    world.Abort(code)
    os._exit(code)  # where the launcher takes a moment


def tell_once() -> None:
    """Let errors that nothing catches be told as `told` does, where a launcher has started several ranks."""
    if ranks.launched()[0] == 1 or hasattr(sys.excepthook, "of_ranks"):
        return
    before = sys.excepthook

    def hook(kind: type[BaseException], error: BaseException, trace: Any) -> None:
        told(error, lambda: before(kind, error, trace))

    hook.of_ranks = True  # type: ignore[attr-defined]
    sys.excepthook = hook


def _say(tell: Callable[[], None]) -> None:
    sys.stdout.flush()
    tell()
    ranks.passed_on(sys.stderr)


def _met(world: Any, value: str, patience: float) -> str | None:
    """Return the value of the first rank if all ranks come here within some seconds, else None."""
    end, others = time.monotonic() + patience, range(1, world.Get_size())
    if world.Get_rank():
        found = _arrived([world.isend(value, dest=0, tag=TAG), world.irecv(source=0, tag=TAG)], end)
        return None if found is None else found[1]
    if _arrived([world.irecv(source=other, tag=TAG) for other in others], end) is None:
        return None
    return None if _arrived([world.isend(value, dest=other, tag=TAG) for other in others], end) is None else value


def _arrived(requests: Sequence[Any], end: float) -> list[Any] | None:
    """Return what messages hold if all of them arrive before a moment of `time.monotonic`, else None."""
    for request in requests:
        while not request.Get_status():  # which leaves it to `wait` to read the message
            if time.monotonic() > end:
                return None
            time.sleep(0.005)
    return [request.wait() for request in requests]


@contextmanager
def _no_longer_than(seconds: int) -> Iterator[None]:
    """End this process if what follows takes longer: MPI does not start where the other ranks never start it."""
    if not hasattr(signal, "alarm"):
        yield
        return
    try:
        before = signal.signal(signal.SIGALRM, signal.SIG_DFL)
    except ValueError:  # another thread than the main one
        yield
        return
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)
