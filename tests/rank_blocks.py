"""What every rank of tests/test_rank_blocks.py runs: `mpiexec -n 2 python rank_blocks.py`; the first one reports.

Scenes run twice: as they are, and with every second look at a row saying that its block should have ended there.
"""

import warnings

import numpy as np
from rank_scenes import LAWS, SCENES, block

import tcontact as tc
from tcontact.device import ranks
from tcontact.device.team import Team
from tcontact.run.loop import Run
from tcontact.schemes.explicit.rank_state import RankState

GATHERED = []  # numbers that all ranks have gathered while they step


def counted(gathered):
    """Count what all ranks gather."""

    def called(team, values):
        GATHERED.append(np.size(values))
        return gathered(team, values)

    return called


def since_the_first(step):
    """Forget what was gathered before the first step."""

    def called(run, time, *given):
        if time == 0.0:
            GATHERED.clear()
        return step(run, time, *given)

    return called


def broken(within, looks, redone):
    """Say of every second row that its block ends there."""

    def called(watched, limits):
        looks.append(watched)
        redone.append(len(looks) % 2 == 0)
        return within(watched, limits) and not redone[-1]

    return staticmethod(called)


def bits(result):
    """Return the bits of the rows and of the end of a run."""
    rows = [np.asarray(result.history[name]).tobytes() for name in sorted(result.history)]
    return rows + [values.tobytes() for values in (result.position, result.velocity, result.contact_node_force)]


def main():
    """Run the scenes, and a flight of many steps whose messages to all ranks are counted."""
    warnings.simplefilter("ignore")
    within = RankState._within
    for name, shared in (("rigid", None), ("walls", 2), ("loose", 2)):
        known, looks, redone = [], [], []
        for new in (within, broken(within, looks, redone)):
            RankState._within = staticmethod(new) if new is within else new
            result = tc.simulate(SCENES[name](), threads=1, contact_ranks=shared, history_every=1)
            if ranks.is_first_rank():
                known.append(bits(result))
        if ranks.is_first_rank():
            print(name, sum(redone), known[0] == known[1])
    RankState._within = staticmethod(within)
    Team.gathered, Run._step = counted(Team.gathered), since_the_first(Run._step)
    flight = tc.Scene([block(LAWS["linear"])], duration=2e-2)
    result = tc.simulate(flight, threads=1)
    if ranks.is_first_rank():
        print("flight", result.steps, len(GATHERED))


if __name__ == "__main__":
    main()
