"""Stiffness between the contact nodes of a cell: B_a^t A_ab B_b with A_ab = int grad N_a . d2W/dF dF . grad N_b dX.

A sum over the parts of the law (`Tangent` of materials/law.py). Only contact cells and only pairs of their corners in
K, each once: A_ba = A_ab^t. With one volume change per cell (elements/hex8_mean_dilatation.py: modulus k, pressure p,
volumes V at rest and v now) the points have p in place of k (J - 1), and there is the stiffness of the change itself,

    A_ab += k/V (dv/du_a) x (dv/du_b),   dv/du_a = int J F^-t G_a dX   (linear elastic: int G_a dX)
"""

import functools

import taichi as ti

from .lanes import CHUNKS, LAW_AT, TABLE
from .massless_node import basis_of
from .materials import LAWS
from .point_memory import tangent_at

MOST_CORNERS = 8


@ti.func
def corner(values: ti.template(), a):
    return ti.Vector([values[3 * a + j] for j in ti.static(range(3))])


@ti.func
def gradients_at(body: ti.template(), pairs: ti.template(), first, corners, q):
    """dX/dr at Gauss point q of the cell whose corners start at first, and du/dr."""
    jacobian = ti.Matrix.zero(ti.f64, 3, 3)
    slope = ti.Matrix.zero(ti.f64, 3, 3)
    for a in range(corners):
        at = 3 * (q * corners + a)
        here, origin = 3 * pairs.cell_nodes[first + a], 3 * pairs.cell_nodes[first]
        for i, j in ti.static(ti.ndrange(3, 3)):
            jacobian[i, j] += body.position[here + i] * pairs.shape_gradients[at + j]
            slope[i, j] += (body.u[here + i] - body.u[origin + i]) * pairs.shape_gradients[at + j]
    return jacobian, slope


@ti.func
def cell_volume(body: ti.template(), pairs: ti.template(), first, corners, linear: ti.template()):
    """V, v/V - 1 and dv/du of every corner; for the linear law 0 for the second, and dv/du at rest."""
    volume, change = 0.0, 0.0
    spread = ti.Vector.zero(ti.f64, 3 * MOST_CORNERS)
    for q in range(pairs.weights.shape[0]):
        jacobian, slope = gradients_at(body, pairs, first, corners, q)
        volume += pairs.weights[q] * jacobian.determinant()
        now = jacobian if ti.static(linear) else jacobian + slope
        weight = pairs.weights[q] * now.determinant()
        change += weight
        turned = weight * now.inverse().transpose()
        for a in range(corners):
            g = turned @ corner(pairs.shape_gradients, q * corners + a)
            for j in ti.static(range(3)):
                spread[3 * a + j] += g[j]
    return volume, change / volume - 1.0, spread


@ti.func
def add_pair(pairs: ti.template(), basis: ti.template(), p, value, block: ti.template(), plain: ti.template()):
    """Add a stiffness [3, 3] to that of pair p, in the bases of its two nodes; plain: they are the identity."""
    if ti.static(plain):
        add_block(pairs, p, value, block)
    else:
        left, right = basis_of(basis, pairs.nodes[2 * p], block), basis_of(basis, pairs.nodes[2 * p + 1], block)
        add_block(pairs, p, left.transpose() @ value @ right, block)


@ti.func
def add_block(pairs: ti.template(), p, value, block: ti.template()):
    for i, j in ti.static(ti.ndrange(block, block)):
        place = (p * block + i) * block + j
        pairs.values[place] = pairs.values[place] + value[i, j]  # "+=" would be an atomic


@functools.cache
def make_surface_tangent(law: str, block: int, plain: bool, mean: bool = False, width: int = 1):
    """surface_tangent(body, basis, pairs) fills pairs.values; plain: every basis is the identity.

    mean: with one volume change per cell; width: lanes of a pack of cells.
    """
    parts, linear = LAWS[law].tangents, LAWS[law].linear
    count, size = len(LAWS[law].parameters), len(LAWS[law].state)

    @ti.func
    def surface_tangent(body: ti.template(), basis: ti.template(), pairs: ti.template()):
        parameters = [body.params[LAW_AT + i] for i in range(count)]
        at_points = [0.0 if ti.static(mean and i == 0) else parameters[i] for i in ti.static(range(count))]
        place = 0  # of the contact cells in body.memory_start
        if ti.static(size > 0):
            place = body.chunk_table[CHUNKS * TABLE] * width
        corners = pairs.cell_nodes.shape[0] // (pairs.start.shape[0] - 1)
        for cell in range(pairs.start.shape[0] - 1):
            slopes = ti.Vector.zero(ti.f64, 3 * MOST_CORNERS)  # G of every corner
            moved = ti.Vector.zero(ti.f64, 3 * MOST_CORNERS)  # M G of every corner
            first = cell * corners
            for i in range(pairs.start[cell] * block * block, pairs.start[cell + 1] * block * block):
                pairs.values[i] = 0.0
            pressure = 0.0
            if ti.static(mean):
                stiff = parameters[0]
                reference, change, spread = cell_volume(body, pairs, first, corners, linear)
                pressure = stiff * change
                if ti.static(linear):
                    pressure = 0.0
                for p in range(pairs.start[cell], pairs.start[cell + 1]):
                    left, right = corner(spread, pairs.corners[2 * p]), corner(spread, pairs.corners[2 * p + 1])
                    add_pair(pairs, basis, p, (stiff / reference * left).outer_product(right), block, plain)
            for q in range(pairs.weights.shape[0]):
                jacobian, slope = gradients_at(body, pairs, first, corners, q)
                inverse = jacobian.inverse()
                # A_ab is linear in G_a and in G_b: each takes the root of the weight
                turned = ti.sqrt(pairs.weights[q] * jacobian.determinant()) * inverse.transpose()
                f = ti.Matrix.identity(ti.f64, 3) + slope @ inverse
                for part in ti.static(parts):
                    data = tangent_at(part, f, at_points, pressure, body, place + cell, q, size, width)
                    for a in range(corners):
                        g = turned @ corner(pairs.shape_gradients, q * corners + a)
                        mg = part.corner(data, g)
                        for j in ti.static(range(3)):
                            slopes[3 * a + j] = g[j]
                            moved[3 * a + j] = mg[j]
                    for p in range(pairs.start[cell], pairs.start[cell + 1]):
                        left, right = pairs.corners[2 * p], pairs.corners[2 * p + 1]
                        value = part.pair(
                            data, corner(slopes, left), corner(slopes, right), corner(moved, left), corner(moved, right)
                        )
                        add_pair(pairs, basis, p, value, block, plain)

    return surface_tangent
