"""Copies between arrays of a device, without the host."""

from ..engine import ti
from .arguments import ARRAY


@ti.kernel
def copy_part(source: ARRAY, first: ti.i32, target: ARRAY):
    """Copy as many numbers as the target has, from place `first` of the source on."""
    for i in range(target.shape[0]):
        target[i] = source[first + i]
