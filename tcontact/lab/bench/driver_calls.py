"""Counts what the driver of a GPU is asked for, where it keeps a log of its calls (the file in FAKE_CUDA_LOG)."""

from __future__ import annotations

import os
from collections import Counter
from pathlib import Path

from ...schemes.explicit.state import DomainState

LOG = "FAKE_CUDA_LOG"
FAKE = "FAKE_CUDA_DIR"  # set where the device is a program that runs the machine code on the CPU
KINDS = {  # by the first word of a line; arguments of a launch are sent without waiting and not counted
    "launch": "launches",
    "sync": "syncs",
    "DtoH": "copies",
    "HtoD": "copies",
    "DtoHasync": "copies",
    "DtoD": "copies",
}


def is_fake() -> bool:
    """Return whether the device only looks like one: its times mean nothing."""
    return FAKE in os.environ


def calls_so_far() -> Counter[str] | None:
    """Return launches, syncs and copies of this process so far; None without a log."""
    name = os.environ.get(LOG)
    if name is None or not Path(name).is_file():
        return None
    with Path(name).open(encoding="utf-8") as file:
        found = Counter(KINDS.get(line.split(" ", 1)[0].strip(), "") for line in file)
    return Counter({kind: found[kind] for kind in KINDS.values()})


def calls_of_a_block(state: DomainState, dt: float) -> dict[str, float] | None:
    """Take as many steps [s] of a domain as one call takes, and return the calls of the driver per step; None without
    a log. The second of two such blocks is counted: the first one may compile."""
    found = None
    for _ in range(2):
        before = calls_so_far()
        if before is None:
            return None
        rows = state.advance(dt / 2, dt / 2, dt, 0.0, (dt, dt), state.rows_at_once)
        after = calls_so_far() or before
        found = {kind: (after[kind] - before[kind]) / rows for kind in dict.fromkeys(KINDS.values())}
        found |= {"rows": float(rows)}
    return found
