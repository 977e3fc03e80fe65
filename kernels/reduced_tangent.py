"""Stiffness between the contact nodes of one-point hexes (`reduced_hex`), hourglass stiffness included.

    A_ab = V (A_ab of surface_tangent with the mean gradients G) + kappa (sum over modes h of gamma_ha gamma_hb) I
    G_a = 1/V int grad N_a dV,   gamma_ha = h_a - sum over k of (h_k x_k) . G_a

From the definitions, by quadrature, since only contact cells need it. Without the second part K_KK would be singular:
a one-point hex does not feel its contact nodes move against each other in an hourglass pattern.
"""

import functools

import taichi as ti

from .law_tangents import PARTS
from .massless_node import basis_of
from .reduced_hex import HOURGLASS
from .surface_tangent import corner

CORNERS = 8


@ti.func
def hourglass_modes(a):
    """(r1 r2, r1 r3, r2 r3, r1 r2 r3) at corner a in VTK order."""
    r1, r2, r3 = 2.0 * (((a + 1) >> 1) & 1) - 1.0, 2.0 * ((a >> 1) & 1) - 1.0, 2.0 * (a >> 2) - 1.0
    return ti.Vector([r1 * r2, r1 * r3, r2 * r3, r1 * r2 * r3])


@functools.cache
def make_reduced_tangent(law: str, block: int):
    """reduced_tangent(body, basis, pairs, begin, end) fills pairs.values, as `surface_tangent` does for others."""
    parts, moduli_of = PARTS[law]

    @ti.func
    def reduced_tangent(body: ti.template(), basis: ti.template(), pairs: ti.template(), begin, end):
        moduli = moduli_of(body.params)
        stiff = moduli[0][0] + 2.0 * moduli[0][1]  # lam + 2 mu at small strains, of Mooney-Rivlin too
        for cell in range(begin, end):
            slopes = ti.Vector.zero(ti.f64, 3 * CORNERS)  # G of every corner
            moved = ti.Vector.zero(ti.f64, 3 * CORNERS)  # M G of every corner
            gammas = ti.Vector.zero(ti.f64, 4 * CORNERS)
            first = cell * CORNERS
            origin = pairs.cell_nodes[first]
            volume = 0.0
            for q in range(pairs.weights.shape[0]):
                jacobian = ti.Matrix.zero(ti.f64, 3, 3)
                for a in range(CORNERS):
                    x = corner(body.position, pairs.cell_nodes[first + a])
                    jacobian += x.outer_product(corner(pairs.shape_gradients, q * CORNERS + a))
                weight = pairs.weights[q] * jacobian.determinant()
                volume += weight
                turned = weight * jacobian.inverse().transpose()
                for a in range(CORNERS):
                    g = turned @ corner(pairs.shape_gradients, q * CORNERS + a)
                    for j in ti.static(range(3)):
                        slopes[3 * a + j] += g[j]
            slope = ti.Matrix.zero(ti.f64, 3, 3)
            twist = ti.Matrix.zero(ti.f64, 4, 3)
            square = 0.0
            for a in range(CORNERS):
                g = corner(slopes, a) / volume
                square += g.dot(g)
                node = pairs.cell_nodes[first + a]
                slope += (corner(body.u, node) - corner(body.u, origin)).outer_product(g)
                arm = corner(body.position, node) - corner(body.position, origin)
                twist += hourglass_modes(a).outer_product(arm)
                for j in ti.static(range(3)):
                    slopes[3 * a + j] = g[j]
            kappa = HOURGLASS * stiff * volume * square / 8.0
            f = ti.Matrix.identity(ti.f64, 3) + slope
            for a in range(CORNERS):
                gamma = hourglass_modes(a) - twist @ corner(slopes, a)
                for h in ti.static(range(4)):
                    gammas[4 * a + h] = gamma[h]
            for part in ti.static(range(len(parts))):
                m, t, c1, c2, r = parts[part][0](f, volume * moduli[part][0], volume * moduli[part][1])
                for a in range(CORNERS):
                    mg = m @ corner(slopes, a)
                    for j in ti.static(range(3)):
                        moved[3 * a + j] = mg[j]
                for p in range(pairs.start[cell], pairs.start[cell + 1]):
                    left, right = pairs.corners[2 * p], pairs.corners[2 * p + 1]
                    ga, gb = corner(slopes, left), corner(slopes, right)
                    a, b = corner(moved, left), corner(moved, right)
                    same = ga.dot(t @ gb)
                    if ti.static(part == 0):
                        for h in ti.static(range(4)):
                            same += kappa * gammas[4 * left + h] * gammas[4 * right + h]
                    value = same * ti.Matrix.identity(ti.f64, 3) + c1 * b.outer_product(a) + c2 * a.outer_product(b)
                    if ti.static(parts[part][1]):
                        value += ga.dot(gb) * r
                    basis_a = basis_of(basis, pairs.nodes[2 * p], block)
                    basis_b = basis_of(basis, pairs.nodes[2 * p + 1], block)
                    projected = basis_a.transpose() @ value @ basis_b
                    for i, j in ti.static(ti.ndrange(block, block)):
                        place = (p * block + i) * block + j
                        if ti.static(part == 0):
                            pairs.values[place] = projected[i, j]
                        else:
                            pairs.values[place] = pairs.values[place] + projected[i, j]

    return reduced_tangent
