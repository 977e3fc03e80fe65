"""One rank alone fails outside a run: `mpiexec -n P python rank_lone.py RANK before|after|everyone`.

before: before it starts a run, which the others wait for; after: when the others are at their end; everyone: all ranks
fail, of which the last one has an error of its own.
"""

import sys

from rank_scenes import block

import tcontact as tc
from tcontact.device import ranks

count, rank = ranks.launched()
fails, moment = int(sys.argv[1]), sys.argv[2]
if moment == "everyone":
    raise tc.InputError("size", -1 if rank < fails else -2, "all ranks have an error")
if moment == "before" and rank == fails:
    raise tc.InputError("size", -1, "this rank alone")
tc.simulate(tc.Scene([block()], duration=1e-4), threads=1)
if rank == fails:
    raise ValueError("this rank alone")
