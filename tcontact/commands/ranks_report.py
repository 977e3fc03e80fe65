"""What `tcontact doctor` says where a launcher has started several processes: who they are, and how they exchange."""

from __future__ import annotations

import os
import platform
import time
from importlib.metadata import PackageNotFoundError, version

import numpy as np

from ..base.errors import InputError
from ..device import cuda
from ..device.exchange import Exchange
from ..device.team import Team

ROUNDS = 200  # exchanges that are timed
NODES = 1000  # shared nodes of each


def lines(team: Team, cores: int) -> list[str]:
    """Return lines about all ranks, on every rank; cores: number that this process may use.

    Raises `InputError` on all ranks where the values that neighbours send each other do not arrive.
    """
    from mpi4py import MPI

    try:
        cut = f"pymetis {version('pymetis')}"
    except PackageNotFoundError:
        cut = "pymetis is missing: pip install 'tcontact[mpi]'"
    library = MPI.Get_library_version().split("\n")[0].strip()
    about = f"mpi4py {version('mpi4py')}, {library}; {cut}"
    own = f"rank {team.rank} on {platform.node()}, process {os.getpid()}, {cores} cores{_device()}"
    found = team.comm.allgather(own)
    seconds, right = _exchanged(team)
    if team.any(not right):
        raise InputError("ranks", team.size, f"values between them do not arrive as they were sent ({about})")
    took = f"{1e6 * team.largest(seconds):.0f} us for {NODES} shared nodes to every neighbour, in a ring"
    return [about, *found, f"exchange {took}"]


def _device() -> str:
    """Return the name of the CUDA device that this rank has, behind a comma; "" without one."""
    try:
        device = cuda.find_device()
    except cuda.NoDevice:
        return ""
    shown = os.environ.get(cuda.VISIBLE)
    return f", {device.name}" + (f" ({cuda.VISIBLE}={shown})" if shown is not None else "")


def _exchanged(team: Team) -> tuple[float, bool]:
    """Return the seconds of an exchange with both neighbours in a ring, and whether the sums are right."""
    neighbours = sorted({(team.rank + 1) % team.size, (team.rank - 1) % team.size} - {team.rank})
    exchange = Exchange(team.comm, [(other, np.arange(NODES)) for other in neighbours])
    values = np.full((NODES, 3), float(team.rank))
    exchange.add(values)
    right = bool((values == team.rank + sum(neighbours)).all())
    begin = time.perf_counter()
    for _ in range(ROUNDS):
        exchange.add(values)
        values *= 0.0
    seconds = (time.perf_counter() - begin) / ROUNDS
    exchange.free()
    return seconds, right
