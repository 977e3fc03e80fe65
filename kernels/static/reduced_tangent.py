"""Stiffness between the contact nodes of one-point hexes (`elements.hex8_reduced`), hourglass stiffness included.

    A_ab = V (A_ab of surface_tangent with the mean gradients G) + kappa (sum over modes h of gamma_ha gamma_hb) I
    G_a = 1/V int grad N_a dV,   gamma_ha = h_a - sum over k of (h_k x_k) . G_a

h are the four hourglass vectors, kappa the hourglass stiffness (elements/hex8_reduced.py). The mean gradients are
integrated by quadrature, which is fast enough for contact cells. Without the second part K_KK would be singular: the
mean gradient of a hex does not change when its contact nodes move in an hourglass pattern.
"""

import functools

from ..elements import FUNCTIONS
from ..elements.hex8_reduced import HOURGLASS, softened
from ..engine import ti
from ..lanes import (
    CONTACT_BLOCK,
    FIRST_CELL,
    GRADIENTS_AT,
    LAST_CELL,
    MATERIAL_AT,
    MEMORY_AT,
    NODES_AT,
    POINTS,
    WEIGHTS_AT,
    WIDTH,
)
from ..language.entries import row
from ..language.point_memory import constants_of, tangent_at
from ..language.threads import item, turns
from ..materials import LAWS
from .surface_tangent import add_pair

CORNERS = 8


@ti.func
def hourglass_modes(a):
    """Return (r1 r2, r1 r3, r2 r3, r1 r2 r3) at corner a in VTK order."""
    r1, r2, r3 = 2.0 * (((a + 1) >> 1) & 1) - 1.0, 2.0 * ((a >> 1) & 1) - 1.0, 2.0 * (a >> 2) - 1.0
    return ti.Vector([r1 * r2, r1 * r3, r2 * r3, r1 * r2 * r3])


@functools.cache
def make_reduced_tangent(kind: str, law: str, block: int):
    """Return reduced_tangent(body, contact, pairs, number), which fills pairs.values as `surface_tangent` does."""
    law_of = LAWS[law]
    parts, size = law_of.tangents, len(law_of.state)
    width, cell_memory = WIDTH, FUNCTIONS[kind].points * size

    @ti.func
    def tangent_of_cell(
        body: ti.template(), basis: ti.template(), pairs: ti.template(), at, first_cell, gradients,
        parameters, stiff, cell,
    ):  # fmt: skip
        slopes = ti.Vector.zero(ti.f64, 3 * CORNERS)  # G of every corner
        moved = ti.Vector.zero(ti.f64, 3 * CORNERS)  # M G of every corner
        gammas = ti.Vector.zero(ti.f64, 4 * CORNERS)
        own = cell - first_cell
        first = pairs.blocks[at + NODES_AT] + own * CORNERS
        place = pairs.blocks[at + MEMORY_AT] + own // width * (cell_memory * width) + own % width
        for i in range(pairs.start[cell] * block * block, pairs.start[cell + 1] * block * block):
            pairs.values[i] = 0.0
        origin = pairs.cell_nodes[first]
        volume = 0.0
        for q in range(pairs.blocks[at + POINTS]):
            jacobian = ti.Matrix.zero(ti.f64, 3, 3)
            for a in range(CORNERS):
                x = row(body.position, pairs.cell_nodes[first + a])
                jacobian += x.outer_product(row(pairs.shape_gradients, gradients + q * CORNERS + a))
            weight = pairs.shape_gradients[pairs.blocks[at + WEIGHTS_AT] + q] * jacobian.determinant()
            volume += weight
            turned = weight * jacobian.inverse().transpose()
            for a in range(CORNERS):
                g = turned @ row(pairs.shape_gradients, gradients + q * CORNERS + a)
                for j in ti.static(range(3)):
                    slopes[3 * a + j] += g[j]
        slope = ti.Matrix.zero(ti.f64, 3, 3)
        twist = ti.Matrix.zero(ti.f64, 4, 3)
        square = 0.0
        for a in range(CORNERS):
            g = row(slopes, a) / volume
            square += g.dot(g)
            node = pairs.cell_nodes[first + a]
            slope += (row(body.u, node) - row(body.u, origin)).outer_product(g)
            arm = row(body.position, node) - row(body.position, origin)
            twist += hourglass_modes(a).outer_product(arm)
            for j in ti.static(range(3)):
                slopes[3 * a + j] = g[j]
        kappa = HOURGLASS * stiff * volume * square / 8.0
        if ti.static(law_of.plastic):
            kappa *= softened(law_of, [body.memory[place + i * width] for i in range(size)], parameters)
        f = ti.Matrix.identity(ti.f64, 3) + slope
        for a in range(CORNERS):
            gamma = hourglass_modes(a) - twist @ row(slopes, a)
            for h in ti.static(range(4)):
                gammas[4 * a + h] = gamma[h]
        for p in range(pairs.start[cell], pairs.start[cell + 1]):
            left, right = pairs.corners[2 * p], pairs.corners[2 * p + 1]
            same = 0.0
            for h in ti.static(range(4)):
                same += kappa * gammas[4 * left + h] * gammas[4 * right + h]
            add_pair(pairs, basis, p, same * ti.Matrix.identity(ti.f64, 3), block, False)
        for part in ti.static(parts):
            data = tangent_at(part, f, parameters, 0.0, body, place, 0, size, width)
            for a in range(CORNERS):
                mg = part.corner(data, row(slopes, a))
                for j in ti.static(range(3)):
                    moved[3 * a + j] = mg[j]
            for p in range(pairs.start[cell], pairs.start[cell + 1]):
                left, right = pairs.corners[2 * p], pairs.corners[2 * p + 1]
                value = volume * part.pair(
                    data, row(slopes, left), row(slopes, right), row(moved, left), row(moved, right)
                )
                add_pair(pairs, basis, p, value, block, False)

    @ti.func
    def reduced_tangent(body: ti.template(), contact: ti.template(), pairs: ti.template(), number):
        basis = ti.static(contact.basis)
        at = number * CONTACT_BLOCK
        first_cell, gradients = pairs.blocks[at + FIRST_CELL], pairs.blocks[at + GRADIENTS_AT]
        parameters = constants_of(body, pairs.blocks[at + MATERIAL_AT], law_of)
        stiff = law_of.modulus(parameters)
        for turn in range(turns(contact, pairs.blocks[at + LAST_CELL] - first_cell)):
            cell = first_cell + item(contact, turn)
            tangent_of_cell(body, basis, pairs, at, first_cell, gradients, parameters, stiff, cell)

    return reduced_tangent
