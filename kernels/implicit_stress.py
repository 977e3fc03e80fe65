"""Second Piola-Kirchhoff stresses of a time step from x0 to x1 at one point, and their derivatives (METHOD 4).

    F_m = (F0 + F1)/2,  C_m = (C0 + C1)/2,  dC = C1 - C0 = 2 dE,  f* = int F_m S* : grad U,  S*:dC/2 = W1 - W0 wanted

    end            S(C1), with F1: backward Euler; also what the trapezoidal and the midpoint rule put together
    transport      S(C_m)
    mean           (S(C0) + S(C1))/2
    gonzalez       S(C_m) + [W1 - W0 - S(C_m):dE] dE/(dE:dE), correction dropped where |dC| < 1e-5 (paper eq. 12)
    discrete       invariant by invariant: W = a (I1-3) + b (I2-3) + h(J) + quadratic(E),
                   S* = 2a I + 2b (tr(C_m) I - C_m) + 2q G + quadratic'(E_m),  q = [h(J1) - h(J0)]/(J1 - J0),
                   G = DD/(J0 + J1),  DD = cof C_m + cof(dC)/12:  G:dC = J1 - J0 exactly
    dissipative    discrete + chi/2 (S(C1) - S(C0))

Every law is a sum of a part in J and I1 (`neo`: mu (tr E - ln J) + lam/2 (J-1)^2) and a quadratic in E (`green`:
lam/2 (tr E)^2 + mu E:E); both are written in E = (C - I)/2 and J - 1, never as a difference of large numbers.
A configuration is [E, J - 1]. Derivatives are along one change e of E1, everything of level 0 held.
"""

import taichi as ti

from .laws import log_split

SMALL_CHANGE = 1e-5  # |dC| below which Gonzalez' correction is dropped
SERIES = 1e-3  # |z| below which log1p(z)/z is differentiated by its series


@ti.func
def identity():
    return ti.Matrix.identity(ti.f64, 3)


@ti.func
def inner(a, b):
    """a : b"""
    return (a * b).sum()


@ti.func
def cofactor(a):
    """cof a = det(a) a^-T of any 3x3 matrix."""
    r0, r1, r2 = row(a, 0), row(a, 1), row(a, 2)
    return rows(r1.cross(r2), r2.cross(r0), r0.cross(r1))


@ti.func
def cofactor_change(a, b):
    """Derivative of cof a along b."""
    a0, a1, a2, b0, b1, b2 = row(a, 0), row(a, 1), row(a, 2), row(b, 0), row(b, 1), row(b, 2)
    return rows(a1.cross(b2) + b1.cross(a2), a2.cross(b0) + b2.cross(a0), a0.cross(b1) + b0.cross(a1))


@ti.func
def row(a, i: ti.template()):
    return ti.Vector([a[i, 0], a[i, 1], a[i, 2]])


@ti.func
def rows(a, b, c):
    return ti.Matrix([[a[0], a[1], a[2]], [b[0], b[1], b[2]], [c[0], c[1], c[2]]])


@ti.func
def volume_change(h):
    """det(I + h) - 1 = tr h + tr cof h + det h."""
    c = cofactor(h)
    return h.trace() + (c.trace() + h[0, 0] * c[0, 0] + h[0, 1] * c[0, 1] + h[0, 2] * c[0, 2])


@ti.func
def logarithm_part(z):
    """[(z - ln(1 + z))/z, derivative of ln(1 + z)/z]"""
    delta = z * (0.5 - z * (1.0 / 3.0 - z * (0.25 - 0.2 * z)))
    slope = -0.5 + z * (2.0 / 3.0 - z * (0.75 - 0.8 * z))
    if ti.abs(z) > SERIES:
        split = log_split(z)
        delta = split[0] / z
        slope = (delta - z * split[1]) / z
    return delta, slope


@ti.func
def neo_energy(e, j, lam, mu):
    return mu * ((e.trace() - j) + log_split(j)[0]) + 0.5 * lam * j * j


@ti.func
def inverse_metric(e, j):
    """C^-1"""
    return cofactor(identity() + 2.0 * e) / ((1.0 + j) * (1.0 + j))


@ti.func
def neo_stress(e, j, lam, mu):
    """S = C^-1 (2 mu E + lam J (J-1) I)"""
    inverse = inverse_metric(e, j)
    return 2.0 * mu * (inverse @ e) + lam * j * (1.0 + j) * inverse


@ti.func
def neo_change(e, j, lam, mu, along):
    """Derivative of S along a change of E."""
    inverse = inverse_metric(e, j)
    pressure = lam * j * (1.0 + j)
    growth = (1.0 + j) * inner(inverse, along)
    return 2.0 * (mu - pressure) * (inverse @ along @ inverse) + lam * (1.0 + 2.0 * j) * growth * inverse


@ti.func
def green_stress(e, lam, mu):
    return lam * e.trace() * identity() + 2.0 * mu * e


@ti.func
def green_energy(e, lam, mu):
    return 0.5 * lam * e.trace() * e.trace() + mu * inner(e, e)


@ti.func
def middle(e0, e1):
    """[E, J - 1] of C_m"""
    e = 0.5 * (e0 + e1)
    d = volume_change(2.0 * e)
    return e, d / (1.0 + ti.sqrt(1.0 + d))


@ti.func
def volume_slope(e0, e1, de, j0, j1):
    """[DD, G] with DD:dC = det C1 - det C0 and G:dC = J1 - J0."""
    dd = cofactor(identity() + (e0 + e1)) + cofactor(2.0 * de) / 12.0
    return dd, dd / (2.0 + j0 + j1)


@ti.func
def volume_slope_change(e0, e1, de, j0, j1, along, growth):
    """Derivative of [DD, G]; growth: that of J1."""
    g = volume_slope(e0, e1, de, j0, j1)[1]
    dd = cofactor_change(identity() + (e0 + e1), along) + cofactor_change(2.0 * de, 2.0 * along) / 12.0
    return dd, (dd - growth * g) / (2.0 + j0 + j1)


@ti.func
def neo_discrete(e0, e1, de, j0, j1, lam, mu):
    """S* = mu (I - s DD) + lam (J0 + J1 - 2) G,  s = 2/(J0 + J1) ln(J1/J0)/(J1 - J0), without subtracting I from DD."""
    g = volume_slope(e0, e1, de, j0, j1)[1]
    twice = e0 + e1
    rest = twice.trace() * identity() - twice + cofactor(twice) + cofactor(2.0 * de) / 12.0  # DD - I
    z = 2.0 * inner(g, de) / (1.0 + j0)
    product = j0 + 0.5 * (j0 + j1) + 0.5 * j0 * (j0 + j1)  # J0 (J0 + J1)/2 - 1
    less = (product + logarithm_part(z)[0]) / (1.0 + product)  # 1 - s
    return mu * (less * identity() - (1.0 - less) * rest) + lam * (j0 + j1) * g


@ti.func
def neo_discrete_change(e0, e1, de, j0, j1, lam, mu, along, growth):
    dd, g = volume_slope(e0, e1, de, j0, j1)
    dd_change, g_change = volume_slope_change(e0, e1, de, j0, j1, along, growth)
    z = 2.0 * inner(g, de) / (1.0 + j0)
    delta, slope = logarithm_part(z)
    scale = 2.0 / ((1.0 + j0) * (2.0 + j0 + j1))
    s = (1.0 - delta) * scale
    s_change = growth * (slope * scale / (1.0 + j0) - s / (2.0 + j0 + j1))
    volume = lam * (growth * g + (j0 + j1) * g_change)
    return volume - mu * (s_change * dd + s * dd_change)


@ti.func
def corrected(stress, de, work):
    """stress + [work - stress:dE] dE/(dE:dE): Gonzalez' correction."""
    result = stress
    square = inner(de, de)
    if 4.0 * square >= SMALL_CHANGE * SMALL_CHANGE:
        result += (work - inner(stress, de)) / square * de
    return result


@ti.func
def corrected_change(stress, de, work, stress_change, along, power):
    """Derivative of `corrected`; power: that of the work."""
    result = stress_change
    square = inner(de, de)
    if 4.0 * square >= SMALL_CHANGE * SMALL_CHANGE:
        share = (work - inner(stress, de)) / square
        change = (power - inner(stress_change, de) - inner(stress, along) - 2.0 * share * inner(de, along)) / square
        result += change * de + share * along
    return result
