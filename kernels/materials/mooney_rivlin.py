"""Mooney-Rivlin: W = c1 (I1 - 3) + c2 (I2 - 3) - 2 (c1 + 2 c2) ln J + bulk/2 (J - 1)^2,  I2 = ((tr C)^2 - tr C^2)/2.

I1 - 3 = 2 tr E and I2 - 3 = 4 tr E + 2 ((tr E)^2 - E:E), so the law is the sum of the neo-Hookean law with bulk and
M = 2 (c1 + 2 c2), and of the St Venant-Kirchhoff law with lam = 4 c2 and mu = -2 c2. Stress, second derivative and
discrete stress are sums too. parameters: bulk, M, 4 c2.
"""

from ..engine import ti
from . import neo_hookean, st_venant_kirchhoff
from .law import Law, StepLaw


@ti.func
def quadratic(parameters):
    """Return lam and mu of the St Venant-Kirchhoff part."""
    return [parameters[2], -0.5 * parameters[2]]


@ti.func
def update(h, parameters):
    first = neo_hookean.update(h, parameters)
    second = st_venant_kirchhoff.update(h, quadratic(parameters))
    stress = [[first[0][i][j] + second[0][i][j] for j in range(3)] for i in range(3)]
    return [stress, first[1] + second[1], first[2]]


@ti.func
def quadratic_tangent(f, parameters, pressure):
    return st_venant_kirchhoff.tangent(f, quadratic(parameters), pressure)


def summed(first, second):
    """Return the sum of a function of the neo-Hookean part and one of the quadratic part."""

    @ti.func
    def both(e, j, parameters):
        return first(e, j, parameters) + second(e, j, quadratic(parameters))

    return both


@ti.func
def stress_change(e, j, parameters, along):
    neo = neo_hookean.stress_change(e, j, parameters, along)
    return neo + st_venant_kirchhoff.stress_change(e, j, quadratic(parameters), along)


@ti.func
def discrete(e0, e1, de, j0, j1, parameters):
    neo = neo_hookean.discrete(e0, e1, de, j0, j1, parameters)
    return neo + st_venant_kirchhoff.discrete(e0, e1, de, j0, j1, quadratic(parameters))


@ti.func
def discrete_change(e0, e1, de, j0, j1, parameters, along, growth):
    neo = neo_hookean.discrete_change(e0, e1, de, j0, j1, parameters, along, growth)
    green = st_venant_kirchhoff.discrete_change(e0, e1, de, j0, j1, quadratic(parameters), along, growth)
    return neo + green


LAW = Law(
    ("bulk", "M", "4 c2"),
    update,
    (*neo_hookean.LAW.tangents, st_venant_kirchhoff.LAW.tangents[0]._replace(point=quadratic_tangent)),
    StepLaw(
        summed(neo_hookean.energy, st_venant_kirchhoff.energy),
        summed(neo_hookean.stress, st_venant_kirchhoff.stress),
        stress_change,
        discrete,
        discrete_change,
    ),
)
