"""Checkpoints of ranks of which one fails or is killed: `mpiexec -n 2 python rank_kept.py FOLDER`; no run is needed.

The first rank prints, after each of these, the row from which a run would go on; at last the warnings of all ranks.
"""

import errno
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from tcontact.device import ranks
from tcontact.device.team import Team
from tcontact.results.files.checkpoint_heads import place_of
from tcontact.run.checkpoint import contents, store
from tcontact.run.checkpoint.options import Checkpoint
from tcontact.run.rank_files import NoFile, RankKeeper, latest_of_all


def keeper_of(folder, team):
    """Make the keeper of a rank."""
    place = place_of(folder, team.rank)
    place.mkdir(parents=True, exist_ok=True)
    head, recorder = {"keep": False, "ranks": team.size}, SimpleNamespace(file=NoFile(0))
    keeper = RankKeeper(Checkpoint(every_steps=3), place, {}, recorder, head)
    keeper.team = team
    return keeper


def full(*_given):
    """Fail as a full disk does."""
    raise OSError(errno.ENOSPC, "No space left on device")


def main(folder):
    """Do everything on all ranks."""
    team, warned = Team(ranks.communicator()), []
    run = SimpleNamespace(warn=warned.append)
    contents.collect = lambda *_given: ({"u": np.zeros(9)}, {})

    def told(name):
        team.comm.Barrier()
        row = latest_of_all(folder / name, team)[0].row
        if team.leads:
            print(name, row)

    keeper, write = keeper_of(folder / "full", team), store.write
    for row in (3, 6, 9, 12, 15, 18):
        if team.rank == 1:
            store.write = full if row in (9, 12) else write
        keeper.save(run, row)
        told("full")
    keeper = keeper_of(folder / "killed", team)
    for row in (3, 6):
        keeper.save(run, row)
    for _ in range(3):  # the other rank is killed before it writes its own
        keeper = keeper_of(folder / "killed", team)
        stored = latest_of_all(folder / "killed", team)[0]
        keeper.restored(stored.place)
        store.remove_later(folder / "killed", stored.place, team.rank, team.size)
        if team.leads:
            keeper.failure = lambda own: own
            keeper.save(run, 9)
        told("killed")
    every = team.comm.gather(warned)
    if team.leads:
        print(*every, sep="\n")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
