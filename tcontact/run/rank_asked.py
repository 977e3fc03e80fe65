"""What `simulate` was asked for, where several ranks carry it out (rank_run.py)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..friction_layer import LayerState
from ..results.pair_memory import PairMemory
from ..scene.scene import Scene
from .checkpoint.keeper import Start
from .handover import Handover


@dataclass(frozen=True)
class Asked:
    """What `simulate` was asked for, checked.

    start: displacement and velocity [n, 3] of every body; layers, points, pairs: what the run takes over; fields: of
    frames; history: rows between two that are kept, and their largest number; contact_ranks: number of ranks that share
    the contact, None: chosen (`cut_domain`); arch: the backend; told: warnings of the run about its start;
    handover: that about its contact nodes.
    """

    scene: Scene
    scheme: Any
    start: Start
    layers: tuple[LayerState | None, ...]
    points: tuple[tuple[np.ndarray, ...], ...]
    pairs: PairMemory | None
    frames: int
    fields: Sequence[str]
    history: tuple[int, int]
    pressures: bool
    precision: str
    contact_ranks: int | None = None
    arch: str = "cpu"
    told: Sequence[str] = ()
    handover: Handover | None = None
