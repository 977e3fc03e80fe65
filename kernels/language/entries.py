"""Three numbers of a flat array as a vector."""

from ..engine import ti


@ti.func
def three(values: ti.template(), place):
    """Return numbers place, place + 1, place + 2 of an array."""
    return ti.Vector([values[place + j] for j in ti.static(range(3))])


@ti.func
def put_three(values: ti.template(), place, vector):
    """Set these three numbers of an array."""
    for j in ti.static(range(3)):
        values[place + j] = vector[j]


@ti.func
def row(values: ti.template(), s):
    """Return entry s of an array [.., 3]."""
    return three(values, 3 * s)
