"""Table of places: where the data of MPRGP stand in `System.response` (static/node_basis.py, static/mprgp.py).

Host and kernels share the table. A solve by sweeps needs only the components before these.
"""

from typing import NamedTuple


class Places(NamedTuple):
    """First component in `System.response` of each vector or matrix of MPRGP; `end`: number of components.

    basis: T row by row; inverse: T^-t; bound: lower bound of z_1; position: z; gradient: K z - b; direction: p;
    product: K z or K p.
    """

    basis: int
    inverse: int
    bound: int
    position: int
    gradient: int
    direction: int
    product: int
    end: int


def places(block: int) -> Places:
    """Return the places of nodes with `block` components, behind those of the sweeps."""
    basis = block + 1
    inverse = basis + block * block
    bound = inverse + block * block
    return Places(basis, inverse, bound, *(bound + 1 + i * block for i in range(5)))


PLACES = {block: places(block) for block in (1, 3)}
