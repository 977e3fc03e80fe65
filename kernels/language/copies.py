"""Copies between arrays of a device, without the host."""

from ..engine import ti
from .arguments import ARRAY, INDEX


@ti.kernel
def copy_part(source: ARRAY, first: ti.i32, target: ARRAY):
    """Copy as many numbers as the target has, from place `first` of the source on."""
    for i in range(target.shape[0]):
        target[i] = source[first + i]


@ti.kernel
def copy_into(source: ARRAY, target: ARRAY, first: ti.i32):
    """Copy all numbers of the source to the target, from place `first` of it on."""
    for i in range(source.shape[0]):
        target[first + i] = source[i]


@ti.kernel
def copy_wholes(source: INDEX, target: INDEX):
    """Copy an array of whole numbers."""
    for i in range(target.shape[0]):
        target[i] = source[i]
