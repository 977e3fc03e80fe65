"""The processes of a run on several ranks: numbers that all of them need, and errors that end all of them.

Every rank calls the same methods in the same order. Sums add the parts in the order of the ranks on every rank, so that
all ranks take the same decisions from equal bits; MPI does not promise that of its own reductions.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any, TypeVar

import numpy as np

from ..base.errors import InputError
from . import parcel, ranks
from .exchange import Exchange, Handover
from .last_words import PATIENCE
from .lead import Lead
from .roll_call import FAILS, STARTS, answers

Value = TypeVar("Value")
SHARES = 4  # tag of the messages that share something out; roll_call.py and exchange.py have 1 to 3, lead.py has 5


def team(comm: Any = None, word: str = STARTS) -> Team | None:
    """Return the ranks of a communicator of mpi4py, None where it has one process; all of them call it.

    comm: None = that of all processes that a launcher has started; word: what all of them are to do. Raises
    `InputError` for what is no communicator of this process, as `ranks.communicator`, and on all ranks if one of them
    does something else or ends instead.
    """
    world = ranks.communicator() if comm is None else ranks.checked(comm)
    if world is None or int(world.Get_size()) == 1:
        return None
    words = answers(world, word)
    if words is not None and set(words) != {word}:
        if any(word.startswith(FAILS) for word in words):
            time.sleep(PATIENCE)  # that rank ends all
        said = "; ".join(f"rank {number} {word}" for number, word in enumerate(words))
        remedy = f"{said}: all ranks make the same calls, and tc.is_first_rank() is for what one of them prints"
        raise InputError("ranks", len(words), remedy)
    return Team(world)


class Team:
    """The ranks of a communicator of mpi4py; rank: number of this one; size: their number.

    lead: lets the first one act alone; agreed: the last error that `agree` has raised on all of them;
    moment: what they are at, in words, "" for nothing to tell.
    """

    def __init__(self, comm: Any) -> None:
        self.comm, self.rank, self.size = comm, int(comm.Get_rank()), int(comm.Get_size())
        self.lead = Lead(comm)
        self.agreed: Exception | None = None
        self.moment = ""
        self._exchanges: list[Exchange | Handover] = []
        self._groups: list[Team] = []

    def exchange(self, shared: Sequence[tuple[int, np.ndarray]], width: int = 3) -> Exchange:
        """Return an exchange of the values at shared rows, see `Exchange`."""
        found = Exchange(self.comm, shared, width)
        self._exchanges.append(found)
        return found

    def handover(self, sent: Sequence[tuple[int, np.ndarray]], received: Sequence[tuple[int, np.ndarray]]) -> Handover:
        """Return what hands values over to other ranks, see `Handover`."""
        found = Handover(self.comm, sent, received)
        self._exchanges.append(found)
        return found

    def group(self, ranks: Sequence[int]) -> Team:
        """Return a team of some ranks; all ranks call it, the others get a team of no use."""
        found = Team(self.comm.Split(int(self.rank in ranks), self.rank))
        self._groups.append(found)
        return found

    def free(self) -> None:
        """Give back what MPI holds for the exchanges."""
        for one in self._exchanges:
            one.free()
        self._exchanges = []
        for group in self._groups:
            group.comm.Free()
        self._groups = []

    @property
    def leads(self) -> bool:
        """Return whether this is the first rank, which has the contact and writes the files."""
        return self.rank == 0

    def gathered(self, values: np.ndarray) -> np.ndarray:
        """Return values [..], of one shape on all ranks, of every rank [ranks, ..]."""
        own = np.array(values, dtype=np.float64, order="C")
        found = np.empty((self.size, *own.shape))
        self.comm.Allgather(own, found)
        return found

    def joined(self, values: np.ndarray, counts: np.ndarray) -> np.ndarray:
        """Return the rows of all ranks, one rank after the other; counts [ranks]: number of rows of each."""
        own = np.ascontiguousarray(values, dtype=np.float64)
        found = np.empty((int(counts.sum()), *own.shape[1:]))
        width = int(np.prod(own.shape[1:], dtype=np.int64))
        self.comm.Allgatherv(own, [found, [int(count) * width for count in counts]])
        return found

    def send_share(self, rank: int, share: Any) -> None:
        """Send something from the first rank to another one, which takes it with `received_share`."""
        parcel.send(self.comm, share, rank, SHARES)

    def received_share(self) -> Any:
        """Return what the first rank sends to this one."""
        return parcel.receive(self.comm, 0, SHARES)

    def shared_out(self, values: np.ndarray | None, rows: np.ndarray) -> np.ndarray:
        """Return the rows [k] of this rank of values [n, ..] that the first rank has, one rank after the other."""
        if not self.leads:
            parcel.send(self.comm, rows, 0, SHARES)
            found: np.ndarray = self.received_share()
            return found
        assert values is not None
        for rank in range(1, self.size):
            self.send_share(rank, values[parcel.receive(self.comm, rank, SHARES)])
        return values[rows]

    def total(self, value: float) -> float:
        """Return the sum of a number over the ranks, in their order."""
        return float(sum(self.gathered(np.array(value)).tolist()))

    def largest(self, value: Any) -> Any:
        """Return the largest value of every number [..] over the ranks."""
        found = self.gathered(np.asarray(value)).max(axis=0)
        return float(found) if np.ndim(value) == 0 else found

    def smallest(self, value: float) -> float:
        """Return the smallest value of a number over the ranks."""
        return float(self.gathered(np.array(value)).min())

    def any(self, condition: bool) -> bool:
        """Return whether a condition holds on some rank."""
        return self.largest(float(condition)) > 0.0

    def from_first(self, value: Value) -> Value:
        """Return what the first rank has; the other ranks give anything."""
        return self.comm.bcast(value)

    def first_of(self, value: Value | None) -> Value | None:
        """Return the value of the lowest rank that has one; None where no rank has."""
        return next((one for one in self.comm.allgather(value) if one is not None), None)

    def agree(self, error: Exception | None) -> None:
        """Raise the error of the lowest rank that has one, on every rank, which notes it in `agreed`."""
        found = self.first_of(error)
        if found is not None:
            self.agreed = error if error is not None and type(error) is type(found) else found
            raise self.agreed
