"""Gaps of many positions to the obstacles of a bundle, for the benchmark: what the contact kernels do per node."""

import functools

import taichi as ti

from .arguments import ARRAY
from .bundles import ContactOptions, Obstacles
from .obstacles import gap_and_normal


@functools.cache
def make_gaps(shapes: tuple[str, ...]):
    """Kernel: gap of every position [n, 3] to obstacle 0, memoised."""
    options = ContactOptions(shapes=shapes)

    @ti.kernel
    def gaps(records: ARRAY, motion: ARRAY, positions: ARRAY, gaps_out: ARRAY):
        obstacles = ti.static(Obstacles(records=records, motion=motion, options=options))
        for i in range(gaps_out.shape[0]):
            x = ti.Vector([positions[3 * i + j] for j in range(3)])
            gap, _normal = gap_and_normal(obstacles, 0, x)
            gaps_out[i] = gap

    return gaps
