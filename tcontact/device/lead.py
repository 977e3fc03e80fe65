"""What the first rank does alone, with values of all ranks where it needs them.

    first rank:     runs a function; where this calls a collective method, it names the method to the other ranks
    other ranks:    wait, and call every method that is named, until the function has returned

So frames, results and looks at whole bodies need arrays of whole bodies on the first rank only, and code that reads
them need not know what it needs before it runs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from typing import Any, TypeVar

import numpy as np

from ..base.errors import FunctionError, InputError, OutputError

Value = TypeVar("Value")
Rows = Callable[[slice], np.ndarray]
AT_ONCE = 1 << 15  # rows in a message to the first rank
ROWS = 5  # tag of messages with rows for the first rank; team.py, roll_call.py and exchange.py have 1 to 4


class Lead:
    """Lets the first rank of a communicator run a function alone, while the others wait for what it needs of them.

    leads: this is the first rank; acting: it is running such a function.
    """

    def __init__(self, comm: Any) -> None:
        self.comm, self.rank, self.acting = comm, int(comm.Get_rank()), False
        self.leads = self.rank == 0
        self._known: dict[int, Any] = {}  # by numbers, the same on all ranks

    def register(self, thing: Any) -> int:
        """Make an object with collective methods known, in the same order on all ranks; return its number."""
        self._known[len(self._known)] = thing
        return len(self._known) - 1

    def alone(self, act: Callable[[], Value]) -> Value | None:
        """Run a function on the first rank and return what it gives there, None on the other ranks.

        Raises its `InputError`, `OutputError` or `FunctionError` on all ranks.
        """
        return self._act(act, False)

    def decide(self, act: Callable[[], Value]) -> Value:
        """Run a function on the first rank and return on all ranks what it gives; raises as `alone`."""
        found: Any = self._act(act, True)
        return found

    def _act(self, act: Callable[[], Value], told: bool) -> Value | None:
        if not self.leads:
            return self._follow()
        found = error = None
        self.acting = True
        try:
            found = act()
        except (InputError, OutputError, FunctionError) as own:
            error = own
        finally:
            self.acting = False
        self.comm.bcast((None, error, found if told and error is None else None))
        if error is not None:
            raise error
        return found

    def _follow(self) -> Any:
        """Call the methods that the first rank names until its function has returned; return what it sends then."""
        while True:
            number, *given = self.comm.bcast(None)
            if number is None:
                error, found = given
                if error is not None:
                    raise error
                return found
            name, words = given
            getattr(self._known[number], name)(*words)

    @contextmanager
    def calling(self, number: int, name: str, given: tuple[Any, ...]) -> Iterator[None]:
        """Let the other ranks call a method of their object of this number, if the first rank runs a function alone."""
        acting = self.acting
        if acting:
            self.comm.bcast((number, name, given))
        self.acting = False
        try:
            yield
        finally:
            self.acting = acting

    def collected(self, read: Rows, counts: np.ndarray, placed: Callable[[slice], Any] = lambda at: at) -> np.ndarray:
        """Return the rows of all ranks on the first one, one rank after the other, and no rows on the others.

        read: gives some rows of this rank; counts [ranks]: number of rows of each; placed: gives the places in the
        result of some rows as they come. They come in portions, for which there is room beside the result.
        """
        width = read(slice(0, 0)).shape[1:]
        if not self.leads:
            for rows in _portions(int(counts[self.rank])):
                self.comm.Send(np.ascontiguousarray(read(rows), dtype=np.float64), dest=0, tag=ROWS)
            return np.empty((0, *width))
        found, room, start = np.empty((int(counts.sum()), *width)), np.empty((AT_ONCE, *width)), 0
        for rank, count in enumerate(counts.tolist()):
            for rows in _portions(count):
                own = read(rows) if rank == self.rank else room[: rows.stop - rows.start]
                if rank != self.rank:
                    self.comm.Recv(own, source=rank, tag=ROWS)
                found[placed(slice(start + rows.start, start + rows.stop))] = own
            start += count
        return found


def _portions(count: int) -> Iterator[slice]:
    """Yield the rows of a message each."""
    return (slice(first, min(first + AT_ONCE, count)) for first in range(0, count, AT_ONCE))


def collective(method: Callable[..., Any]) -> Callable[..., Any]:
    """Mark a method as one that all ranks call: where the first one, alone, calls it, the others are told to.

    Its object has the attributes lead (`Lead`) and lead_number, its number there (`Lead.register`).
    """

    @wraps(method)
    def called(self: Any, *given: Any) -> Any:
        with self.lead.calling(self.lead_number, method.__name__, given):
            return method(self, *given)

    return called
