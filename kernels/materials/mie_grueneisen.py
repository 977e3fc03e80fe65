"""The equation of state of Mie and Grueneisen about the shock curve Us = c0 + s up of a metal.

With m = 1 - J, K = rho0 c0^2, constant specific heat c and Gamma rho = Gamma rho0 (Gamma that of the start):

    p_H = K m/(1 - s m)^2                                     pressure on the shock curve; s = 0 in tension, m < 0
    p_s = p_H - Gamma D,   W_s = p_H m/2 - D,   T_s = T0 exp(Gamma m)               isentrope from the start
    p = p_s + Gamma rho0 c (T - T_s),   W = W_s + rho0 c (T - T_s) - heat put in

    D(m) = K s m^3 int_0^1 u^2 exp(Gamma m (1 - u))/(1 - s m u)^3 du

D, the energy that a shock to m puts in as heat per reference volume, follows from dW_s/dm = p_s by parts. It is of
third order in m, and its six points of quadrature (with the weight u^2) leave an error of W_s of 1e-12 at s m = 0.3,
1e-8 at 0.5. In tension p_s = K m. Where s m > LARGEST = 0.8, far beyond any such shock, s m is taken as LARGEST.

A point keeps theta, its temperature brought back to the start volume less T0, and the heat put in over rho0 c:

    T = (T0 + theta) exp(Gamma m),   rho0 c (T - T_s) = rho0 c theta exp(Gamma m)

Without heat theta is constant: any path of compression and release brings the temperature back to the last digit.
Heat dQ raises T by dQ/(rho0 c), theta by exp(-Gamma m) times this, and leaves W as it is: W holds what the pressure of
the heat has taken up, so the energy balance counts heat once, where it is dissipated.
"""

from ..engine import ti
from ..language.transcendental import exponential, exponential_less_one

PARAMETERS = ("s", "Gamma", "rho c/K")
STATE = ("reduced temperature rise", "heat over rho c")
WARMING, REDUCED, HEAT = 7, 8, 9  # places in the state of a point
INITIAL = 4  # place of the initial temperature among the parameters
LARGEST = 0.8
# points of Gauss and Jacobi on 0..1 with the weight u^2
POINTS = (0.11319438382243824, 0.2843188726882861, 0.49096358683524793, 0.6975630819771088, 0.8684360583420149,
          0.9740954449063328)  # fmt: skip
WEIGHTS = (0.0018310758068693078, 0.015720297184945053, 0.05128957112961623, 0.09457718674854122, 0.10737649973678065,
           0.06253870272658094)  # fmt: skip


def make_functions(first: int):
    """Return [volume, warmed, heated] (equation_of_state.py); first: place of the constants among the parameters."""

    @ti.func
    def volume(e, parameters, old):
        bulk, gamma, capacity = parameters[0], parameters[first + 1], parameters[first + 2]
        m = 0.0 - e
        zero = 0.0 * m
        slope = ti.select(m > 0.0, zero + parameters[first], zero)
        near = ti.min(slope * m, zero + LARGEST)
        left = 1.0 / (1.0 - near)
        shock = bulk * m * left * left
        steep = bulk * (1.0 + near) * (left * left * left)
        total = zero
        for i in ti.static(range(len(POINTS))):
            grown = exponential((1.0 - POINTS[i]) * gamma * m)
            part = 1.0 / (1.0 - POINTS[i] * near)
            total = total + WEIGHTS[i] * grown * (part * part * part)
        lost = bulk * slope * (m * m * m) * total
        losing = 0.5 * (steep * m - shock) + gamma * lost  # dD/dm
        grown = exponential(gamma * m)
        warm = bulk * capacity * (old[REDUCED] * grown)
        pressure = shock - gamma * lost + gamma * warm
        energy = 0.5 * shock * m - lost + (warm - bulk * capacity * old[HEAT])
        return [0.0 - pressure, energy, steep - gamma * losing + gamma * gamma * warm]

    @ti.func
    def warmed(e, parameters, old, rise):
        power = (0.0 - parameters[first + 1]) * e
        grown = exponential_less_one(power)
        reduced = old[REDUCED] + exponential(0.0 - power) * rise
        return [parameters[INITIAL] * grown + reduced * (1.0 + grown), reduced, old[HEAT] + rise]

    @ti.func
    def heated(old, parameters, rise):
        # exp(Gamma m) is the ratio of the temperature to the reduced one
        initial = parameters[INITIAL]
        share = (initial + old[REDUCED]) / (initial + old[WARMING])
        return [old[WARMING] + rise, old[REDUCED] + share * rise, old[HEAT] + rise]

    return volume, warmed, heated
