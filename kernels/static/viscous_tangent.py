"""Stiffness of the bulk viscosity of metals between the contact nodes of a cell, whose rates the static solve changes.

With V' = (V - V before)/dt, to third order, the force f_a = c V' dv/dx_a of a cell (bulk_viscosity.py) has the tangent

    A_ab += c'/dt (dv/dx_a) x (dv/dx_b),   c' = rho V r/(corners sum over k of |dv/dx_k|^2)

with the rate r of the cell that counts its quadratic part twice. Without it small steps, in which rates are large, make
the iteration diverge.
"""

import functools

from ..elements import FUNCTIONS
from ..engine import ti
from ..lanes import CONTACT_BLOCK, FIRST_CELL, LANE_AT, LAST_CELL, MASSLESS, NODES_AT
from ..language.entries import row
from .surface_tangent import add_pair, cell_volume


@functools.cache
def make_viscous_tangent(kind: str, block: int, plain: bool):
    """Return viscous_tangent(body, basis, pairs, number), which adds to pairs.values of contact block `number`."""
    corners = FUNCTIONS[kind].corners

    @ti.func
    def viscous_tangent(body: ti.template(), basis: ti.template(), pairs: ti.template(), number):
        at = number * CONTACT_BLOCK
        first_cell = pairs.blocks[at + FIRST_CELL]
        rates = 1 + 3 * int(body.params[MASSLESS]) + pairs.blocks[at + LANE_AT]
        for cell in range(first_cell, pairs.blocks[at + LAST_CELL]):
            own = cell - first_cell
            first = pairs.blocks[at + NODES_AT] + own * corners
            volume, _change, spread = cell_volume(body, pairs, at, first, corners, False)
            stiff = body.bulk_viscosity[rates + own] * volume / (corners * spread.norm_sqr())
            for p in range(pairs.start[cell], pairs.start[cell + 1]):
                left, right = row(spread, pairs.corners[2 * p]), row(spread, pairs.corners[2 * p + 1])
                add_pair(pairs, basis, p, (stiff * left).outer_product(right), block, plain)

    return viscous_tangent
