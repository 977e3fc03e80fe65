"""Tensors of a time step from x0 to x1 at one point, from which the stresses of implicit schemes are built (METHOD 4).

    C_m = (C0 + C1)/2,  dC = C1 - C0 = 2 dE,  G = DD/(J0 + J1),  DD = cof C_m + cof(dC)/12:  G : dC = J1 - J0 exactly

A configuration is E = (C - I)/2 and j = J - 1, never a difference of large numbers. Derivatives are along one change of
E1 (`along`) that makes J1 grow by `growth`; everything of level 0 is held.
"""

from ..engine import ti
from .transcendental import log_split

SERIES = 1e-3  # |z| below which log1p(z)/z is differentiated by its series


@ti.func
def identity():
    """Return I."""
    return ti.Matrix.identity(ti.f64, 3)


@ti.func
def inner(a, b):
    """Return a : b."""
    return (a * b).sum()


@ti.func
def cofactor(a):
    """Return cof a = det(a) a^-t of any 3x3 matrix."""
    r0, r1, r2 = row(a, 0), row(a, 1), row(a, 2)
    return rows(r1.cross(r2), r2.cross(r0), r0.cross(r1))


@ti.func
def cofactor_change(a, b):
    """Return the derivative of cof a along b."""
    a0, a1, a2, b0, b1, b2 = row(a, 0), row(a, 1), row(a, 2), row(b, 0), row(b, 1), row(b, 2)
    return rows(a1.cross(b2) + b1.cross(a2), a2.cross(b0) + b2.cross(a0), a0.cross(b1) + b0.cross(a1))


@ti.func
def row(a, i: ti.template()):
    """Return row i of a matrix."""
    return ti.Vector([a[i, 0], a[i, 1], a[i, 2]])


@ti.func
def rows(a, b, c):
    """Return the matrix with these rows."""
    return ti.Matrix([[a[0], a[1], a[2]], [b[0], b[1], b[2]], [c[0], c[1], c[2]]])


@ti.func
def volume_change(h):
    """Return det(I + h) - 1 = tr h + tr cof h + det h."""
    c = cofactor(h)
    return h.trace() + (c.trace() + h[0, 0] * c[0, 0] + h[0, 1] * c[0, 1] + h[0, 2] * c[0, 2])


@ti.func
def logarithm_part(z):
    """Return (z - ln(1 + z))/z and the derivative of ln(1 + z)/z."""
    delta = z * (0.5 - z * (1.0 / 3.0 - z * (0.25 - 0.2 * z)))
    slope = -0.5 + z * (2.0 / 3.0 - z * (0.75 - 0.8 * z))
    if ti.abs(z) > SERIES:
        split = log_split(z)
        delta = split[0] / z
        slope = (delta - z * split[1]) / z
    return delta, slope


@ti.func
def inverse_metric(e, j):
    """Return C^-1."""
    return cofactor(identity() + 2.0 * e) / ((1.0 + j) * (1.0 + j))


@ti.func
def middle(e0, e1):
    """Return E and J - 1 of C_m."""
    e = 0.5 * (e0 + e1)
    d = volume_change(2.0 * e)
    return e, d / (1.0 + ti.sqrt(1.0 + d))


@ti.func
def volume_slope(e0, e1, de, j0, j1):
    """Return DD and G, with DD:dC = det C1 - det C0 and G:dC = J1 - J0."""
    dd = cofactor(identity() + (e0 + e1)) + cofactor(2.0 * de) / 12.0
    return dd, dd / (2.0 + j0 + j1)


@ti.func
def volume_slope_change(e0, e1, de, j0, j1, along, growth):
    """Return the derivatives of DD and G; growth: that of J1."""
    g = volume_slope(e0, e1, de, j0, j1)[1]
    dd = cofactor_change(identity() + (e0 + e1), along) + cofactor_change(2.0 * de, 2.0 * along) / 12.0
    return dd, (dd - growth * g) / (2.0 + j0 + j1)
