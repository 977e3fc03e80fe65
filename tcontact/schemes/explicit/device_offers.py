"""How many passes and sweeps of the static solve a step on a GPU offers, so that the last block of steps costs least.

A solve that needs more than its step offers takes what the next steps offer, whose own launches do nothing then; what
is offered beyond need is launched in vain. The cost of a launch is about what it takes the host: it grows with the
arrays that the launch names and with the kernels that it starts.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def passes(solves: np.ndarray, step: float, costs: Sequence[float]) -> int:
    """Return how many passes to offer a step.

    solves [n]: how many solves took one pass, two, and so on; step: cost of the other launches of a step; costs: of its
    first pass, of the second one, and so on, the last one that of all further ones.
    """
    counts, taken = np.asarray(solves), np.arange(1, len(solves) + 1)
    whole = step + np.cumsum([costs[min(number, len(costs) - 1)] for number in range(len(counts))])
    return min(range(1, len(counts) + 1), key=lambda most: counts @ offers(taken, most) * whole[most - 1])


def launches(sweeps: np.ndarray, at_once: int, rest: float, one: float) -> int:
    """Return how many launches of sweeps to offer the first pass of a step, at least one.

    sweeps [steps]: those that the solve of every step took; at_once: sweeps of one launch; rest, one: cost of all other
    launches of a step, of one of sweeps.
    """
    needed = np.maximum(offers(np.asarray(sweeps, dtype=int), at_once), 1)
    most = range(1, int(needed.max(initial=1)) + 1)
    return min(most, key=lambda offered: offers(needed, offered).sum() * (rest + offered * one))


def offers(needed: np.ndarray, offered: int) -> np.ndarray:
    """Return how many offers are taken where so much is needed."""
    return -(-needed // offered)
