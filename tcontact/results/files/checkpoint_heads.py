"""Where the checkpoints of a run lie, of which row each is, and from which of them the run can go on.

A checkpoint of a run on several ranks is a file of each of them, and is complete where all of them have it.
"""

from __future__ import annotations

import json
import zipfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

FILES = ("checkpoint-a.npz", "checkpoint-b.npz")
RANKS = "checkpoint-ranks"  # folder of those of the other ranks, one below it for each
HEAD = "head"
UNREADABLE = OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile, NotImplementedError

Place = tuple[int, int]  # row of the history at which a checkpoint was written, number of ranks of its run


def head_of(path: Path) -> dict[str, Any] | None:
    """Read the plain data of a checkpoint; None if it is missing or damaged."""
    try:
        with np.load(path, allow_pickle=False) as stored:
            return dict(json.loads(stored[HEAD].tobytes()))
    except UNREADABLE:
        return None


def head(folder: Path) -> dict[str, Any]:
    """Return the plain data of the latest checkpoint of a folder, {} where there is none that can be read."""
    found = (head_of(folder / name) for name in FILES)
    return max((one for one in found if one is not None), key=lambda one: int(one["row"]), default={})


def place_in_run(head: Mapping[str, Any]) -> Place:
    """Return the row of a checkpoint and the number of ranks of its run, 1 for one process."""
    return int(head["row"]), int(head.get("ranks", 1))


def place_of(folder: Path, rank: int) -> Path:
    """Return the folder for the checkpoints of a rank."""
    return folder if rank == 0 else folder / RANKS / str(rank)


def others(folder: Path) -> list[int]:
    """Return the numbers of the ranks beside the first one that have left checkpoints, ascending."""
    return sorted(int(found.name) for found in (folder / RANKS).glob("*") if found.name.isdigit())


def last_complete(known: Iterable[tuple[int, int, int]]) -> Place | None:
    """Return row and number of ranks of the last checkpoint that every rank of its run has written, None without any.

    known: rank, row and number of ranks of all checkpoints that were read.
    """
    have: dict[Place, set[int]] = {}
    for rank, row, ranks in known:
        have.setdefault((row, ranks), set()).add(rank)
    return max((one for one, ranks in have.items() if ranks == set(range(one[1]))), default=None)


def goes_on(folder: Path, frames: int | None = None) -> bool:
    """Return whether a run can go on from its checkpoints; frames: number of those in its file, None: all it had."""
    known = []
    for rank in (0, *others(folder)):
        for path in (place_of(folder, rank) / name for name in FILES):
            one = head_of(path)
            if one is not None and (frames is None or one.get("frames", 0) <= frames):
                known.append((rank, *place_in_run(one)))
    return last_complete(known) is not None
