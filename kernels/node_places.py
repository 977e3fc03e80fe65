"""Tables of places in `System.response`: of MPRGP (static/node_basis.py, static/mprgp.py), of sweeps with friction.

Host and kernels share the tables. A solve by sweeps without friction needs only the components before these.
"""

from typing import NamedTuple


class Places(NamedTuple):
    """First component in `System.response` of each vector or matrix of MPRGP; `end`: number of components.

    basis: T row by row; inverse: T^-t; bound: lower bound of z_1; position: z; gradient: K z - b; direction: p;
    product: K z or K p. With pairs of bodies also diagonal: the diagonal blocks of K_KK; `coupled_end` is then the
    number of components. Nodes with several rows have more bounds behind these, and the rows of all bounds;
    `several_end` is then the number of components.
    """

    basis: int
    inverse: int
    bound: int
    position: int
    gradient: int
    direction: int
    product: int
    end: int
    coupled_end: int
    several_end: int

    @property
    def trial(self) -> int:
        """Return the first component of the trial motion of the solve with friction between bodies."""
        return self.gradient

    @property
    def diagonal(self) -> int:
        """Return the first component of the diagonal blocks."""
        return self.end

    @property
    def bounds(self) -> tuple[int, ...]:
        """Return the components of the lower bounds of z_1, z_2, z_3."""
        rows = self.rows[0]
        return self.bound, *range(self.coupled_end, rows)

    @property
    def rows(self) -> range:
        """Return the components that hold the row of the node to which each bound belongs."""
        block = (self.several_end - self.coupled_end + 1) // 2
        return range(self.several_end - block, self.several_end)


def places(block: int) -> Places:
    """Return the places of nodes with `block` components, behind those of the sweeps."""
    basis = block + 1
    inverse = basis + block * block
    bound = inverse + block * block
    end = bound + 1 + 4 * block
    coupled_end = end + block * block
    vectors = (bound + 1 + i * block for i in range(4))
    return Places(basis, inverse, bound, *vectors, end, coupled_end, coupled_end + 2 * block - 1)


PLACES = {block: places(block) for block in (1, 3)}


class FrictionPlaces(NamedTuple):
    """First component of each number of sweeps with friction where a node has one row (static/friction_lanes.py).

    response: D^-1 n; across: T in the massless components, row by row; turned: D^-1 T^t, column by column; mobility:
    entries 11, 12, 22 of T D^-1 T^t; coupling: T D^-1 n; slip: before the sweeps; friction: of the last sweep;
    compliance: n D^-1 n + e; coefficient; cap: largest friction whatever the pressing force; pressing: of the last
    sweep; shift: that of its friction (contact/friction.py); end: number of components.
    """

    response: int = 0
    across: int = 3
    turned: int = 9
    mobility: int = 15
    coupling: int = 18
    slip: int = 20
    friction: int = 22
    compliance: int = 24
    coefficient: int = 25
    cap: int = 26
    pressing: int = 27
    shift: int = 28
    end: int = 29


FRICTION_PLACES = FrictionPlaces()
