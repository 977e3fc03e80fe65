"""Stiffness between the contact nodes of a cell: B_a^t A_ab B_b with A_ab = int grad N_a . d2W/dF dF . grad N_b dX.

B_a is the basis of contact node a, G_a = grad N_a; the integrand is a sum over the parts of the law (`Tangent` of
materials/law.py). Only contact cells enter, and each pair of their contact nodes once, since A_ba = A_ab^t. With one
volume change per cell (elements/hex8_mean_dilatation.py: modulus k, pressure p, volumes V at rest and v now) p replaces
k (J - 1) at the points, and the volume change of the cell adds the stiffness

    A_ab += k/V (dv/du_a) x (dv/du_b),   dv/du_a = int J F^-t G_a dX   (linear elastic: int G_a dX)

Where volume changes are averaged at nodes, averaged_tangent.py adds theirs; it also couples nodes of different cells.
"""

import functools

from ..elements import FUNCTIONS
from ..elements.tet4_node_averaged import GUARD
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
from ..language.point_memory import constants_of, mean_of_points, tangent_at
from ..language.tensor3 import cofactor, determinant, plus_identity, product_transposed
from ..language.threads import item, turns
from ..language.vectors import load
from ..materials import LAWS
from .averaged_tangent import cell_pressure, store_spread
from .massless_node import basis_of
from .points_in_lanes import get_three, gradient, inner, numbers_of, pair_value, put_three, slopes_of, times

MAXIMUM_CORNERS = 8


@ti.func
def gradients_at(body: ti.template(), pairs: ti.template(), first, gradients, corners, q):
    """Return dX/dr and du/dr at Gauss point q of the cell whose corners start at first.

    gradients: start of the shape gradients of its kind of cells.
    """
    jacobian = ti.Matrix.zero(ti.f64, 3, 3)
    slope = ti.Matrix.zero(ti.f64, 3, 3)
    for a in range(corners):
        at = 3 * (gradients + q * corners + a)
        here, origin = 3 * pairs.cell_nodes[first + a], 3 * pairs.cell_nodes[first]
        for i, j in ti.static(ti.ndrange(3, 3)):
            jacobian[i, j] += body.position[here + i] * pairs.shape_gradients[at + j]
            slope[i, j] += (body.u[here + i] - body.u[origin + i]) * pairs.shape_gradients[at + j]
    return jacobian, slope


@ti.func
def cell_volume(body: ti.template(), pairs: ti.template(), at, first, corners, linear: ti.template()):
    """Return V, v/V - 1 and dv/du of every corner; for the linear law 0 as the second, and dv/du at rest.

    at: start of the numbers of the contact block of the cell; first: start of its corners.
    """
    gradients = pairs.blocks[at + GRADIENTS_AT]
    volume, change = 0.0, 0.0
    spread = ti.Vector.zero(ti.f64, 3 * MAXIMUM_CORNERS)
    for q in range(pairs.blocks[at + POINTS]):
        jacobian, slope = gradients_at(body, pairs, first, gradients, corners, q)
        volume += pairs.shape_gradients[pairs.blocks[at + WEIGHTS_AT] + q] * jacobian.determinant()
        now = jacobian if ti.static(linear) else jacobian + slope
        weight = pairs.shape_gradients[pairs.blocks[at + WEIGHTS_AT] + q] * now.determinant()
        change += weight
        turned = weight * now.inverse().transpose()
        for a in range(corners):
            g = turned @ row(pairs.shape_gradients, gradients + q * corners + a)
            for j in ti.static(range(3)):
                spread[3 * a + j] += g[j]
    return volume, change / volume - 1.0, spread


@ti.func
def add_pair(pairs: ti.template(), basis: ti.template(), p, value, block: ti.template(), plain: ti.template()):
    """Add a stiffness [3, 3] to pair p in the bases of its two nodes; plain: the bases are the identity."""
    if ti.static(plain):
        add_block(pairs, p, value, block)
    else:
        left, right = basis_of(basis, pairs.nodes[2 * p], block), basis_of(basis, pairs.nodes[2 * p + 1], block)
        add_block(pairs, p, left.transpose() @ value @ right, block)


@ti.func
def add_block(pairs: ti.template(), p, value, block: ti.template()):
    """Add a stiffness [block, block] to pair p."""
    for i, j in ti.static(ti.ndrange(block, block)):
        place = (p * block + i) * block + j
        pairs.values[place] = pairs.values[place] + value[i, j]  # "+=" would be an atomic


@functools.cache
def make_surface_tangent(kind: str, law: str, block: int, plain: bool, threads: int = 1):
    """Return surface_tangent(body, contact, pairs, number), which fills pairs.values of contact block `number`.

    kind, law: of the cells of the block; plain: every basis is the identity; threads: that share the cells.
    """
    law_of = LAWS[law]
    parts, linear, size = law_of.tangents, law_of.linear, len(law_of.state)
    functions, width = FUNCTIONS[kind], WIDTH
    mean, corners, cell_memory = functions.tangent == "mean-dilatation", functions.corners, functions.points * size
    averaged = functions.averaged
    in_lanes = threads == 1 and functions.points == width and all(part.form for part in parts)
    apart = mean or averaged  # the volume change enters apart from the points

    @ti.func
    def all_points(
        body: ti.template(), basis: ti.template(), pairs: ti.template(), at, first, gradients, cell, place, at_points,
        pressure,
    ):  # fmt: skip
        found = slopes_of(body, pairs, first, gradients, corners)
        minors = cofactor(found[0])
        volume = determinant(found[0], minors)
        h = product_transposed(found[1], minors)
        f = plus_identity([[h[i][j] / volume for j in range(3)] for i in range(3)], 1.0)
        weight = ti.sqrt(load(pairs.shape_gradients, pairs.blocks[at + WEIGHTS_AT], width) * volume) / volume
        slopes, moved = ti.Vector.zero(ti.f64, 3 * corners * width), ti.Vector.zero(ti.f64, 3 * corners * width)
        for part in ti.static(parts):
            rest = ti.static(part.form == "rest")
            numbers = numbers_of(part, f, at_points, pressure, body, place, size, rest)
            for a in range(corners):
                shape = gradient(pairs, gradients, corners, a)
                g = [weight * inner(minors[i], shape) for i in range(3)]
                put_three(slopes, a, g)
                put_three(moved, a, times(numbers, 0, g))
            for p in range(pairs.start[cell], pairs.start[cell + 1]):
                left, right = pairs.corners[2 * p], pairs.corners[2 * p + 1]
                ga, gb = get_three(slopes, left), get_three(slopes, right)
                value = pair_value(numbers, ga, gb, get_three(moved, left), get_three(moved, right), rest)
                add_pair(pairs, basis, p, value, block, plain)

    @ti.func
    def tangent_of_cell(
        body: ti.template(), basis: ti.template(), pairs: ti.template(), number, at, first_cell, gradients,
        parameters, at_points, cell,
    ):  # fmt: skip
        slopes = ti.Vector.zero(ti.f64, 3 * MAXIMUM_CORNERS)  # G of every corner
        moved = ti.Vector.zero(ti.f64, 3 * MAXIMUM_CORNERS)  # M G of every corner
        own = cell - first_cell
        first = pairs.blocks[at + NODES_AT] + own * corners
        place = pairs.blocks[at + MEMORY_AT] + own // width * (cell_memory * width) + own % width
        for i in range(pairs.start[cell] * block * block, pairs.start[cell + 1] * block * block):
            pairs.values[i] = 0.0
        pressure = 0.0
        if ti.static(averaged):
            volume, change, spread = cell_volume(body, pairs, at, first, corners, linear)
            store_spread(body, number, own, cell, spread)
            if ti.static(not linear):
                pressure = cell_pressure(body, pairs, number, own, first, law_of, parameters)
            if ti.static(law_of.plastic):
                pressure += GUARD * parameters[1] * change**3
                stiff = 3.0 * GUARD * parameters[1] * change**2
                for p in range(pairs.start[cell], pairs.start[cell + 1]):
                    left, right = row(spread, pairs.corners[2 * p]), row(spread, pairs.corners[2 * p + 1])
                    add_pair(pairs, basis, p, (stiff / volume * left).outer_product(right), block, plain)
        if ti.static(mean):
            stiff = parameters[0]
            reference, change, spread = cell_volume(body, pairs, at, first, corners, linear)
            pressure = stiff * change
            if ti.static(law_of.plastic):
                state = [mean_of_points(body, place, i, size, width, functions.points) for i in range(size)]
                volume = law_of.plastic.volume(change, parameters, state)
                pressure, stiff = volume[0], volume[2]
            if ti.static(linear):
                pressure = 0.0
            for p in range(pairs.start[cell], pairs.start[cell + 1]):
                left, right = row(spread, pairs.corners[2 * p]), row(spread, pairs.corners[2 * p + 1])
                add_pair(pairs, basis, p, (stiff / reference * left).outer_product(right), block, plain)
        if ti.static(in_lanes):
            all_points(body, basis, pairs, at, first, gradients, cell, place, at_points, pressure)
        else:
            for q in range(pairs.blocks[at + POINTS]):
                jacobian, slope = gradients_at(body, pairs, first, gradients, corners, q)
                inverse = jacobian.inverse()
                # A_ab is linear in G_a and in G_b: each takes the root of the weight
                weight = pairs.shape_gradients[pairs.blocks[at + WEIGHTS_AT] + q] * jacobian.determinant()
                turned = ti.sqrt(weight) * inverse.transpose()
                f = ti.Matrix.identity(ti.f64, 3) + slope @ inverse
                for part in ti.static(parts):
                    data = tangent_at(part, f, at_points, pressure, body, place, q, size, width)
                    for a in range(corners):
                        g = turned @ row(pairs.shape_gradients, gradients + q * corners + a)
                        mg = part.corner(data, g)
                        for j in ti.static(range(3)):
                            slopes[3 * a + j] = g[j]
                            moved[3 * a + j] = mg[j]
                    for p in range(pairs.start[cell], pairs.start[cell + 1]):
                        left, right = pairs.corners[2 * p], pairs.corners[2 * p + 1]
                        value = part.pair(
                            data, row(slopes, left), row(slopes, right), row(moved, left), row(moved, right)
                        )
                        add_pair(pairs, basis, p, value, block, plain)

    @ti.func
    def surface_tangent(body: ti.template(), contact: ti.template(), pairs: ti.template(), number):
        basis = ti.static(contact.basis)
        at = number * CONTACT_BLOCK
        first_cell, gradients = pairs.blocks[at + FIRST_CELL], pairs.blocks[at + GRADIENTS_AT]
        parameters = constants_of(body, pairs.blocks[at + MATERIAL_AT], law_of)
        at_points = [0.0 if ti.static(apart and i == 0) else parameters[i] for i in ti.static(range(len(parameters)))]
        for turn in range(turns(contact, pairs.blocks[at + LAST_CELL] - first_cell)):
            cell = first_cell + item(contact, turn)
            tangent_of_cell(body, basis, pairs, number, at, first_cell, gradients, parameters, at_points, cell)

    return surface_tangent
