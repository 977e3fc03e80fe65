"""What the contact between bodies remembers at the end of a run, with which another run goes on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class PairMemory:
    """Numbers of the nodes of all bodies, in the user's numbering, bodies stacked in order.

    closed [n] [m]: gap of the start that counts as 0 (`Pair.initial_gap`), NaN where no pair asks for it; built,
    searched [n, 3] [m]: displacements at which constraint rows were built and faces searched last, NaN at nodes that
    are on no surface of a pair; fast: numbers of the slaves whose masters came in fast and touch them since; steps:
    since rows were built.
    """

    closed: np.ndarray
    built: np.ndarray
    searched: np.ndarray
    fast: tuple[int, ...]
    steps: int
