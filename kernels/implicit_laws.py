"""Laws of a time step: the stress that a rule of `implicit_stress` gives each law, and its derivative.

A law is (neo, green, lam and mu of the first, of the second); linear elasticity stands alone. moduli as in laws.py.
Rules answer P with int P : grad U = f*, that is F S with the F of the rule; `change` the derivative along D = dF1.
Mean dilatation (per cell, `implicit_cells.dilatations`): lam of the neo part is left out here and the pressures
p0, p1 = lam (Theta - 1) of the levels take its place, in the discrete form (p0 + p1)/2 2 G where S* is discrete.
"""

import taichi as ti

from .implicit_stress import (
    cofactor,
    corrected,
    corrected_change,
    green_energy,
    green_stress,
    identity,
    inner,
    inverse_metric,
    middle,
    neo_change,
    neo_discrete,
    neo_discrete_change,
    neo_energy,
    neo_stress,
    volume_slope,
    volume_slope_change,
)

PARTS = {  # law: whether it has a neo part, a green part
    "linear_elastic": (False, False),
    "st_venant_kirchhoff": (False, True),
    "neo_hookean": (True, False),
    "mooney_rivlin": (True, True),
}
RULES = ("end", "transport", "mean", "gonzalez", "discrete", "dissipative")


@ti.func
def second_moduli(law: ti.template(), moduli):
    """lam, mu of the green part."""
    lam, mu = moduli[0], moduli[1]
    if ti.static(law == "mooney_rivlin"):
        lam, mu = moduli[2], -0.5 * moduli[2]
    return lam, mu


@ti.func
def energy(law: ti.template(), e, j, moduli):
    result = 0.0
    if ti.static(PARTS[law][0]):
        result += neo_energy(e, j, moduli[0], moduli[1])
    if ti.static(PARTS[law][1]):
        lam, mu = second_moduli(law, moduli)
        result += green_energy(e, lam, mu)
    return result


@ti.func
def stress(law: ti.template(), e, j, moduli):
    """S(C)"""
    result = ti.Matrix.zero(ti.f64, 3, 3)
    if ti.static(PARTS[law][0]):
        result += neo_stress(e, j, moduli[0], moduli[1])
    if ti.static(PARTS[law][1]):
        lam, mu = second_moduli(law, moduli)
        result += green_stress(e, lam, mu)
    return result


@ti.func
def stress_change(law: ti.template(), e, j, moduli, along):
    """Derivative of S(C) along a change of E."""
    result = ti.Matrix.zero(ti.f64, 3, 3)
    if ti.static(PARTS[law][0]):
        result += neo_change(e, j, moduli[0], moduli[1], along)
    if ti.static(PARTS[law][1]):
        lam, mu = second_moduli(law, moduli)
        result += green_stress(along, lam, mu)
    return result


@ti.func
def discrete(law: ti.template(), e0, e1, de, j0, j1, moduli):
    result = ti.Matrix.zero(ti.f64, 3, 3)
    if ti.static(PARTS[law][0]):
        result += neo_discrete(e0, e1, de, j0, j1, moduli[0], moduli[1])
    if ti.static(PARTS[law][1]):
        lam, mu = second_moduli(law, moduli)
        result += green_stress(0.5 * (e0 + e1), lam, mu)
    return result


@ti.func
def discrete_change(law: ti.template(), e0, e1, de, j0, j1, moduli, along, growth):
    result = ti.Matrix.zero(ti.f64, 3, 3)
    if ti.static(PARTS[law][0]):
        result += neo_discrete_change(e0, e1, de, j0, j1, moduli[0], moduli[1], along, growth)
    if ti.static(PARTS[law][1]):
        lam, mu = second_moduli(law, moduli)
        result += green_stress(0.5 * along, lam, mu)
    return result


@ti.func
def step_stress(law: ti.template(), rule: ti.template(), e0, e1, de, j0, j1, moduli, chi):
    """S* of a nonlinear law."""
    result = ti.Matrix.zero(ti.f64, 3, 3)
    if ti.static(rule == "end"):
        result = stress(law, e1, j1, moduli)
    elif ti.static(rule == "mean"):
        result = 0.5 * (stress(law, e0, j0, moduli) + stress(law, e1, j1, moduli))
    elif ti.static(rule in ("transport", "gonzalez")):
        e, j = middle(e0, e1)
        result = stress(law, e, j, moduli)
        if ti.static(rule == "gonzalez"):
            work = energy(law, e1, j1, moduli) - energy(law, e0, j0, moduli)
            result = corrected(result, de, work)
    else:
        result = discrete(law, e0, e1, de, j0, j1, moduli)
        if ti.static(rule == "dissipative"):
            result += 0.5 * chi * (stress(law, e1, j1, moduli) - stress(law, e0, j0, moduli))
    return result


@ti.func
def step_stress_change(law: ti.template(), rule: ti.template(), e0, e1, de, j0, j1, moduli, chi, along, growth):
    """Derivative of S* along a change of E1 that makes J1 grow by `growth`."""
    result = ti.Matrix.zero(ti.f64, 3, 3)
    if ti.static(rule == "end"):
        result = stress_change(law, e1, j1, moduli, along)
    elif ti.static(rule == "mean"):
        result = 0.5 * stress_change(law, e1, j1, moduli, along)
    elif ti.static(rule in ("transport", "gonzalez")):
        e, j = middle(e0, e1)
        result = stress_change(law, e, j, moduli, 0.5 * along)
        if ti.static(rule == "gonzalez"):
            work = energy(law, e1, j1, moduli) - energy(law, e0, j0, moduli)
            power = inner(stress(law, e1, j1, moduli), along)
            result = corrected_change(stress(law, e, j, moduli), de, work, result, along, power)
    else:
        result = discrete_change(law, e0, e1, de, j0, j1, moduli, along, growth)
        if ti.static(rule == "dissipative"):
            result += 0.5 * chi * stress_change(law, e1, j1, moduli, along)
    return result


@ti.func
def mean_stress(rule: ti.template(), e0, e1, de, j0, j1, p0, p1, chi):
    """The part of S* from the pressures of the cell, and what a unit of p1 adds to S*: [S, dS/dp1]."""
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
    """Derivative of J C^-1."""
    inverse = inverse_metric(e, j)
    return growth * inverse - 2.0 * (1.0 + j) * (inverse @ along @ inverse)


@ti.func
def mean_stress_change(rule: ti.template(), e0, e1, de, j0, j1, p0, p1, chi, along, growth):
    """Derivative of its first answer at fixed pressures."""
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
def linear_stress(h, moduli):
    return moduli[0] * h.trace() * identity() + moduli[1] * (h + h.transpose())


@ti.func
def linear_energy(h, moduli):
    return 0.5 * inner(linear_stress(h, moduli), h)


@ti.func
def volume_growth(h1, d):
    """Derivative of J1 along D."""
    return inner(cofactor(identity() + h1), d)
