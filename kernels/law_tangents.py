"""Second derivatives of the laws, in the form that the stiffness between the corners of a cell needs.

With G = grad N in the reference state d2W/dF dF of every law of laws.py has the form, or is a sum of parts of the form

    A_ab = (G_a . T G_b) I + c1 b x a + c2 a x b + (G_a . G_b) R,    a = M G_a,  b = M G_b

    linear elastic         M = I,      T = mu I,  c1 = mu,               c2 = lam,             R = 0
    St Venant-Kirchhoff    M = F,      T = S,     c1 = mu,               c2 = lam,             R = mu F F^t
    neo-Hookean            M = F^-t,   T = mu I,  c1 = mu - lam J (J-1), c2 = lam J (2J - 1),  R = 0
    Mooney-Rivlin          the sum of neo-Hookean's of bulk, M and of St Venant-Kirchhoff's of 4 c2, -2 c2 (laws.py)

(exact second derivatives of the energies). Where the volume change is that of the cell, with a pressure p
(elements/hex8_mean_dilatation.py), the points keep

    linear elastic         lam = 0
    neo-Hookean            c1 = mu - p J,  c2 = p J
"""

import taichi as ti


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
def pressed_neo_hookean(f, pressure, mu):
    """One volume change per cell: its pressure instead of lam."""
    identity = ti.Matrix.identity(ti.f64, 3)
    push = pressure * f.determinant()
    return f.inverse().transpose(), mu * identity, mu - push, push, ti.Matrix.zero(ti.f64, 3, 3)


@ti.func
def two_moduli(params: ti.template()):
    return [[params[6], params[7]]]


@ti.func
def mooney_rivlin_moduli(params: ti.template()):
    return [[params[6], params[7]], [params[8], -0.5 * params[8]]]


# the parts of every law that are summed up: (tangent, whether it has an R), and lam and mu of each from the parameters
LINEAR, GREEN, NEO = (linear_elastic, False), (st_venant_kirchhoff, True), (neo_hookean, False)
PRESSED = (pressed_neo_hookean, False)
PARTS = {
    "linear_elastic": ((LINEAR,), two_moduli),
    "st_venant_kirchhoff": ((GREEN,), two_moduli),
    "neo_hookean": ((NEO,), two_moduli),
    "mooney_rivlin": ((NEO, GREEN), mooney_rivlin_moduli),
}
MEAN_PARTS = {
    "linear_elastic": ((LINEAR,), two_moduli),
    "neo_hookean": ((PRESSED,), two_moduli),
    "mooney_rivlin": ((PRESSED, GREEN), mooney_rivlin_moduli),
}
