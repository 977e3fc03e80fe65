"""Exchange of values at nodes of which several ranks have copies.

    f_i = sum over the ranks r with a copy of node i, in the order of the ranks, of f_i^r

Every rank sends its own part to all ranks with a copy and adds all parts itself, in the same order: the copies get
equal bits with one message between two ranks (`Exchange`). Values that one rank alone computes go to those that need
them, or parts of them to the rank that adds them (`Handover`). Requests are persistent: nothing is set up in a step.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np

from ..base.errors import InputError


class Exchange:
    """Adds parts of values at shared nodes over the ranks.

    comm: communicator of mpi4py; shared: for every rank with copies, ascending, the rows [k] of the values, in the
    order that both ranks have; width: numbers of a row. bytes_sent: by this rank so far; all_messages,
    all_bytes: what all exchanges of this process have sent.
    """

    all_messages: ClassVar[int] = 0
    all_bytes: ClassVar[int] = 0

    def __init__(self, comm: Any, shared: Sequence[tuple[int, np.ndarray]], width: int = 3) -> None:
        self.rank, self.width = int(comm.Get_rank()), width
        if [other for other, _ in shared] != sorted({other for other, _ in shared} - {self.rank}):
            raise InputError("shared", [other for other, _ in shared], "list the other ranks once, ascending")
        self.shared = [(int(other), np.asarray(rows, dtype=np.int64)) for other, rows in shared]
        self.rows = np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *(rows for _, rows in self.shared)]))
        self.places = [np.searchsorted(self.rows, rows) for _, rows in self.shared]
        self.sent = [np.zeros((len(rows), width)) for _, rows in self.shared]
        self.received = [np.zeros((len(rows), width)) for _, rows in self.shared]
        self.requests = [
            request
            for (other, _), out, into in zip(self.shared, self.sent, self.received, strict=True)
            for request in (comm.Recv_init(into, source=other, tag=1), comm.Send_init(out, dest=other, tag=1))
        ]
        self.bytes_sent = 0

    def start(self, values: np.ndarray) -> None:
        """Send the parts of this rank of values [n, width]; between `start` and `finish` the other rows may change."""
        for (_, rows), out in zip(self.shared, self.sent, strict=True):
            np.take(values, rows, axis=0, out=out)
        for request in self.requests:
            request.Start()
        size = sum(out.nbytes for out in self.sent)
        self.bytes_sent += size
        Exchange.all_messages += len(self.shared)
        Exchange.all_bytes += size

    def finish(self, values: np.ndarray) -> None:
        """Put the sums of the parts into the shared rows of values [n, width]."""
        for request in self.requests:
            request.Wait()
        own = values[self.rows]
        total, waiting = np.zeros_like(own), True
        for (other, _), places, parts in zip(self.shared, self.places, self.received, strict=True):
            if waiting and other > self.rank:
                total, waiting = total + own, False
            total[places] += parts
        values[self.rows] = total + own if waiting else total

    def add(self, values: np.ndarray) -> None:
        """Add the parts of all ranks at the shared rows of values [n, width], in place."""
        self.start(values)
        self.finish(values)

    def free(self) -> None:
        """Give the requests back; MPI complains of those that are left at the end."""
        for request in self.requests:
            request.Free()
        self.requests = []


class Handover:
    """Sends values from the ranks that compute them to those that need them.

    comm: communicator of mpi4py; sent, received: for every other rank, ascending, the places [n, width] in a flat
    array, in the order that both ranks have.
    """

    TAG: ClassVar[int] = 3  # `Exchange` has 1, roll_call.py 2

    def __init__(
        self, comm: Any, sent: Sequence[tuple[int, np.ndarray]], received: Sequence[tuple[int, np.ndarray]]
    ) -> None:
        self.sent = [(int(other), places.reshape(-1)) for other, places in sent if len(places)]
        self.received = [(int(other), places.reshape(-1)) for other, places in received if len(places)]
        self._out = [np.zeros(places.shape) for _, places in self.sent]
        self._into = [np.zeros(places.shape) for _, places in self.received]
        ends = zip(self.received, self._into, strict=True)
        self.requests = [comm.Recv_init(into, source=other, tag=self.TAG) for (other, _), into in ends]
        starts = zip(self.sent, self._out, strict=True)
        self.requests += [comm.Send_init(out, dest=other, tag=self.TAG) for (other, _), out in starts]

    def pass_on(self, values: np.ndarray) -> None:
        """Send the values at the places of this rank, and put those of other ranks into their places."""
        self.move(values)
        for (_, places), parts in zip(self.received, self._into, strict=True):
            values[places] = parts

    def add(self, values: np.ndarray) -> None:
        """Send the values at the places of this rank, and add those of other ranks, in the order of the ranks."""
        self.move(values)
        for (_, places), parts in zip(self.received, self._into, strict=True):
            values[places] += parts

    def move(self, values: np.ndarray) -> None:
        """Send the values at the places of this rank, and wait for those of the others."""
        for (_, places), out in zip(self.sent, self._out, strict=True):
            np.take(values, places, out=out, mode="clip")  # which needs no buffer; all places are inside
        for request in self.requests:
            request.Start()
        for request in self.requests:
            request.Wait()
        Exchange.all_messages += len(self._out)
        Exchange.all_bytes += sum(out.nbytes for out in self._out)

    def free(self) -> None:
        """Give the requests back."""
        for request in self.requests:
            request.Free()
        self.requests = []
