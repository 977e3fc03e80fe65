"""Yield stresses of metals, and the plastic strain of a step that they allow.

    linear              Y = Y0 + H ep
    steinberg_guinan    Y = min(Y0 (1 + beta ep)^n, Ymax) S,
                        S = max(1 + a_P P - b_T (T - T_ref), 0) exp(-f T/(T_f - T)), 0 for T >= T_f
    johnson_cook        Y = (A + B ep^n) (1 + C ln max(rate/rate0, 1)) (1 - T*^m),  T* = (T - T_ref)/(T_f - T_ref)

with the plastic strain ep, its rate, the temperature T at the start of the step and the pressure P (Steinberg, Cochran
and Guinan, J. Appl. Phys. 51, 1498, 1980; Johnson and Cook, Proc. 7th Int. Symp. Ballistics, 541, 1983). The increment
dep of the plastic strain solves

    q - G3 dep - Y(ep + dep, dep/dt) = 0,    G3 = 3 mu/max(1 - bend (1 + min(Y(ep, dep/dt)/q, 1)), 0.3)

with the trial stress q and the flow modulus G3 of elasto_plastic.py. Its left side is convex and falls, so Newton's
iteration from the left is monotone: two iterations reach rounding for steinberg_guinan; for johnson_cook, whose power
has an infinite slope at 0, four iterations in ln dep (residual 7e-10), of which each takes G3 at the rate of the one
before it: that changes it by some 1e-3.

`start` returns what the step needs of the state [Y at its beginning without rate, ..]; `flow` returns [dep, slope of Y
at its end, Y at its start with the rate of the step, G3] for f = q - Y > 0; the caller drops dep where f <= 0. No
branches, no library calls.
"""

from typing import Any, NamedTuple

from ..engine import ti
from ..language.precision import by_precision
from ..language.transcendental import exponential, logarithm

FIRST = 5  # place of the first constant of a yield stress among the parameters (elasto_plastic.py)
TINY, TINY_SINGLE = 1e-300, 1e-30
COLDEST = 1e-12  # smallest T*
SMALLEST_STRAIN = 1e-8  # plastic strain in the power of johnson_cook, at least
NEWTON_GUINAN, NEWTON_COOK = 2, 4
SMALLEST = 0.3  # limit of 3 mu/G3 from below
LONGEST = 3.0  # largest change of ln dep in an iteration


class YieldStress(NamedTuple):
    """Functions of a yield stress; parameters: names of its constants; rates: whether it depends on the strain rate.

    start(ep, T, P, parameters) -> list that begins with Y at rest; flow(begin, f, bent, ep, parameters) -> [dep, dY/dep
    at the end, Y at the start at the rate of the step, G3], begin: the list of `start`, bent: [3 mu, bend, 1/q];
    hardened(ep, parameters): Y without softening by heat and rate.
    """

    parameters: tuple[str, ...]
    start: Any
    flow: Any
    hardened: Any
    rates: bool = False


@ti.func
def power(a, exponent):
    """Return a^exponent of a positive number."""
    return exponential(exponent * logarithm(a))


@ti.func
def flow_modulus(strength, bent):
    """Return G3 where Y at the start is `strength`; bent: [3 mu, bend, 1/q]."""
    ratio = ti.min(strength * bent[2], 0.0 * strength + 1.0)
    return bent[0] / ti.max(1.0 - bent[1] * (1.0 + ratio), 0.0 * strength + SMALLEST)


@ti.func
def linear_hardened(ep, parameters):
    return parameters[FIRST] + parameters[FIRST + 1] * ep


@ti.func
def linear_start(ep, temperature, pressure, parameters):
    zero = 0.0 * ep
    return [linear_hardened(ep, parameters), zero + parameters[FIRST + 1]]


@ti.func
def linear_flow(begin, f, bent, ep, parameters):
    modulus = flow_modulus(begin[0], bent)
    return [f / (modulus + begin[1]), begin[1], begin[0], modulus]


@ti.func
def guinan_curve(ep, parameters):
    """Return [Y without softening, its slope times 1 + beta ep, 1 + beta ep]."""
    first, beta, exponent = parameters[FIRST], parameters[FIRST + 1], parameters[FIRST + 2]
    grown = 1.0 + beta * ep
    free = first * power(grown, exponent)
    zero = 0.0 * ep
    most = zero + ti.max(parameters[FIRST + 3], parameters[FIRST])  # HIGH where the yield is off
    return [ti.min(free, most), ti.select(free < most, exponent * beta * free, zero), grown]


@ti.func
def guinan_hardened(ep, parameters):
    return guinan_curve(ep, parameters)[0]


@ti.func
def guinan_start(ep, temperature, pressure, parameters):
    by_pressure, by_heat, sharpness = parameters[FIRST + 4], parameters[FIRST + 5], parameters[FIRST + 6]
    melting, reference = parameters[FIRST + 7], parameters[FIRST + 8]
    zero = 0.0 * ep
    below = ti.max(zero + (melting - temperature), zero + 1e-6 * melting)
    softening = ti.max(1.0 + by_pressure * pressure - by_heat * (temperature - reference), zero)
    softening = softening * exponential(0.0 - sharpness * temperature / below)
    softening = ti.select(zero + temperature < melting, softening, zero)
    curve = guinan_curve(ep, parameters)
    return [softening * curve[0], softening * curve[1], softening, curve[2]]


@ti.func
def guinan_flow(begin, f, bent, ep, parameters):
    zero = 0.0 * ep
    modulus = flow_modulus(begin[0], bent)
    softening, trial = begin[2], f + begin[0]
    dep = f * begin[3] / (modulus * begin[3] + begin[1])
    steep, grown = begin[1], begin[3]
    for _ in ti.static(range(NEWTON_GUINAN)):
        curve = guinan_curve(ep + dep, parameters)
        steep, grown = softening * curve[1], curve[2]
        dep = dep + (trial - modulus * dep - softening * curve[0]) * grown / (modulus * grown + steep)
        dep = ti.max(dep, zero)
    return [dep, steep / grown, begin[0], modulus]


@ti.func
def cook_hardened(ep, parameters):
    strain = ti.max(ep, 0.0 * ep + SMALLEST_STRAIN)
    return parameters[FIRST] + parameters[FIRST + 1] * power(strain, parameters[FIRST + 2])


@ti.func
def cook_start(ep, temperature, pressure, parameters):
    reference, melting = parameters[FIRST + 6], parameters[FIRST + 7]
    zero = 0.0 * ep
    relative = zero + (temperature - reference) / (melting - reference)
    relative = ti.min(ti.max(relative, zero + COLDEST), zero + 1.0)
    softening = 1.0 - power(relative, parameters[FIRST + 5])
    strain = ti.max(ep, zero + SMALLEST_STRAIN)
    grown = parameters[FIRST + 1] * power(strain, parameters[FIRST + 2])
    return [softening * (parameters[FIRST] + grown), softening]


@ti.func
def cook_flow(begin, f, bent, ep, parameters):
    """As `YieldStress` says; the step [s] is the last of the parameters, 0 where there is none: then without rates.

    Where a run begins with a state that has flowed the step is too short to flow in (lanes.RESTING, below 0).
    """
    zero = 0.0 * ep
    initial, factor, exponent = parameters[FIRST], parameters[FIRST + 1], parameters[FIRST + 2]
    by_rate, step = parameters[FIRST + 3], parameters[-1]
    softening, trial = begin[1], f + begin[0]
    tiny = ti.static(by_precision(TINY, TINY_SINGLE))
    safe = ti.max(f, zero + tiny)
    # ln of the increment at which the rate is rate0
    slow = ti.select(step != 0.0, logarithm(ti.max(ti.abs(step) * parameters[FIRST + 4], tiny)), 600.0)
    modulus = flow_modulus(begin[0], bent)
    alpha = ti.max(by_rate * begin[0], 1e-12 * begin[0] + tiny)
    ratio = logarithm(alpha / modulus)
    most = logarithm(safe / modulus)
    kap = safe / alpha + slow - ratio
    large = ti.max(kap, zero + 1.0)
    # w with w + ln w = kap, about
    z = ti.select(kap > 1.0, logarithm(large - logarithm(large)), ti.min(kap, zero + 1.0) - 0.5) + ratio
    z = ti.min(z, most)
    steep, dep = zero, zero
    for _ in ti.static(range(NEWTON_COOK)):
        dep = exponential(z)
        strain = ti.max(ep + dep, zero + SMALLEST_STRAIN)
        grown = factor * power(strain, exponent)
        faster = ti.max(z - slow, zero)
        rise = 1.0 + by_rate * faster
        modulus = flow_modulus(begin[0] * rise, bent)
        hardened = initial + grown
        # dY/d(ln dep)
        steep = softening * (exponent * grown * (dep / strain) * rise)
        steep += softening * hardened * ti.select(faster > 0.0, zero + by_rate, zero)
        left = trial - modulus * dep - softening * hardened * rise
        change = left / (modulus * dep + steep)
        z = ti.min(z + ti.max(ti.min(change, zero + LONGEST), zero - LONGEST), most)
    fast = begin[0] * (1.0 + by_rate * ti.max(z - slow, zero))
    return [exponential(z), steep / dep, fast, modulus]


YIELD_STRESSES = {
    "linear": YieldStress(("Y0", "H"), linear_start, linear_flow, linear_hardened),
    "steinberg_guinan": YieldStress(
        ("Y0", "beta", "n", "Ymax", "a_P", "b_T", "f", "T_f", "T_ref"), guinan_start, guinan_flow, guinan_hardened
    ),
    "johnson_cook": YieldStress(
        ("A", "B", "n", "C", "rate0", "m", "T_ref", "T_f"), cook_start, cook_flow, cook_hardened, rates=True
    ),
}
