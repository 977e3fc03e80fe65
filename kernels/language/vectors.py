"""Load and store of contiguous numbers of an array as the lanes of one vector; such kernels need KEEP_VECTORS."""

from ..engine import ti

MASK = 0x3FFFFFFF  # of an index: with it the compiler knows that at + 1, ... do not overflow, and loads whole vectors


@ti.func
def load(array: ti.template(), at, width: ti.template()):
    """Return numbers at, at + 1, ... of an array as a vector."""
    start = at & MASK
    return ti.Vector([array[start + lane] for lane in range(width)])


@ti.func
def store(array: ti.template(), at, values, width: ti.template()):
    """Store a vector as numbers at, at + 1, ... of an array."""
    start = at & MASK
    for lane in ti.static(range(width)):
        array[start + lane] = values[lane]
