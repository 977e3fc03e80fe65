"""Ranks that exchange without end, until the second one is killed: `mpiexec -n P python rank_killed.py STEPS`."""

import os
import signal
import sys

import numpy as np

from tcontact.device import ranks
from tcontact.device.exchange import Exchange


def main(steps):
    """Exchange with all others; rank 1 kills itself after so many times."""
    comm = ranks.communicator()
    rank, size = comm.Get_rank(), comm.Get_size()
    exchange = Exchange(comm, [(other, np.arange(3)) for other in range(size) if other != rank])
    values, done = np.ones((3, 3)), 0
    while True:
        exchange.add(values)
        values[:], done = 1.0, done + 1
        if rank == 1 and done == steps:
            os.kill(os.getpid(), signal.SIGKILL)


if __name__ == "__main__":
    main(int(sys.argv[1]))
