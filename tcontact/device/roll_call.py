"""Roll calls of the ranks: each says what it does, and learns what all others do.

Collective calls wait for all ranks, for ever where one of them does something else. So the ranks call the roll before
they work together, when they end and when they fail. These messages go from rank to rank, which no collective call of a
rank that does something else can take for its own.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

TAG = 2  # of the messages; exchange.py has 1
STARTS, ENDS, FAILS = "starts a run", "has come to the end of its script", "fails: "  # what ranks say


def answers(world: Any, word: str, patience: float = float("inf")) -> list[str] | None:
    """Return what all ranks say [ranks], in their order; None if that takes longer than the patience [s].

    world: communicator of mpi4py; word: what this rank says.
    """
    end, others = time.monotonic() + patience, range(1, world.Get_size())
    if world.Get_rank():
        found = _arrived([world.isend(word, dest=0, tag=TAG), world.irecv(source=0, tag=TAG)], end)
        return None if found is None else list(found[1])
    found = _arrived([world.irecv(source=other, tag=TAG) for other in others], end)
    if found is None:
        return None
    words = [word, *found]
    sent = _arrived([world.isend(words, dest=other, tag=TAG) for other in others], end)
    return None if sent is None else words


def _arrived(requests: Sequence[Any], end: float) -> list[Any] | None:
    """Return what messages hold if all of them arrive before a moment of `time.monotonic`, else None."""
    for request in requests:
        while not request.Get_status():  # which leaves it to `wait` to read the message
            if time.monotonic() > end:
                return None
            time.sleep(0.002)
    return [request.wait() for request in requests]
