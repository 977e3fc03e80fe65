"""Neo-Hookean: W = mu/2 (tr F^t F - 3) - mu ln J + lam/2 (J - 1)^2.

    P = mu (F - cof F) + (lam (J-1) + mu (J-1)/J) cof F,  cof F = I + (tr H) I - H^t + cof H
    S = C^-1 (2 mu E + lam J (J-1) I)
    d2W/dF dF: M = F^-t,  T = mu I,  c1 = mu - p J,  c2 = (p + lam J) J     (law.py)

with p = lam (J-1) + the pressure of the cell (mean dilatation). Over a step (implicit_geometry.py):
S* = mu (I - s DD) + lam (J0 + J1 - 2) G,  s = 2/(J0 + J1) ln(J1/J0)/(J1 - J0).
"""

from ..engine import ti
from ..language import tensor3
from ..language.implicit_geometry import (
    cofactor,
    identity,
    inner,
    inverse_metric,
    logarithm_part,
    volume_slope,
    volume_slope_change,
)
from ..language.precision import or_in_single
from ..language.single_transcendental import SMALLEST_JACOBIAN
from ..language.transcendental import log_split
from .law import Law, StepLaw, tangent_form


@ti.func
def update_by_strain(h, parameters):
    """Return what `update` returns by E = (H + H^t + H^t H)/2, for float32.

    In a rotation H rounds E by d = 1e-7. P = F S with a symmetric S leaves no torque, and terms of second order in E
    leave an error of W of mu E d; as `update` forms them the torque would be mu d and the error mu d. With j = J - 1

        J^2 = 1 + 2 tr E + b,  b = 4 tr cof E + 8 det E,  tr E - j = (j tr E - b)/(1 + J),  C^-1 = cof C / J^2
    """
    lam, mu = parameters[0], parameters[1]
    square = tensor3.transposed_product(h, h)
    e = [[0.5 * (h[i][j] + h[j][i] + square[i][j]) for j in range(3)] for i in range(3)]
    cofactor_e = tensor3.cofactor(e)
    first = tensor3.trace(e)
    beyond = 4.0 * tensor3.trace(cofactor_e) + 8.0 * tensor3.determinant(e, cofactor_e)
    growth = 2.0 * first + beyond
    metric = ti.max(1.0 + growth, 0.0 * growth + SMALLEST_JACOBIAN * SMALLEST_JACOBIAN)  # J^2
    jacobian = ti.sqrt(metric)
    change = growth / (1.0 + jacobian)
    inverse = tensor3.scaled(1.0 / metric, tensor3.cofactor(tensor3.plus_identity(tensor3.scaled(2.0, e), 1.0)))
    shear, spherical = tensor3.product(inverse, e), lam * jacobian * change
    second = [[2.0 * mu * shear[i][j] + spherical * inverse[i][j] for j in range(3)] for i in range(3)]
    moved = tensor3.product(h, second)
    stress = [[second[i][j] + moved[i][j] for j in range(3)] for i in range(3)]
    energy = mu * ((change * first - beyond) / (1.0 + jacobian) + log_split(change)[0]) + 0.5 * lam * change * change
    return [stress, energy, tensor3.volume_change(h, tensor3.cofactor(h))]


@or_in_single(update_by_strain)
@ti.func
def update(h, parameters):
    lam, mu = parameters[0], parameters[1]
    cofactor_h = tensor3.cofactor(h)
    stretch = tensor3.trace(h)
    change = tensor3.volume_change(h, cofactor_h)
    logarithm = log_split(change)
    pressure = change * (lam + mu * logarithm[1])
    spin = pressure - mu
    d = tensor3.plus_identity([[cofactor_h[i][j] - h[j][i] for j in range(3)] for i in range(3)], stretch)
    stress = tensor3.plus_identity([[mu * h[i][j] + spin * d[i][j] for j in range(3)] for i in range(3)], pressure)
    quadratic = 0.5 * tensor3.dot(h, h) - (change - stretch)
    energy = mu * (quadratic + logarithm[0]) + 0.5 * lam * change * change
    return [stress, energy, change]


@ti.func
def tangent(f, parameters, pressure):
    lam, mu = parameters[0], parameters[1]
    jacobian = f.determinant()
    spherical = (lam * (jacobian - 1.0) + pressure) * jacobian
    return [f.inverse().transpose(), mu * identity(), mu - spherical, spherical + lam * jacobian * jacobian]


@ti.func
def energy(e, j, parameters):
    return parameters[1] * ((e.trace() - j) + log_split(j)[0]) + 0.5 * parameters[0] * j * j


@ti.func
def stress(e, j, parameters):
    inverse = inverse_metric(e, j)
    return 2.0 * parameters[1] * (inverse @ e) + parameters[0] * j * (1.0 + j) * inverse


@ti.func
def stress_change(e, j, parameters, along):
    lam, mu = parameters[0], parameters[1]
    inverse = inverse_metric(e, j)
    pressure = lam * j * (1.0 + j)
    growth = (1.0 + j) * inner(inverse, along)
    return 2.0 * (mu - pressure) * (inverse @ along @ inverse) + lam * (1.0 + 2.0 * j) * growth * inverse


@ti.func
def discrete(e0, e1, de, j0, j1, parameters):
    """Return S*, without the cancellation of I - s DD."""
    lam, mu = parameters[0], parameters[1]
    g = volume_slope(e0, e1, de, j0, j1)[1]
    twice = e0 + e1
    rest = twice.trace() * identity() - twice + cofactor(twice) + cofactor(2.0 * de) / 12.0  # DD - I
    z = 2.0 * inner(g, de) / (1.0 + j0)
    product = j0 + 0.5 * (j0 + j1) + 0.5 * j0 * (j0 + j1)  # J0 (J0 + J1)/2 - 1
    less = (product + logarithm_part(z)[0]) / (1.0 + product)  # 1 - s
    return mu * (less * identity() - (1.0 - less) * rest) + lam * (j0 + j1) * g


@ti.func
def discrete_change(e0, e1, de, j0, j1, parameters, along, growth):
    lam, mu = parameters[0], parameters[1]
    dd, g = volume_slope(e0, e1, de, j0, j1)
    dd_change, g_change = volume_slope_change(e0, e1, de, j0, j1, along, growth)
    z = 2.0 * inner(g, de) / (1.0 + j0)
    delta, slope = logarithm_part(z)
    scale = 2.0 / ((1.0 + j0) * (2.0 + j0 + j1))
    s = (1.0 - delta) * scale
    s_change = growth * (slope * scale / (1.0 + j0) - s / (2.0 + j0 + j1))
    volume = lam * (growth * g + (j0 + j1) * g_change)
    return volume - mu * (s_change * dd + s * dd_change)


LAW = Law(
    ("lam", "mu"),
    update,
    (tangent_form(tangent),),
    StepLaw(energy, stress, stress_change, discrete, discrete_change),
)
