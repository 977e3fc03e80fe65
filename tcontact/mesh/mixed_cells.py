"""Cells of several kinds as rows of one length: a cell with fewer corners repeats its last one."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import numpy.typing as npt

from .elements import BY_CORNERS
from .geometry import Blocks, IntArray


def in_rows(blocks: Blocks) -> IntArray:
    """Return the cells of all blocks, one after another, as rows [m, corners] of the longest of them."""
    width = max(cells.shape[1] for _, cells in blocks)
    return np.concatenate([np.pad(cells, ((0, 0), (0, width - cells.shape[1])), mode="edge") for _, cells in blocks])


def repeats(rows: IntArray) -> npt.NDArray[np.bool_]:
    """Return the places [m, corners] that repeat the corner before."""
    return np.concatenate([np.zeros((len(rows), 1), dtype=bool), rows[:, 1:] == rows[:, :-1]], axis=1)


def out_of_rows(rows: IntArray) -> tuple[tuple[str, IntArray], ...]:
    """Return the blocks of rows that `in_rows` made: kinds of cells, each with its nodes [m, corners], read-only."""
    corners = rows.shape[1] - repeats(rows).sum(axis=1)
    cuts = np.concatenate([[0], np.flatnonzero(np.diff(corners)) + 1, [len(rows)]])
    found = []
    for first, last in pairwise(cuts):
        count = int(corners[first])
        cells = np.ascontiguousarray(rows[first:last, :count])
        cells.flags.writeable = False
        found.append((BY_CORNERS[count].kind, cells))
    return tuple(found)
