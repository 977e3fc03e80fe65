"""The ranks of a run: how many processes an MPI launcher has started, and their communicator.

A launcher says it in the environment of the processes, so that nothing of MPI is imported without one.
"""

from __future__ import annotations

import os
import stat
import sys
import time
from typing import Any, TextIO

from ..base.errors import InputError

# number of processes and number of this one: MPICH and Intel MPI, Open MPI, Slurm's srun
VARIABLES = (
    ("PMI_SIZE", "PMI_RANK"),
    ("OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_RANK"),
    ("SLURM_STEP_NUM_TASKS", "SLURM_PROCID"),
)
# processes that the launcher has started on this machine: MPICH and Intel MPI, Open MPI; of Slurm "4(x2),3" for three
BESIDE = ("MPI_LOCALNRANKS", "OMPI_COMM_WORLD_LOCAL_SIZE")
SLURM_BESIDE = "SLURM_STEP_TASKS_PER_NODE"
NUMBERED = ("MPI_LOCALRANKID", "OMPI_COMM_WORLD_LOCAL_RANK", "SLURM_LOCALID")  # number of this one among these
OWNER = "TCONTACT_RANK"  # number of the process that is a rank, for those that it starts


def launched() -> tuple[int, int]:
    """Return the number of processes that an MPI launcher has started, and the number of this one; (1, 0) without.

    A process that one of them has started, which has its environment, is none of them.
    """
    if os.environ.get(OWNER, str(os.getpid())) != str(os.getpid()):
        return 1, 0
    for size, rank in VARIABLES:
        count, own = os.environ.get(size, ""), os.environ.get(rank, "")
        if count.isdigit() and own.isdigit() and int(count) > 1:
            return int(count), int(own)
    return 1, 0


def is_first_rank() -> bool:
    """Return whether this process is the first of those that `mpiexec` has started, or the only one.

    A run on several ranks returns a `Result` on all of them, whole on the first: let that one print, draw and write.
    """
    return launched()[1] == 0


def cores_of_a_rank() -> int:
    """Return the number of cores that this process may use, an equal share where a launcher started several here."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    count, _ = launched()
    if count == 1:
        return cores
    known = [int(os.environ[name]) for name in BESIDE if os.environ.get(name, "").isdigit()]
    tasks = [part.partition("(")[0] for part in os.environ.get(SLURM_BESIDE, "").split(",")]
    known += [max(int(number) for number in tasks)] if all(number.isdigit() for number in tasks) else [count]
    return max(1, min(cores, (os.cpu_count() or 1) // max(1, known[0])))


def number_on_machine() -> int | None:
    """Return the number of this process among those that a launcher has started here; None for a single process."""
    if launched()[0] == 1:
        return None
    known = [int(os.environ[name]) for name in NUMBERED if os.environ.get(name, "").isdigit()]
    return known[0] if known else launched()[1]


def checked(comm: Any) -> Any:
    """Return a communicator of mpi4py that this process belongs to. Raises `InputError` for anything else."""
    remedy = "give a communicator of mpi4py with this process in it, such as MPI.COMM_SELF, or None"
    try:
        from mpi4py import MPI
    except (ImportError, RuntimeError) as error:
        raise InputError("comm", comm, f"{remedy}; mpi4py cannot be imported ({error})") from error
    if not isinstance(comm, MPI.Intracomm) or comm == MPI.COMM_NULL:
        raise InputError("comm", comm, remedy)
    return comm


def check_single(what: str) -> None:
    """Refuse what takes one process where a launcher has started several. Raises `InputError`."""
    count, _ = launched()
    if count > 1:
        raise InputError("ranks", count, f"{what} takes one process in this version; start it without mpiexec")


def passed_on(stream: TextIO, seconds: float = 10.0) -> None:
    """Wait until the launcher has read what this process wrote, for some seconds at most.

    A launcher that learns of the end of a rank before it has read the rank's last lines drops them.
    """
    stream.flush()
    end = time.monotonic() + seconds
    while _unread(stream) and time.monotonic() < end:
        time.sleep(0.01)


def _unread(stream: TextIO) -> int:
    """Return the number of bytes in the pipe behind a stream; 0 where it is no pipe, or the system cannot tell."""
    try:
        import fcntl
        import termios

        if not stat.S_ISFIFO(os.fstat(stream.fileno()).st_mode):
            return 0
        return int.from_bytes(fcntl.ioctl(stream.fileno(), termios.FIONREAD, bytes(4)), sys.byteorder)
    except (ImportError, OSError, ValueError):
        return 0


def communicator() -> Any:
    """Return the communicator of all processes, None for a single one.

    Raises `InputError` if mpi4py or its MPI library is missing, or belongs to another MPI than the launcher.
    """
    count, _ = launched()
    if count == 1:
        return None
    try:
        import mpi4py

        mpi4py.rc.thread_level = "funneled"
        from mpi4py import MPI
    except ImportError as error:
        raise InputError("ranks", count, "they need mpi4py; pip install 'tcontact[mpi]'") from error
    except RuntimeError as error:  # mpi4py is there, but finds no library
        remedy = f"mpi4py finds no MPI library ({error}); install one, or pip install mpich"
        raise InputError("ranks", count, remedy) from error
    world = MPI.COMM_WORLD
    if world.Get_size() != count:
        found = f"mpi4py sees {world.Get_size()} processes: its MPI is not that of the launcher"
        own = MPI.Get_library_version().split()[0]
        remedy = f"use the mpiexec of {own}, or srun with the --mpi that {own} knows (srun --mpi=list)"
        names = " and ".join(size for size, _ in VARIABLES if size in os.environ)
        remedy += f"; for runs that have nothing to do with each other unset {names}"
        raise InputError("ranks", count, f"{found}; {remedy}")
    return world
