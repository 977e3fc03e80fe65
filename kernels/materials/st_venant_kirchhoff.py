"""St Venant-Kirchhoff: W = lam/2 (tr E)^2 + mu E:E,  S = lam (tr E) I + 2 mu E,  P = F S,  E = (H + H^t + H^t H)/2.

    d2W/dF dF: M = F,  T = S,  c1 = mu,  c2 = lam,  R = mu F F^t     (law.py)

S is linear in E, so that S((E0 + E1)/2) : (E1 - E0) = W1 - W0 exactly.
"""

from ..engine import ti
from ..language import tensor3
from .law import Law, StepLaw, tangent_form


@ti.func
def update(h, parameters):
    lam, mu = parameters[0], parameters[1]
    square = tensor3.transposed_product(h, h)
    strain = [[0.5 * (h[i][j] + h[j][i] + square[i][j]) for j in range(3)] for i in range(3)]
    pressure = lam * tensor3.trace(strain)
    second = tensor3.plus_identity(tensor3.scaled(2.0 * mu, strain), pressure)
    moved = tensor3.product(h, second)
    stress = [[second[i][j] + moved[i][j] for j in range(3)] for i in range(3)]
    return [stress, 0.5 * tensor3.dot(second, strain), tensor3.volume_change(h, tensor3.cofactor(h))]


@ti.func
def tangent(f, parameters, pressure):
    strain = 0.5 * (f.transpose() @ f - ti.Matrix.identity(ti.f64, 3))
    second = stress(strain, 0.0, parameters)
    return [f, second, parameters[1], parameters[0], parameters[1] * (f @ f.transpose())]


@ti.func
def energy(e, j, parameters):
    return 0.5 * (stress(e, j, parameters) * e).sum()


@ti.func
def stress(e, j, parameters):
    return parameters[0] * e.trace() * ti.Matrix.identity(ti.f64, 3) + 2.0 * parameters[1] * e


@ti.func
def stress_change(e, j, parameters, along):
    return stress(along, 0.0, parameters)


@ti.func
def discrete(e0, e1, de, j0, j1, parameters):
    return stress(0.5 * (e0 + e1), 0.0, parameters)


@ti.func
def discrete_change(e0, e1, de, j0, j1, parameters, along, growth):
    return stress(0.5 * along, 0.0, parameters)


LAW = Law(
    ("lam", "mu"),
    update,
    (tangent_form(tangent, rest=True),),
    StepLaw(energy, stress, stress_change, discrete, discrete_change),
    refusal="StVenantKirchhoff loses ellipticity in strong compression (det F < 0.58): use NeoHookean",
)
