"""Stiffness between the contact nodes of a cell: B_a^t A_ab B_b with A_ab = int grad N_a . d2W/dF dF . grad N_b dX.

With G = grad N in the reference state and g = F^-t G:

    linear elastic         A_ab = lam G_a x G_b + mu (G_b x G_a + (G_a.G_b) I)
    St Venant-Kirchhoff    A_ab = (G_a.S G_b) I + lam (F G_a) x (F G_b) + mu ((F G_b) x (F G_a) + (G_a.G_b) F F^t)
    neo-Hookean            A_ab = mu (G_a.G_b) I + (mu - lam J (J-1)) g_b x g_a + lam J (2J-1) g_a x g_b

(exact second derivatives of the energies in laws.py). Only contact cells and only pairs of their corners in K.
"""

import functools

import taichi as ti

from .boundary_nodes import ARRAY, INDEX
from .massless_node import basis_of


@ti.func
def linear_elastic(f, ga, gb, lam, mu):
    return lam * ga.outer_product(gb) + mu * (gb.outer_product(ga) + ga.dot(gb) * ti.Matrix.identity(ti.f64, 3))


@ti.func
def st_venant_kirchhoff(f, ga, gb, lam, mu):
    identity = ti.Matrix.identity(ti.f64, 3)
    strain = 0.5 * (f.transpose() @ f - identity)
    stress = lam * strain.trace() * identity + 2.0 * mu * strain
    a, b = f @ ga, f @ gb
    moved = b.outer_product(a) + ga.dot(gb) * (f @ f.transpose())
    return ga.dot(stress @ gb) * identity + lam * a.outer_product(b) + mu * moved


@ti.func
def neo_hookean(f, ga, gb, lam, mu):
    jacobian = f.determinant()
    pull = f.inverse().transpose()
    a, b = pull @ ga, pull @ gb
    return (
        mu * ga.dot(gb) * ti.Matrix.identity(ti.f64, 3)
        + (mu - lam * jacobian * (jacobian - 1.0)) * b.outer_product(a)
        + lam * jacobian * (2.0 * jacobian - 1.0) * a.outer_product(b)
    )


TANGENTS = {"linear_elastic": linear_elastic, "st_venant_kirchhoff": st_venant_kirchhoff, "neo_hookean": neo_hookean}


@functools.cache
def make_surface_tangent(law: str, block: int):
    tangent = TANGENTS[law]

    @ti.kernel
    def surface_tangent(
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
        """shape_gradients [q, corners, 3]; pair_values_out [pairs, block, block]."""
        for cell in range(pair_start.shape[0] - 1):
            for i in range(pair_start[cell] * block * block, pair_start[cell + 1] * block * block):
                pair_values_out[i] = 0.0
            for q in range(weights.shape[0]):
                jacobian = ti.Matrix.zero(ti.f64, 3, 3)
                slope = ti.Matrix.zero(ti.f64, 3, 3)
                for a in range(corners):
                    at = 3 * (q * corners + a)
                    here, first = 3 * (cell * corners + a), 3 * cell * corners
                    for i, j in ti.static(ti.ndrange(3, 3)):
                        jacobian[i, j] += cell_reference[here + i] * shape_gradients[at + j]
                        slope[i, j] += (cell_u[here + i] - cell_u[first + i]) * shape_gradients[at + j]
                inverse = jacobian.inverse()
                f = ti.Matrix.identity(ti.f64, 3) + slope @ inverse
                volume = weights[q] * jacobian.determinant()
                for p in range(pair_start[cell], pair_start[cell + 1]):
                    at_a = 3 * (q * corners + pair_corners[2 * p])
                    at_b = 3 * (q * corners + pair_corners[2 * p + 1])
                    local_a = ti.Vector([shape_gradients[at_a + j] for j in ti.static(range(3))])
                    local_b = ti.Vector([shape_gradients[at_b + j] for j in ti.static(range(3))])
                    ga = inverse.transpose() @ local_a
                    gb = inverse.transpose() @ local_b
                    left = basis_of(basis, pair_nodes[2 * p], block)
                    right = basis_of(basis, pair_nodes[2 * p + 1], block)
                    stiffness = volume * (left.transpose() @ tangent(f, ga, gb, lam, mu) @ right)
                    for i, j in ti.static(ti.ndrange(block, block)):
                        pair_values_out[(p * block + i) * block + j] += stiffness[i, j]

    return surface_tangent
