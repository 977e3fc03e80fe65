"""Linear elasticity at small strains: W = lam/2 (tr e)^2 + mu e:e,  e = (H + H^t)/2,  P = lam (tr e) I + 2 mu e.

Its second derivative is A_ab = mu (G_a . G_b) I + mu G_b x G_a + lam G_a x G_b (law.py, with M = I). Implicit schemes
have separate rules for it (implicit_points.py).
"""

from ..engine import ti
from ..language import tensor3
from .law import Law, tangent_form


@ti.func
def update(h, parameters):
    lam, mu = parameters[0], parameters[1]
    pressure = lam * tensor3.trace(h)
    strain = [[0.5 * (h[i][j] + h[j][i]) for j in range(3)] for i in range(3)]
    stress = tensor3.plus_identity(tensor3.scaled(2.0 * mu, strain), pressure)
    return [stress, 0.5 * tensor3.dot(stress, strain), tensor3.volume_change(h, tensor3.cofactor(h))]


@ti.func
def tangent(f, parameters, pressure):
    identity = ti.Matrix.identity(ti.f64, 3)
    return [identity, parameters[1] * identity, parameters[1], parameters[0]]


LAW = Law(("lam", "mu"), update, (tangent_form(tangent),), linear=True)
