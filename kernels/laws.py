"""Elastic laws: first Piola-Kirchhoff stress P = dW/dF and energy density W from the displacement gradient.

With H = grad u, F = I + H, J = det F, E = (F^t F - I)/2 (METHOD 0):

    linear elastic         W = lam/2 (tr e)^2 + mu e:e,  e = (H + H^t)/2
    St Venant-Kirchhoff    W = lam/2 (tr E)^2 + mu E:E
    neo-Hookean            W = mu/2 (tr F^t F - 3) - mu ln J + lam/2 (J - 1)^2
    Mooney-Rivlin          W = the neo-Hookean one of bulk and M = 2 (c1 + 2 c2) + 4 c2 ((tr E)^2 - E:E)/2

The last is c1 (I1 - 3) + c2 (I2 - 3) - 2 (c1 + 2 c2) ln J + bulk/2 (J - 1)^2, I1 = tr C, I2 = ((tr C)^2 - tr C^2)/2:
I1 - 3 = 2 tr E, I2 - 3 = 4 tr E + 2 ((tr E)^2 - E:E). Its quadratic is St Venant-Kirchhoff's with 4 c2 and -2 c2.

Everything is put together from H and J - 1, never from F - I or J minus one: at strain 1e-9 the stress keeps its digits
and the energy is still a square. A law is a function `law(H, moduli) -> [P, W, J - 1]` of 3x3 lists without branches
or library calls; the entries may be scalars or vectors of lanes (see `elements`). moduli: [lam, mu], Mooney-Rivlin's
[bulk, M, 4 c2]; P and W are linear in them. The first one belongs to the volume change.
"""

import taichi as ti

from . import tensor3

JACOBIAN_FLOOR = 1e-10  # below it ln J and 1/J are taken at the floor: finite numbers for an inverted cell
LN2 = 0.6931471805599453094
R0, R1, R2, R3 = 0.66666666666666696883, 0.39999999999899443233, 0.28571428626003268742, 0.22222211130259877029
R4, R5, R6 = 0.18182889455674946039, 0.15331710618210771568, 0.14616585424888621989


@ti.func
def volume_change(h, cofactor_h):
    """J - 1 = tr H + tr cof H + det H without cancellation."""
    return tensor3.trace(h) + (tensor3.trace(cofactor_h) + tensor3.determinant(h, cofactor_h))


@ti.func
def log_split(change):
    """[e - ln(1 + e), 1/(1 + e)] of e = change, both to the last digits also for tiny e.

    1 + e = 2^k (1 + t) with 1 + t in [0.70, 1.42) by exponent bits; with f = t/(2 + t), ln(1 + t) = 2 atanh f and
    t - ln(1 + t) = t f - f^3 R(f^2), R the minimax polynomial of degree 6 in Estrin form (error 5e-18 of ln).
    """
    e = ti.max(change, JACOBIAN_FLOOR - 1.0)
    jacobian = 1.0 + e
    exponent = (tensor3.to_bits(jacobian) + ti.u64(0x00095F619980C433)) >> ti.u64(52)  # splits at sqrt(1/2)
    power = tensor3.from_bits((ti.u64(2046) - exponent) << ti.u64(52))  # 2^-k
    k = tensor3.from_bits(exponent | ti.u64(0x4330000000000000)) - 4503599627371519.0  # exponent - 1023 as a float
    t = e * power + (power - 1.0)
    inverse = 1.0 / (jacobian * (2.0 + t))  # one division for both 1/(1 + e) and f
    f = t * (inverse * jacobian)
    z = f * f
    z2 = z * z
    low = (R0 + R1 * z) + (R2 + R3 * z) * z2
    high = (R4 + R5 * z) + R6 * z2
    series = low + high * (z2 * z2)
    return [(e - t) - k * LN2 + f * (t - z * series), inverse * (2.0 + t)]


@ti.func
def linear_elastic(h, moduli):
    lam, mu = moduli[0], moduli[1]
    pressure = lam * tensor3.trace(h)
    strain = [[0.5 * (h[i][j] + h[j][i]) for j in range(3)] for i in range(3)]
    stress = tensor3.plus_identity(tensor3.scaled(2.0 * mu, strain), pressure)
    return [stress, 0.5 * tensor3.dot(stress, strain), volume_change(h, tensor3.cofactor(h))]


@ti.func
def st_venant_kirchhoff(h, moduli):
    lam, mu = moduli[0], moduli[1]
    square = tensor3.transposed_product(h, h)
    strain = [[0.5 * (h[i][j] + h[j][i] + square[i][j]) for j in range(3)] for i in range(3)]
    pressure = lam * tensor3.trace(strain)
    second = tensor3.plus_identity(tensor3.scaled(2.0 * mu, strain), pressure)
    moved = tensor3.product(h, second)
    stress = [[second[i][j] + moved[i][j] for j in range(3)] for i in range(3)]
    return [stress, 0.5 * tensor3.dot(second, strain), volume_change(h, tensor3.cofactor(h))]


@ti.func
def neo_hookean(h, moduli):
    """P = mu (F - cof F) + (lam (J-1) + mu (J-1)/J) cof F with cof F = I + D, D = (tr H) I - H^t + cof H."""
    lam, mu = moduli[0], moduli[1]
    cofactor_h = tensor3.cofactor(h)
    stretch = tensor3.trace(h)
    change = volume_change(h, cofactor_h)
    logarithm = log_split(change)
    pressure = change * (lam + mu * logarithm[1])
    spin = pressure - mu
    d = tensor3.plus_identity([[cofactor_h[i][j] - h[j][i] for j in range(3)] for i in range(3)], stretch)
    stress = tensor3.plus_identity([[mu * h[i][j] + spin * d[i][j] for j in range(3)] for i in range(3)], pressure)
    quadratic = 0.5 * tensor3.dot(h, h) - (change - stretch)
    energy = mu * (quadratic + logarithm[0]) + 0.5 * lam * change * change
    return [stress, energy, change]


@ti.func
def mooney_rivlin(h, moduli):
    first = neo_hookean(h, moduli)
    second = st_venant_kirchhoff(h, [moduli[2], -0.5 * moduli[2]])
    stress = [[first[0][i][j] + second[0][i][j] for j in range(3)] for i in range(3)]
    return [stress, first[1] + second[1], first[2]]


LAWS = {
    "linear_elastic": linear_elastic,
    "st_venant_kirchhoff": st_venant_kirchhoff,
    "neo_hookean": neo_hookean,
    "mooney_rivlin": mooney_rivlin,
}
MODULI = {"linear_elastic": 2, "st_venant_kirchhoff": 2, "neo_hookean": 2, "mooney_rivlin": 3}  # how many each takes
