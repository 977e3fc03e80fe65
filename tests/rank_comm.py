"""Runs on communicators of a script's own: `mpiexec -n 3 python rank_comm.py FOLDER`; the first process reports.

The first two processes share a scene while the third runs it alone; then each runs a scene of its own; then all share
one.
"""

import json
import sys
from pathlib import Path

import numpy as np
from mpi4py import MPI
from rank_scenes import block, normal

import tcontact as tc
from tcontact.device import runtime

world, folder = MPI.COMM_WORLD, sys.argv[1]
own = world.Get_rank()
scheme = tc.CentralDifference(cfl=0.6)


def error(result, other):
    """Return the largest difference of two results in position and contact force over the largest value."""
    pairs = [(result.position, other[0]), (result.history["contact_force"], other[1])]
    return max(np.abs(one - two).max() / np.abs(two).max() for one, two in pairs)


pair = world.Split(min(own // 2, 1))
options = {"out": f"{folder}/shared", "frames": 2} if own < 2 else {}
shared = tc.simulate(normal(), scheme, comm=pair, **options).on_all_ranks(pair)
alone = world.bcast((shared.position, shared.history["contact_force"]), root=2)

scene = tc.Scene([block(counts=(2, 2, 2), velocity=(0.0, 0.0, own + 1.0))], duration=1e-3)
mine = tc.simulate(scene, scheme, out=f"{folder}/own-{own}", frames=2, comm=MPI.COMM_SELF)
speeds = world.gather(float(mine.velocity[:, 2].mean()))

together = tc.simulate(normal(), scheme).on_all_ranks()
errors = world.gather(max(error(shared, alone), error(together, alone)))
threads = world.gather(runtime.threads())
said = ""
try:
    tc.simulate(scene, comm="world")
except tc.InputError as refused:
    said = str(refused)
still = world.gather(float(mine.on_all_ranks().velocity[:, 2].mean()))  # each is the result of one process
parted = ""
try:
    tc.simulate(normal(), scheme, comm=pair).on_all_ranks()
except tc.InputError as refused:
    parted = str(refused)
parted = world.gather(parted)
if own == 0:
    names = ("shared", "own-0", "own-2")
    ranks = [json.loads(Path(folder, name, "summary.json").read_text()).get("ranks", 1) for name in names]
    print("errors", max(errors))
    print("speeds", *speeds)
    print("ranks", *ranks)
    print("threads", *threads)
    print("refused", said)
    print("still", *still)
    print("parted", *set(parted))
