"""Kernel that computes the gaps of many positions to an obstacle, with the functions of contact, for the benchmark."""

import functools

from ..engine import ti
from ..language.arguments import ARRAY
from ..language.bundles import ContactOptions, Obstacles
from .obstacles import gap_and_normal


@functools.cache
def make_gaps(shapes: tuple[str, ...]):
    """Return the kernel gaps(records, motion, positions [n, 3], gaps_out [n]) for obstacle 0, memoised."""
    options = ContactOptions(shapes=shapes)

    @ti.kernel
    def gaps(records: ARRAY, motion: ARRAY, positions: ARRAY, gaps_out: ARRAY):
        obstacles = ti.static(Obstacles(records=records, motion=motion, options=options))
        for i in range(gaps_out.shape[0]):
            x = ti.Vector([positions[3 * i + j] for j in range(3)])
            gap, _normal = gap_and_normal(obstacles, 0, x)
            gaps_out[i] = gap

    return gaps
