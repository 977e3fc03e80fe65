"""Stiffness between the contact nodes of a cell: B_a^t A_ab B_b with A_ab = int grad N_a . d2W/dF dF . grad N_b dX.

With G = grad N in the reference state every law of laws.py has the form

    A_ab = (G_a . T G_b) I + c1 b x a + c2 a x b + (G_a . G_b) R,    a = M G_a,  b = M G_b

    linear elastic         M = I,      T = mu I,  c1 = mu,               c2 = lam,             R = 0
    St Venant-Kirchhoff    M = F,      T = S,     c1 = mu,               c2 = lam,             R = mu F F^t
    neo-Hookean            M = F^-t,   T = mu I,  c1 = mu - lam J (J-1), c2 = lam J (2J - 1),  R = 0
    Mooney-Rivlin          the sum of neo-Hookean's of bulk, M and of St Venant-Kirchhoff's of 4 c2, -2 c2 (laws.py)

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


@ti.func
def two_moduli(params: ti.template()):
    return [[params[6], params[7]]]


@ti.func
def mooney_rivlin_moduli(params: ti.template()):
    return [[params[6], params[7]], [params[8], -0.5 * params[8]]]


# the parts of every law that are summed up: (tangent, whether it has an R), and lam and mu of each from the parameters
LINEAR, GREEN, NEO = (linear_elastic, False), (st_venant_kirchhoff, True), (neo_hookean, False)
PARTS = {
    "linear_elastic": ((LINEAR,), two_moduli),
    "st_venant_kirchhoff": ((GREEN,), two_moduli),
    "neo_hookean": ((NEO,), two_moduli),
    "mooney_rivlin": ((NEO, GREEN), mooney_rivlin_moduli),
}


@ti.func
def corner(values: ti.template(), a):
    return ti.Vector([values[3 * a + j] for j in ti.static(range(3))])


@functools.cache
def make_surface_tangent(law: str, block: int, plain: bool):
    """surface_tangent(body, basis, pairs) fills pairs.values; plain: every basis is the identity."""
    parts, moduli_of = PARTS[law]

    @ti.func
    def surface_tangent(body: ti.template(), basis: ti.template(), pairs: ti.template()):
        moduli = moduli_of(body.params)
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
                f = ti.Matrix.identity(ti.f64, 3) + slope @ inverse
                for part in ti.static(range(len(parts))):
                    lam, mu = moduli[part][0], moduli[part][1]
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
