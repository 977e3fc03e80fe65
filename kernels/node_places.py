"""Where the data of MPRGP stand in `System.push`, component by component (node_basis.py, mprgp.py).

Host and kernels agree on them; a solve by sweeps has the components before them alone.
"""

from typing import NamedTuple


class Places(NamedTuple):
    """First components in `System.push` of the data of MPRGP; `end` is the number of all components.

    basis: T row by row; inverse: T^-t; bound: of z_1; position: z; gradient, direction, product: see mprgp.py.
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
    """Places behind the components that the sweeps have in `System.push`."""
    basis = block + 1
    inverse = basis + block * block
    bound = inverse + block * block
    return Places(basis, inverse, bound, *(bound + 1 + i * block for i in range(5)))


PLACES = {block: places(block) for block in (1, 3)}
