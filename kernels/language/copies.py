"""Copies between arrays of a device, without the host.

Each has a fixed number of threads, of which each takes numbers at the distance of this number: a loop of a length known
only at run time costs a further launch.
"""

from ..engine import ti
from ..lanes import MOST_THREADS
from .arguments import ARRAY, INDEX
from .threads import turns_of


@ti.kernel
def copy_part(source: ARRAY, first: ti.i32, target: ARRAY):
    """Copy as many numbers as the target has, from place `first` of the source on."""
    for t in range(MOST_THREADS):
        for turn in range(turns_of(t, MOST_THREADS, target.shape[0])):
            i = t + turn * MOST_THREADS
            target[i] = source[first + i]


@ti.kernel
def copy_into(source: ARRAY, target: ARRAY, first: ti.i32):
    """Copy all numbers of the source to the target, from place `first` of it on."""
    for t in range(MOST_THREADS):
        for turn in range(turns_of(t, MOST_THREADS, source.shape[0])):
            i = t + turn * MOST_THREADS
            target[first + i] = source[i]


@ti.kernel
def copy_wholes(source: INDEX, target: INDEX):
    """Copy an array of whole numbers."""
    for t in range(MOST_THREADS):
        for turn in range(turns_of(t, MOST_THREADS, target.shape[0])):
            i = t + turn * MOST_THREADS
            target[i] = source[i]
