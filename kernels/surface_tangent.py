"""Stiffness between the contact nodes of a cell: B_a^t A_ab B_b with A_ab = int grad N_a . d2W/dF dF . grad N_b dX.

A sum over the parts of the law (law_tangents.py). Only contact cells and only pairs of their corners in K, each once:
A_ba = A_ab^t. With one volume change per cell (mean_dilatation.py: modulus k, pressure p, volumes V at rest and v now)
the points have p in place of k (J - 1), and there is the stiffness of the change itself,

    A_ab += k/V (dv/du_a) x (dv/du_b),   dv/du_a = int J F^-t G_a dX   (linear elastic: int G_a dX)
"""

import functools

import taichi as ti

from .law_tangents import MEAN_PARTS, PARTS
from .massless_node import basis_of

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


@functools.cache
def make_surface_tangent(law: str, block: int, plain: bool, mean: bool = False):
    """surface_tangent(body, basis, pairs, begin, end) fills pairs.values of these cells.

    plain: every basis is the identity; mean: with one volume change per cell.
    """
    parts, moduli_of = (MEAN_PARTS if mean else PARTS)[law]
    linear = law == "linear_elastic"

    @ti.func
    def surface_tangent(body: ti.template(), basis: ti.template(), pairs: ti.template(), begin, end):
        moduli = moduli_of(body.params)
        corners = pairs.cell_nodes.shape[0] // (pairs.start.shape[0] - 1)
        for cell in range(begin, end):
            slopes = ti.Vector.zero(ti.f64, 3 * MOST_CORNERS)  # G of every corner
            moved = ti.Vector.zero(ti.f64, 3 * MOST_CORNERS)  # M G of every corner
            first = cell * corners
            for i in range(pairs.start[cell] * block * block, pairs.start[cell + 1] * block * block):
                pairs.values[i] = 0.0
            pressure = 0.0
            if ti.static(mean):
                stiff = moduli[0][0]
                reference, change, spread = cell_volume(body, pairs, first, corners, linear)
                pressure = stiff * change
                if ti.static(linear):
                    pressure = 0.0
                for p in range(pairs.start[cell], pairs.start[cell + 1]):
                    left, right = corner(spread, pairs.corners[2 * p]), corner(spread, pairs.corners[2 * p + 1])
                    if ti.static(plain):
                        for i, j in ti.static(ti.ndrange(3, 3)):
                            pairs.values[(p * 3 + i) * 3 + j] = stiff / reference * left[i] * right[j]
                    else:
                        into_left = basis_of(basis, pairs.nodes[2 * p], block).transpose() @ left
                        into_right = basis_of(basis, pairs.nodes[2 * p + 1], block).transpose() @ right
                        for i, j in ti.static(ti.ndrange(block, block)):
                            value = stiff / reference * into_left[i] * into_right[j]
                            pairs.values[(p * block + i) * block + j] = value
            for q in range(pairs.weights.shape[0]):
                jacobian, slope = gradients_at(body, pairs, first, corners, q)
                inverse = jacobian.inverse()
                volume = pairs.weights[q] * jacobian.determinant()
                f = ti.Matrix.identity(ti.f64, 3) + slope @ inverse
                for part in ti.static(range(len(parts))):
                    lam, mu = moduli[part][0], moduli[part][1]
                    if ti.static(mean and part == 0):
                        lam = pressure
                    m, t, c1, c2, r = parts[part][0](f, volume * lam, volume * mu)
                    for a in range(corners):
                        g = inverse.transpose() @ corner(pairs.shape_gradients, q * corners + a)
                        mg = m @ g
                        for j in ti.static(range(3)):
                            slopes[3 * a + j] = g[j]
                            moved[3 * a + j] = mg[j]
                    for p in range(pairs.start[cell], pairs.start[cell + 1]):
                        left, right = pairs.corners[2 * p], pairs.corners[2 * p + 1]
                        ga, gb = corner(slopes, left), corner(slopes, right)
                        a, b = corner(moved, left), corner(moved, right)
                        same = ga.dot(t @ gb)
                        if ti.static(plain):
                            for i, j in ti.static(ti.ndrange(3, 3)):
                                value = c1 * b[i] * a[j] + c2 * a[i] * b[j]
                                if ti.static(i == j):
                                    value += same
                                if ti.static(parts[part][1]):
                                    value += ga.dot(gb) * r[i, j]
                                place = (p * 3 + i) * 3 + j
                                pairs.values[place] = pairs.values[place] + value  # "+=" would be an atomic
                        else:
                            basis_a = basis_of(basis, pairs.nodes[2 * p], block)
                            basis_b = basis_of(basis, pairs.nodes[2 * p + 1], block)
                            aa, ab = basis_a.transpose() @ a, basis_a.transpose() @ b
                            ba, bb = basis_b.transpose() @ a, basis_b.transpose() @ b
                            shared = same * (basis_a.transpose() @ basis_b)
                            if ti.static(parts[part][1]):
                                shared += ga.dot(gb) * (basis_a.transpose() @ r @ basis_b)
                            for i, j in ti.static(ti.ndrange(block, block)):
                                value = shared[i, j] + c1 * ab[i] * ba[j] + c2 * aa[i] * bb[j]
                                place = (p * block + i) * block + j
                                pairs.values[place] = pairs.values[place] + value

    return surface_tangent
