"""Stiffness between the contact nodes of a cell: B_a^t A_ab B_b with A_ab = int grad N_a . d2W/dF dF . grad N_b dX.

With G = grad N in the reference state every law of laws.py has the form

    A_ab = (G_a . T G_b) I + c1 b x a + c2 a x b + (G_a . G_b) R,    a = M G_a,  b = M G_b

    linear elastic         M = I,      T = mu I,  c1 = mu,               c2 = lam,             R = 0
    St Venant-Kirchhoff    M = F,      T = S,     c1 = mu,               c2 = lam,             R = mu F F^t
    neo-Hookean            M = F^-t,   T = mu I,  c1 = mu - lam J (J-1), c2 = lam J (2J - 1),  R = 0

(exact second derivatives of the energies). Only contact cells and only pairs of their corners in K.
"""

import functools

import taichi as ti

from .massless_node import basis_of

MOST_CORNERS = 8


@ti.func
def linear_elastic(f, lam, mu):
    identity = ti.Matrix.identity(ti.f64, 3)
    return identity, mu * identity, mu, lam, ti.Matrix.zero(ti.f64, 3, 3)


@ti.func
def st_venant_kirchhoff(f, lam, mu):
    identity = ti.Matrix.identity(ti.f64, 3)
    strain = 0.5 * (f.transpose() @ f - identity)
    return f, lam * strain.trace() * identity + 2.0 * mu * strain, mu, lam, mu * (f @ f.transpose())


@ti.func
def neo_hookean(f, lam, mu):
    identity = ti.Matrix.identity(ti.f64, 3)
    jacobian = f.determinant()
    first = mu - lam * jacobian * (jacobian - 1.0)
    second = lam * jacobian * (2.0 * jacobian - 1.0)
    return f.inverse().transpose(), mu * identity, first, second, ti.Matrix.zero(ti.f64, 3, 3)


TANGENTS = {"linear_elastic": linear_elastic, "st_venant_kirchhoff": st_venant_kirchhoff, "neo_hookean": neo_hookean}


@ti.func
def corner(values: ti.template(), a):
    return ti.Vector([values[3 * a + j] for j in ti.static(range(3))])


@functools.cache
def make_surface_tangent(law: str, block: int, plain: bool):
    """surface_tangent(body, basis, pairs) fills pairs.values; plain: every basis is the identity."""
    tangent = TANGENTS[law]

    @ti.func
    def surface_tangent(body: ti.template(), basis: ti.template(), pairs: ti.template()):
        lam, mu = body.params[6], body.params[7]
        corners = pairs.cell_nodes.shape[0] // (pairs.start.shape[0] - 1)
        for cell in range(pairs.start.shape[0] - 1):
            slopes = ti.Vector.zero(ti.f64, 3 * MOST_CORNERS)  # G of every corner
            moved = ti.Vector.zero(ti.f64, 3 * MOST_CORNERS)  # M G of every corner
            first = cell * corners
            for i in range(pairs.start[cell] * block * block, pairs.start[cell + 1] * block * block):
                pairs.values[i] = 0.0
            for q in range(pairs.weights.shape[0]):
                jacobian = ti.Matrix.zero(ti.f64, 3, 3)
                slope = ti.Matrix.zero(ti.f64, 3, 3)
                for a in range(corners):
                    at = 3 * (q * corners + a)
                    here, origin = 3 * pairs.cell_nodes[first + a], 3 * pairs.cell_nodes[first]
                    for i, j in ti.static(ti.ndrange(3, 3)):
                        jacobian[i, j] += body.position[here + i] * pairs.shape_gradients[at + j]
                        slope[i, j] += (body.u[here + i] - body.u[origin + i]) * pairs.shape_gradients[at + j]
                inverse = jacobian.inverse()
                volume = pairs.weights[q] * jacobian.determinant()
                m, t, c1, c2, r = tangent(ti.Matrix.identity(ti.f64, 3) + slope @ inverse, volume * lam, volume * mu)
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
                            if ti.static(law == "st_venant_kirchhoff"):
                                value += ga.dot(gb) * r[i, j]
                            place = (p * 3 + i) * 3 + j
                            pairs.values[place] = pairs.values[place] + value  # "+=" would be an atomic
                    else:
                        basis_a = basis_of(basis, pairs.nodes[2 * p], block)
                        basis_b = basis_of(basis, pairs.nodes[2 * p + 1], block)
                        aa, ab = basis_a.transpose() @ a, basis_a.transpose() @ b
                        ba, bb = basis_b.transpose() @ a, basis_b.transpose() @ b
                        shared = same * (basis_a.transpose() @ basis_b)
                        if ti.static(law == "st_venant_kirchhoff"):
                            shared += ga.dot(gb) * (basis_a.transpose() @ r @ basis_b)
                        for i, j in ti.static(ti.ndrange(block, block)):
                            value = shared[i, j] + c1 * ab[i] * ba[j] + c2 * aa[i] * bb[j]
                            place = (p * block + i) * block + j
                            pairs.values[place] = pairs.values[place] + value

    return surface_tangent
