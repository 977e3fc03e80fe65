"""A rank that has a whole body and no boundary node: `mpiexec -n 3 python rank_bare.py FOLDER [CONTACT_RANKS]`.

Two bodies fly beside one that falls on a plane. The first rank saves what one process gives too.
"""

import sys

import numpy as np
from rank_scenes import EXACT, block

import tcontact as tc
from tcontact.device import ranks


def scene():
    """A tower of cells that falls on a plane, and two bodies of a cell that touch nothing."""
    free = [block(counts=(1, 1, 1), at=(place, 0.0, 0.0)) for place in (0.5, 1.0)]
    contact = tc.MasslessContact(removal="normal", tolerance=EXACT)
    return tc.Scene([block(counts=(1, 1, 4), contact="zmin"), *free], [tc.Plane()], 1e-3, contact=contact)


def save(path, result):
    """Save what two runs are compared by: motion and force of every node, and the history."""
    motion = {"x": result.position, "v": result.velocity, "force": result.contact_node_force}
    history = {f"history {name}": column for name, column in result.history.items()}
    np.savez(path, **motion, **history, steps=np.array(result.steps))


if __name__ == "__main__":
    count = int(sys.argv[2]) if sys.argv[2:] else None
    found = tc.simulate(scene(), threads=1, contact_ranks=count)
    if ranks.is_first_rank():
        save(f"{sys.argv[1]}/{count}.npz", found)
