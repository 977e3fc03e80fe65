"""Stiffness of the viscosity of contact cells of a metal between their contact nodes (contact/cell_viscosity.py).

    A_ab += eta/dt [(lambda/v) (dv/dx_a) x (dv/dx_b) + mu int (g_b x g_a + (g_a.g_b) I) dv],   g_a = grad N_a, present

The viscous stress of a metal keeps its elastic constants where it yields: a multiple of the plastic tangent, which is
some ten times softer, makes the iteration diverge. One volume change per cell is enough for a tangent.
"""

import functools

from ..contact.cell_viscosity import RATE, cells_place
from ..elements import FUNCTIONS
from ..engine import ti
from ..lanes import CONTACT_BLOCK, FIRST_CELL, GRADIENTS_AT, LAME, LAST_CELL, MATERIAL_AT, NODES_AT, POINTS, WEIGHTS_AT
from ..language.entries import row
from ..language.threads import item, turns
from .surface_tangent import MAXIMUM_CORNERS, add_pair, cell_volume, gradients_at


@functools.cache
def make_damping_tangent(kind: str, block: int, plain: bool):
    """Return damping_tangent(body, contact, pairs, viscous, number), which adds to pairs.values of a contact block."""
    corners = FUNCTIONS[kind].corners

    @ti.func
    def damping_tangent(
        body: ti.template(), contact: ti.template(), pairs: ti.template(), viscous: ti.template(), number
    ):
        basis = ti.static(contact.basis)
        at = number * CONTACT_BLOCK
        gradients, material = pairs.blocks[at + GRADIENTS_AT], pairs.blocks[at + MATERIAL_AT] + LAME
        first_cell = pairs.blocks[at + FIRST_CELL]
        for turn in range(turns(contact, pairs.blocks[at + LAST_CELL] - first_cell)):
            cell = first_cell + item(contact, turn)
            factor = viscous[RATE] * viscous[cells_place(viscous) + cell]
            first = pairs.blocks[at + NODES_AT] + (cell - first_cell) * corners
            volume, change, spread = cell_volume(body, pairs, at, first, corners, False)
            stiff = factor * body.params[material] / (volume * (1.0 + change))
            for p in range(pairs.start[cell], pairs.start[cell + 1]):
                left, right = row(spread, pairs.corners[2 * p]), row(spread, pairs.corners[2 * p + 1])
                add_pair(pairs, basis, p, (stiff * left).outer_product(right), block, plain)
            slopes = ti.Vector.zero(ti.f64, 3 * MAXIMUM_CORNERS)  # g of every corner
            for q in range(pairs.blocks[at + POINTS]):
                jacobian, slope = gradients_at(body, pairs, first, gradients, corners, q)
                now = jacobian + slope
                turned = now.inverse().transpose()
                for a in range(corners):
                    g = turned @ row(pairs.shape_gradients, gradients + q * corners + a)
                    for j in ti.static(range(3)):
                        slopes[3 * a + j] = g[j]
                weight = pairs.shape_gradients[pairs.blocks[at + WEIGHTS_AT] + q] * now.determinant()
                shear = factor * body.params[material + 1] * weight
                for p in range(pairs.start[cell], pairs.start[cell + 1]):
                    ga, gb = row(slopes, pairs.corners[2 * p]), row(slopes, pairs.corners[2 * p + 1])
                    value = gb.outer_product(ga) + ga.dot(gb) * ti.Matrix.identity(ti.f64, 3)
                    add_pair(pairs, basis, p, shear * value, block, plain)

    return damping_tangent
