"""Neighbouring numbers of an array as the lanes of one vector; kernels with lanes need KEEP_VECTORS."""

import taichi as ti

MASK = 0x3FFFFFFF  # on an index: it tells the compiler that the next ones cannot overflow, and whole vectors are loaded


@ti.func
def load(array: ti.template(), at, width: ti.template()):
    """Lanes at, at + 1, ... of an array."""
    start = at & MASK
    return ti.Vector([array[start + lane] for lane in range(width)])


@ti.func
def store(array: ti.template(), at, values, width: ti.template()):
    """Write lanes at, at + 1, ... of an array."""
    start = at & MASK
    for lane in ti.static(range(width)):
        array[start + lane] = values[lane]
