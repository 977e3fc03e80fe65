"""Random vectors from which searches for the stable step start: the same for every number of ranks."""

from __future__ import annotations

import numpy as np

from ...mesh.geometry import chunks_of

SEED = 20071
AT_ONCE = 1 << 16  # rows


def random_vector(size: int) -> np.ndarray:
    """Return numbers [size] between -1 and 1."""
    return np.random.default_rng(SEED).uniform(-1.0, 1.0, size)


def random_rows(numbers: np.ndarray) -> np.ndarray:
    """Return the rows [k, 3] of these numbers [k] of `random_vector`, of which only a portion is there at a time."""
    found = np.empty((len(numbers), 3))
    order = np.argsort(numbers, kind="stable")
    if not len(order):
        return found
    first, last = int(numbers[order[0]]), int(numbers[order[-1]])
    bits = np.random.PCG64(SEED)
    bits.advance(3 * first)  # a number takes one step of the generator
    draw = np.random.Generator(bits)
    for part in chunks_of(last + 1 - first, AT_ONCE):
        rows = draw.uniform(-1.0, 1.0, (part.stop - part.start, 3))
        low, high = (np.searchsorted(numbers, first + at, sorter=order) for at in (part.start, part.stop))
        mine = order[low:high]
        found[mine] = rows[numbers[mine] - (first + part.start)]
    return found
