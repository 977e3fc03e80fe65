"""Rules of implicit schemes: the stress S* of a time step that each rule makes of a law, and its derivative (METHOD 4).

    F_m = (F0 + F1)/2,  C_m = (C0 + C1)/2,  dC = C1 - C0 = 2 dE,  f* = int F_m S* : grad U,  S*:dC/2 = W1 - W0 wanted

    end            S(C1), with F1: backward Euler; also what the trapezoidal and the midpoint rule put together
    transport      S(C_m)
    mean           (S(C0) + S(C1))/2
    gonzalez       S(C_m) + [W1 - W0 - S(C_m):dE] dE/(dE:dE), correction dropped where |dC| < 1e-5 (paper eq. 12)
    discrete       invariant by invariant: W = a (I1-3) + b (I2-3) + h(J) + quadratic(E),
                   S* = 2a I + 2b (tr(C_m) I - C_m) + 2q G + quadratic'(E_m),  q = [h(J1) - h(J0)]/(J1 - J0),
                   G of implicit_geometry.py; a law has it or not (`StepLaw` of materials/law.py)
    dissipative    discrete + chi/2 (S(C1) - S(C0))

A rule gives S*; P = F S* with the F of the rule, and f* = int P : grad U. `law` is the `StepLaw` of a nonlinear law.
With mean dilatation (`implicit_cells.dilatations`) parameters[0] is 0 here, and the cell pressures p0, p1 =
lam (Theta - 1) of the two levels replace it, as (p0 + p1)/2 2 G where S* is discrete.
"""

from ..engine import ti
from ..language.implicit_geometry import (
    cofactor,
    identity,
    inner,
    inverse_metric,
    middle,
    volume_slope,
    volume_slope_change,
)

SMALL_CHANGE = 1e-5  # |dC| below which Gonzalez' correction is dropped
DISCRETE = ("discrete", "dissipative")  # rules that need the `discrete` stress of a law


def has_rule(law, rule: str) -> bool:
    """Return whether a law (materials/law.py) has the functions that a rule needs; the linear law has its own rules.

    No rule carries the state of a law from one step to the next.
    """
    if law.state:
        return False
    return law.linear or (law.step is not None and (rule not in DISCRETE or law.step.discrete is not None))


@ti.func
def corrected(stress, de, work):
    """Return stress + [work - stress:dE] dE/(dE:dE), Gonzalez' correction."""
    result = stress
    square = inner(de, de)
    if 4.0 * square >= SMALL_CHANGE * SMALL_CHANGE:
        result += (work - inner(stress, de)) / square * de
    return result


@ti.func
def corrected_change(stress, de, work, stress_change, along, power):
    """Return the derivative of `corrected`; power: derivative of the work."""
    result = stress_change
    square = inner(de, de)
    if 4.0 * square >= SMALL_CHANGE * SMALL_CHANGE:
        share = (work - inner(stress, de)) / square
        change = (power - inner(stress_change, de) - inner(stress, along) - 2.0 * share * inner(de, along)) / square
        result += change * de + share * along
    return result


@ti.func
def step_stress(law: ti.template(), rule: ti.template(), e0, e1, de, j0, j1, parameters, chi):
    """Return S* of a nonlinear law."""
    result = ti.Matrix.zero(ti.f64, 3, 3)
    if ti.static(rule == "end"):
        result = law.stress(e1, j1, parameters)
    elif ti.static(rule == "mean"):
        result = 0.5 * (law.stress(e0, j0, parameters) + law.stress(e1, j1, parameters))
    elif ti.static(rule in ("transport", "gonzalez")):
        e, j = middle(e0, e1)
        result = law.stress(e, j, parameters)
        if ti.static(rule == "gonzalez"):
            work = law.energy(e1, j1, parameters) - law.energy(e0, j0, parameters)
            result = corrected(result, de, work)
    else:
        result = law.discrete(e0, e1, de, j0, j1, parameters)
        if ti.static(rule == "dissipative"):
            result += 0.5 * chi * (law.stress(e1, j1, parameters) - law.stress(e0, j0, parameters))
    return result


@ti.func
def step_stress_change(law: ti.template(), rule: ti.template(), e0, e1, de, j0, j1, parameters, chi, along, growth):
    """Return the derivative of S* along a change of E1 that makes J1 grow by `growth`."""
    result = ti.Matrix.zero(ti.f64, 3, 3)
    if ti.static(rule == "end"):
        result = law.stress_change(e1, j1, parameters, along)
    elif ti.static(rule == "mean"):
        result = 0.5 * law.stress_change(e1, j1, parameters, along)
    elif ti.static(rule in ("transport", "gonzalez")):
        e, j = middle(e0, e1)
        result = law.stress_change(e, j, parameters, 0.5 * along)
        if ti.static(rule == "gonzalez"):
            work = law.energy(e1, j1, parameters) - law.energy(e0, j0, parameters)
            power = inner(law.stress(e1, j1, parameters), along)
            result = corrected_change(law.stress(e, j, parameters), de, work, result, along, power)
    else:
        result = law.discrete_change(e0, e1, de, j0, j1, parameters, along, growth)
        if ti.static(rule == "dissipative"):
            result += 0.5 * chi * law.stress_change(e1, j1, parameters, along)
    return result


@ti.func
def mean_stress(rule: ti.template(), e0, e1, de, j0, j1, p0, p1, chi):
    """Return the part of S* from the pressures of the cell, and its derivative by p1."""
    slope = ti.Matrix.zero(ti.f64, 3, 3)
    result = ti.Matrix.zero(ti.f64, 3, 3)
    if ti.static(rule == "end"):
        slope = (1.0 + j1) * inverse_metric(e1, j1)
        result = p1 * slope
    elif ti.static(rule == "mean"):
        slope = 0.5 * (1.0 + j1) * inverse_metric(e1, j1)
        result = p1 * slope + 0.5 * p0 * (1.0 + j0) * inverse_metric(e0, j0)
    else:
        slope = volume_slope(e0, e1, de, j0, j1)[1]
        result = (p0 + p1) * slope
        if ti.static(rule == "dissipative"):
            more = 0.5 * chi * (1.0 + j1) * inverse_metric(e1, j1)
            result += p1 * more - 0.5 * chi * p0 * (1.0 + j0) * inverse_metric(e0, j0)
            slope += more
    return result, slope


@ti.func
def metric_change(e, j, along, growth):
    """Return the derivative of J C^-1."""
    inverse = inverse_metric(e, j)
    return growth * inverse - 2.0 * (1.0 + j) * (inverse @ along @ inverse)


@ti.func
def mean_stress_change(rule: ti.template(), e0, e1, de, j0, j1, p0, p1, chi, along, growth):
    """Return the derivative of the first result of `mean_stress` at fixed pressures."""
    result = ti.Matrix.zero(ti.f64, 3, 3)
    if ti.static(rule == "end"):
        result = p1 * metric_change(e1, j1, along, growth)
    elif ti.static(rule == "mean"):
        result = 0.5 * p1 * metric_change(e1, j1, along, growth)
    else:
        result = (p0 + p1) * volume_slope_change(e0, e1, de, j0, j1, along, growth)[1]
        if ti.static(rule == "dissipative"):
            result += 0.5 * chi * p1 * metric_change(e1, j1, along, growth)
    return result


@ti.func
def volume_growth(h1, d):
    """Return the derivative of J1 along D."""
    return inner(cofactor(identity() + h1), d)
