"""Copies between arrays of a device, without the host.

Each has a fixed number of threads, of which each takes numbers at the distance of this number: a loop of a length known
only at run time costs a further launch.
"""

from ..engine import ti
from ..lanes import MOST_THREADS
from .arguments import ARRAY, INDEX
from .threads import turns_of


@ti.kernel
def copy_reals(source: ARRAY, first: ti.i32, target: ARRAY, start: ti.i32, count: ti.i32):
    """Copy `count` numbers from place `first` of the source on to place `start` of the target on."""
    for t in range(MOST_THREADS):
        for turn in range(turns_of(t, MOST_THREADS, count)):
            i = t + turn * MOST_THREADS
            target[start + i] = source[first + i]


@ti.kernel
def copy_wholes(source: INDEX, first: ti.i32, target: INDEX, start: ti.i32, count: ti.i32):
    """Copy whole numbers as `copy_reals`."""
    for t in range(MOST_THREADS):
        for turn in range(turns_of(t, MOST_THREADS, count)):
            i = t + turn * MOST_THREADS
            target[start + i] = source[first + i]
