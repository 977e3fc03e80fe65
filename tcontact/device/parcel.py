"""Send an object from one rank to another without copies of its arrays.

Pickle (protocol 5) leaves the memory of arrays out of its text, and MPI sends it from where it stands to where the
other rank will have it.
"""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np

AT_ONCE = 1 << 30  # bytes of a message, of which MPI counts less than 2^31


def send(comm: Any, thing: Any, rank: int, tag: int) -> None:
    """Send something to another rank, which takes it with `receive`."""
    arrays: list[pickle.PickleBuffer] = []
    text = pickle.dumps(thing, protocol=5, buffer_callback=arrays.append)
    views = [array.raw() for array in arrays]
    comm.send((text, [view.nbytes for view in views]), dest=rank, tag=tag)
    for view in views:
        for first in range(0, view.nbytes, AT_ONCE):
            comm.Send(view[first : first + AT_ONCE], dest=rank, tag=tag)


def receive(comm: Any, rank: int, tag: int) -> Any:
    """Return what another rank sends with `send`."""
    text, sizes = comm.recv(source=rank, tag=tag)
    arrays = [np.empty(size, dtype=np.uint8) for size in sizes]
    for array in arrays:
        for first in range(0, len(array), AT_ONCE):
            comm.Recv(array[first : first + AT_ONCE], source=rank, tag=tag)
    return pickle.loads(text, buffers=arrays)
