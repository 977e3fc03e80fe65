"""Run halves and the whole of a sliding pair: `[mpiexec -n P] python rank_gone_on.py FILE`; the first rank saves."""

import sys

import numpy as np
from test_initial_friction import LAWS, parts, pressed

from tcontact.device import ranks

if __name__ == "__main__":
    scene = pressed(LAWS["rising"], "pair", 2e-3, cells=(4, 3, 7))
    count, _own = ranks.launched()
    whole, first, second = parts(scene, threads=1, contact_ranks=count)
    if ranks.is_first_rank():
        forces = (one.history["pair_force:up-low"] for one in (whole, second))
        np.savez(sys.argv[1], *forces, seam=np.array(first.steps))
