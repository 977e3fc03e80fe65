"""Stiffness between the contact nodes of one-point hexes (`reduced_hex`), hourglass stiffness included.

    A_ab = V (A_ab of surface_cells with the mean gradients G) + kappa (sum over modes h of gamma_ha gamma_hb) I
    G_a = 1/V int grad N_a dV,   gamma_ha = h_a - sum over k of (h_k x_k) . G_a

From the definitions, by quadrature, since only contact cells need it. Without the second part K_KK would be singular:
a one-point hex does not feel its contact nodes move against each other in an hourglass pattern.
"""

import functools

import taichi as ti

from .arguments import ARRAY, INDEX
from .massless_node import basis_of
from .reduced_hex import HOURGLASS
from .surface_cells import TANGENTS, corner

CORNERS = 8


@ti.func
def hourglass_modes(a):
    """(r1 r2, r1 r3, r2 r3, r1 r2 r3) at corner a in VTK order."""
    r1, r2, r3 = 2.0 * (((a + 1) >> 1) & 1) - 1.0, 2.0 * ((a >> 1) & 1) - 1.0, 2.0 * (a >> 2) - 1.0
    return ti.Vector([r1 * r2, r1 * r3, r2 * r3, r1 * r2 * r3])


@functools.cache
def make_reduced_tangent(law: str, block: int):
    tangent = TANGENTS[law]

    @ti.kernel
    def reduced_tangent(
        shape_gradients: ARRAY,
        weights: ARRAY,
        cell_reference: ARRAY,
        cell_u: ARRAY,
        pair_start: INDEX,
        pair_corners: INDEX,
        pair_nodes: INDEX,
        basis: ARRAY,
        corners: ti.i32,
        lam: ti.f64,
        mu: ti.f64,
        pair_values_out: ARRAY,
    ):
        """As `surface_tangent`: shape_gradients [q, corners, 3]; pair_values_out [pairs, block, block]."""
        for cell in range(pair_start.shape[0] - 1):
            slopes = ti.Vector.zero(ti.f64, 3 * CORNERS)  # G of every corner
            moved = ti.Vector.zero(ti.f64, 3 * CORNERS)  # M G of every corner
            gammas = ti.Vector.zero(ti.f64, 4 * CORNERS)
            first = cell * corners
            volume = 0.0
            for q in range(weights.shape[0]):
                jacobian = ti.Matrix.zero(ti.f64, 3, 3)
                for a in range(corners):
                    jacobian += corner(cell_reference, first + a).outer_product(
                        corner(shape_gradients, q * corners + a)
                    )
                weight = weights[q] * jacobian.determinant()
                volume += weight
                turned = weight * jacobian.inverse().transpose()
                for a in range(corners):
                    g = turned @ corner(shape_gradients, q * corners + a)
                    for j in ti.static(range(3)):
                        slopes[3 * a + j] += g[j]
            slope = ti.Matrix.zero(ti.f64, 3, 3)
            twist = ti.Matrix.zero(ti.f64, 4, 3)
            square = 0.0
            for a in range(corners):
                g = corner(slopes, a) / volume
                square += g.dot(g)
                slope += (corner(cell_u, first + a) - corner(cell_u, first)).outer_product(g)
                arm = corner(cell_reference, first + a) - corner(cell_reference, first)
                twist += hourglass_modes(a).outer_product(arm)
                for j in ti.static(range(3)):
                    slopes[3 * a + j] = g[j]
            kappa = HOURGLASS * (lam + 2.0 * mu) * volume * square / 8.0
            m, t, c1, c2, r = tangent(ti.Matrix.identity(ti.f64, 3) + slope, volume * lam, volume * mu)
            for a in range(corners):
                g = corner(slopes, a)
                mg = m @ g
                gamma = hourglass_modes(a) - twist @ g
                for j in ti.static(range(3)):
                    moved[3 * a + j] = mg[j]
                for h in ti.static(range(4)):
                    gammas[4 * a + h] = gamma[h]
            for p in range(pair_start[cell], pair_start[cell + 1]):
                left, right = pair_corners[2 * p], pair_corners[2 * p + 1]
                ga, gb = corner(slopes, left), corner(slopes, right)
                a, b = corner(moved, left), corner(moved, right)
                same = ga.dot(t @ gb)
                for h in ti.static(range(4)):
                    same += kappa * gammas[4 * left + h] * gammas[4 * right + h]
                value = same * ti.Matrix.identity(ti.f64, 3) + c1 * b.outer_product(a) + c2 * a.outer_product(b)
                if ti.static(law == "st_venant_kirchhoff"):
                    value += ga.dot(gb) * r
                basis_a = basis_of(basis, pair_nodes[2 * p], block)
                basis_b = basis_of(basis, pair_nodes[2 * p + 1], block)
                projected = basis_a.transpose() @ value @ basis_b
                for i, j in ti.static(ti.ndrange(block, block)):
                    pair_values_out[(p * block + i) * block + j] = projected[i, j]

    return reduced_tangent
