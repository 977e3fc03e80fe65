"""The last words of a rank that ends with an error: told once where all ranks have it, and never left waiting.

A rank cannot know whether the others have its error too, or wait for it in a message of a step. So the first rank tells
its error at once. Then the roll is called (roll_call.py): if all ranks have an error, those that have another one than
the first are told too, and all end. Else the ranks that have an error end all.
"""

from __future__ import annotations

import atexit
import os
import sys
from collections.abc import Callable
from typing import Any

from ..base.errors import InputError
from . import ranks
from .roll_call import ENDS, FAILS, answers

PATIENCE = 3.0  # seconds that a rank that fails waits for the others


def told(error: BaseException, tell: Callable[[], Any], code: int = 1) -> None:
    """Tell of an error that ends this process; where it is one of several ranks see above.

    tell: writes the error to standard error; code: exit code of the processes that this one ends. Returns where it is
    the only rank, or all ranks have an error, and else not at all.
    """
    if ranks.launched()[0] == 1:
        tell()
        return
    if ranks.is_first_rank():
        _say(tell)
    world = _world()
    if world is None:  # there is no MPI between the ranks; the first one has told it
        return
    own = f"{FAILS}{type(error).__name__}: {error}"[:2000]
    words = answers(world, own, PATIENCE)
    if words is not None and all(word.startswith(FAILS) for word in words):
        if own != words[0]:
            _say(tell)
        return
    if world.Get_rank():
        _say(tell)
    print(f"tcontact: rank {world.Get_rank()} of {world.Get_size()} failed, which ends all ranks", file=sys.stderr)
    ranks.passed_on(sys.stderr)
    world.Abort(code)
    os._exit(code)  # where the launcher takes a moment


def take_part() -> None:
    """Where a launcher has started several ranks, let errors that nothing catches be told, and the ranks end together.

    Without that a rank that never starts a run would leave the others waiting for it.
    """
    if ranks.launched()[0] == 1 or hasattr(sys.excepthook, "of_ranks"):
        return
    os.environ[ranks.OWNER] = str(os.getpid())
    before = sys.excepthook

    def hook(kind: type[BaseException], error: BaseException, trace: Any) -> None:
        told(error, lambda: before(kind, error, trace))

    hook.of_ranks = True  # type: ignore[attr-defined]
    sys.excepthook = hook
    atexit.register(_end)


def _end() -> None:
    """Wait until all ranks are at their end: a launcher ends those that are left behind, and so what they tell."""
    world = _world()
    while world is not None and set(answers(world, ENDS) or ()) != {ENDS}:
        pass


def _world() -> Any:
    """Return the communicator of all ranks, None where there is no MPI between them."""
    try:
        return ranks.communicator()
    except InputError:
        return None


def _say(tell: Callable[[], Any]) -> None:
    sys.stdout.flush()
    tell()
    ranks.passed_on(sys.stderr)
