"""Metals: multiplicative J2 plasticity with heat (METHOD 8; Simo, Comput. Meth. Appl. Mech. Engng 99, 61,
1992, with an exactly isochoric return and a flow modulus that is consistent with the dissipation).

    b = F Cp^-1 F^t,  d = J^(-2/3) dev b,  q = mu sqrt(3/2 d:d) <= Y(ep, T, p, rate)
    W = 3/2 mu y + U(J),  det(d + (1 + y) I) = 1:  1 + y is a third of the trace of the elastic strain of volume 1
    tau = mu d + J U' I,  P = tau F^-t

The state is D = Cp^-1 - I (xx yy zz xy xz yz), the plastic strain ep and the temperature rise T - T_init. With the
trial values q, d of the state before the step, f = q - Y > 0 makes the point flow: d becomes k d, k = (q - G3 dep)/q,
where

    G3 = 3 mu / max(1 - 3/2 (det d/d:d) (1 + min(Y/q, 1)), 0.3),    Y at the old ep, with the rate of the step

makes q dep the work that is lost, up to second order in the step; dep solves q - G3 dep = Y (yield_stress.py). The new
state has det Cp^-1 = 1 exactly:

    D_new = k D + (k - 1) I + w (cof F)^t cof F,   w = [(1 + y)/J^(-2/3) - k (1 + tr(b - I)/3)]/J^2

Dissipated are (min(Y, q) + Y_new)/2 dep, Y with the rate of the step, per reference volume, and a share of it heats the
point. An elastic point keeps its state bit for bit; nothing cancels at small strains. The second derivative keeps the
symmetric part.
"""

from ..engine import ti
from ..language import tensor3
from ..language.point_memory import any_above_zero
from ..language.precision import by_precision
from ..language.single_transcendental import SMALLEST_JACOBIAN
from ..language.transcendental import JACOBIAN_FLOOR, inverse_cube_root
from .equation_of_state import EQUATIONS_OF_STATE, EquationOfState
from .law import Law, Plastic, Tangent
from .yield_stress import FIRST, YIELD_STRESSES, YieldStress

STATE = ("D_xx", "D_yy", "D_zz", "D_xy", "D_xz", "D_yz", "plastic strain", "temperature rise")
STRAIN, WARMING = 6, 7
PARAMETERS = ("K", "mu", "1/(rho c)", "heat share", "T_init")
SHARE, INITIAL = 3, 4
TINY, TINY_SINGLE = 1e-60, 1e-30
SIX = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
PLACE = ((0, 3, 4), (3, 1, 5), (4, 5, 2))  # of component ij among the six


@ti.func
def twice(a, b):
    """Return a : b of symmetric tensors of six components."""
    return (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) + 2.0 * (a[3] * b[3] + a[4] * b[4] + a[5] * b[5])


@ti.func
def third_invariant(a):
    """Return det a of a symmetric tensor of six components."""
    return a[0] * (a[1] * a[2] - a[5] * a[5]) - a[3] * (a[3] * a[2] - a[5] * a[4]) + a[4] * (a[3] * a[5] - a[1] * a[4])


@ti.func
def elastic_strain(h, old):
    """Return the six components of b - I = H + H^t + H H^t + (F D) F^t."""
    f = tensor3.plus_identity(h, 1.0)
    turned = tensor3.product(f, [[old[PLACE[i][j]] for j in range(3)] for i in range(3)])
    return [
        h[i][j] + h[j][i] + (h[i][0] * h[j][0] + h[i][1] * h[j][1] + h[i][2] * h[j][2])
        + (turned[i][0] * f[j][0] + turned[i][1] * f[j][1] + turned[i][2] * f[j][2])
        for i, j in SIX
    ]  # fmt: skip


@ti.func
def volume_of_shape(k, square, third):
    """Return y with det(k d + (1 + y) I) = 1, from d:d and det d; both iterations take the slope of the first."""
    a = 0.5 * k * k * square
    c = k * k * k * third
    y = (a - c) * (1.0 / 3.0)
    rate = 1.0 / (3.0 * (1.0 + y) * (1.0 + y) - a)
    for _ in ti.static(range(2)):
        y = y - (y * (3.0 + y * (3.0 + y)) - a * (1.0 + y) + c) * rate
    return y


def make_law(yield_stress: YieldStress, state_equation: EquationOfState) -> Law:
    """Return the law with a yield stress and an equation of state."""
    start, flow = yield_stress.start, yield_stress.flow
    names = (*PARAMETERS, *yield_stress.parameters, *state_equation.parameters)
    volume, warmed, heated = state_equation.functions(len(names) - len(state_equation.parameters))

    @ti.func
    def returned(h, change, old, parameters, pressure):
        """Return [J^(-1/3), mean of b - I, d, d:d, det d, q, k, modulus G3, dep, slope of Y, dissipation] of a point.

        The plastic part is left out where no lane yields.
        """
        mu = parameters[1]
        lowest = ti.static(by_precision(JACOBIAN_FLOOR, SMALLEST_JACOBIAN) - 1.0)
        root = inverse_cube_root(1.0 + ti.max(change, 0.0 * change + lowest))
        scale = root * root
        b = elastic_strain(h, old)
        mean = (b[0] + b[1] + b[2]) * (1.0 / 3.0)
        d = [scale * (b[i] - (mean if ti.static(i < 3) else 0.0)) for i in range(6)]
        square, third = twice(d, d), third_invariant(d)
        trial = mu * ti.sqrt(1.5 * square + ti.static(by_precision(TINY, TINY_SINGLE)))
        begin = start(old[STRAIN], parameters[INITIAL] + old[WARMING], 0.0 - pressure, parameters)
        f = trial - begin[0]
        zero = 0.0 * f
        k, dep, slope, lost = zero + 1.0, zero, zero, zero
        modulus = zero + 3.0 * mu
        if any_above_zero(f):
            above = ti.max(f, zero)
            per_trial = 1.0 / trial
            bend = (1.5 * 1.5 * mu * mu) * (third * per_trial * per_trial)  # 3/2 det d/d:d
            step = flow(begin, above, [3.0 * mu, bend, per_trial], old[STRAIN], parameters)
            modulus = step[3]
            dep = ti.select(f > 0.0, step[0], zero)
            left = ti.max(trial - modulus * dep, zero)
            k = ti.select(f > 0.0, left * per_trial, zero + 1.0)
            slope = step[1]
            lost = 0.5 * (ti.min(step[2], trial) + left) * dep
        return [root, mean, d, square, third, trial, k, modulus, dep, slope, lost]

    @ti.func
    def of_volume(change, parameters, old, pressure: ti.template()):
        """Return [U', U, U' in the yield stress, J - 1 for the heat]; U is the cell's if its pressure is given."""
        if ti.static(len(pressure) == 0):
            own = volume(change, parameters, old)
            return [own[0], own[1], own[0], change]
        else:
            return [0.0 * change, 0.0 * change, pressure[0], pressure[1]]

    @ti.func
    def update(h, parameters, old, pressure: ti.template()):
        mu = parameters[1]
        cofactor_h = tensor3.cofactor(h)
        change = tensor3.volume_change(h, cofactor_h)
        stretch = 1.0 + tensor3.trace(h)
        cofactor_f = tensor3.plus_identity([[cofactor_h[i][j] - h[j][i] for j in range(3)] for i in range(3)], stretch)
        own = of_volume(change, parameters, old, pressure)
        spherical, energy = own[0], own[1]
        point = returned(h, change, old, parameters, own[2])
        root, mean, d, k, dep, lost = point[0], point[1], point[2], point[6], point[8], point[10]
        scale = root * root
        inverse = scale * root
        y = volume_of_shape(k, point[3], point[4])
        shear = mu * inverse * k
        # P = (tau/J) cof F, tau/J = mu k d/J + U' I
        tau = [[shear * d[PLACE[i][j]] + (spherical if ti.static(i == j) else 0.0) for j in range(3)] for i in range(3)]
        stress = tensor3.product(tau, cofactor_f)
        # 1/J^(-2/3) = J J^(-1/3); J^-2 = (J^(-1/3))^6
        grown = (1.0 + y) * ((1.0 + change) * root) - k * (1.0 + mean)
        w = ti.select(dep > 0.0, grown, 0.0 * k) * (inverse * inverse)
        c = [
            cofactor_f[0][i] * cofactor_f[0][j] + cofactor_f[1][i] * cofactor_f[1][j]
            + cofactor_f[2][i] * cofactor_f[2][j]
            for i, j in SIX
        ]  # fmt: skip
        new = [k * old[i] + ((k - 1.0) if ti.static(i < 3) else 0.0) + w * c[i] for i in range(6)]
        warm = warmed(own[3], parameters, old, parameters[SHARE] * parameters[2] * lost)
        return [stress, 1.5 * mu * y + energy, change, new + [old[STRAIN] + dep] + warm, lost]

    @ti.func
    def tangent(f, parameters, pressure, old):
        """Return [F^-t, s = mu d, k, k mb - Jp, slope - 2/3 k mb, k mb, 2/3 k, 3 mb kap/q^2, z]; see `pair`."""
        h = [[f[i, j] - (1.0 if ti.static(i == j) else 0.0) for j in range(3)] for i in range(3)]
        jacobian = f.determinant()
        own = volume(jacobian - 1.0, parameters, old)
        total = own[0] + pressure
        point = returned(h, jacobian - 1.0, old, parameters, total)
        d, trial, k, modulus, slope = point[2], point[5], point[6], point[7], point[9]
        shear = parameters[1] * point[0] * point[0] * (1.0 + point[1])
        softer = ti.select(point[8] > 0.0, ti.max(k - slope / (modulus + slope), 0.0), 0.0)
        s = ti.Matrix([[parameters[1] * d[PLACE[i][j]] for j in range(3)] for i in range(3)])
        spherical = jacobian * total
        growth = spherical + jacobian * jacobian * own[2]  # J (J U')' of the point itself, J U' of the cell's pressure
        return [
            f.inverse().transpose(),
            s,
            k,
            k * shear - spherical,
            growth - 2.0 / 3.0 * k * shear,
            k * shear,
            2.0 / 3.0 * k,
            3.0 * shear * softer / (trial * trial),
            s + (0.5 / shear) * (s @ s - (2.0 / 9.0 * trial * trial) * ti.Matrix.identity(ti.f64, 3)),
        ]

    @ti.func
    def secant(old, parameters):
        strength = yield_stress.hardened(old[STRAIN], parameters)
        return strength / (strength + 3.0 * parameters[1] * old[STRAIN])

    functions, numbers = (volume, secant, heated), (STRAIN, WARMING, SHARE, INITIAL, FIRST)
    plastic = Plastic(*functions, *numbers, rates=yield_stress.rates, always=bool(state_equation.state))
    return Law(
        names,
        update,
        (Tangent(tangent, corner, pair),),
        state=STATE + state_equation.state,
        modulus=dilatational_modulus,
        plastic=plastic,
    )


@ti.func
def dilatational_modulus(parameters):
    """Return K + 4/3 mu."""
    return parameters[0] + (4.0 / 3.0) * parameters[1]


@ti.func
def corner(data, g):
    """Return F^-t G."""
    return data[0] @ g


@ti.func
def pair(data, ga, gb, a, b):
    """Return A_ab of two corners with a = F^-t G_a, b = F^-t G_b.

    k (a.s b) I + k mb (a.b) I + c1 b x a + c2 a x b - 2/3 k [s a x b + a x s b] - c3 (z a) x (z b)

    z = s + dev(s^2)/(2 mb): q changes by 3/q (mb s + dev s^2) : grad v, of which the symmetric part is kept.
    """
    sa, sb = data[1] @ a, data[1] @ b
    za, zb = data[8] @ a, data[8] @ b
    same = data[2] * sa.dot(b) + data[5] * a.dot(b)
    value = ti.Matrix.zero(ti.f64, 3, 3)
    for i, j in ti.static(ti.ndrange(3, 3)):
        value[i, j] = data[3] * b[i] * a[j] + data[4] * a[i] * b[j]
        value[i, j] -= data[6] * (sa[i] * b[j] + a[i] * sb[j]) + data[7] * za[i] * zb[j]
        if ti.static(i == j):
            value[i, i] += same
    return value


LAWS = {
    "_".join(["j2", name, *([] if equation == "bulk" else [equation])]): make_law(stress, state_equation)
    for name, stress in YIELD_STRESSES.items()
    for equation, state_equation in EQUATIONS_OF_STATE.items()
}
