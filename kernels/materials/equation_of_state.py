"""Pressure of a metal from its volume: energy U of the change of volume, with e = J - 1.

    bulk               U = K/2 e^2
    barrier            U = K/4 (J^2 - 1 - 2 ln J): grows without limit as J falls to 0
    mie_grueneisen     from shock curve and heat (mie_grueneisen.py)

All give p = -U' = -K e at small strains.
"""

from typing import Any, NamedTuple

from ..engine import ti
from ..language.transcendental import log_split
from . import mie_grueneisen

WARMING = 7  # place of the temperature rise in the state of a point


class EquationOfState(NamedTuple):
    """An equation of state; parameters, state: names of its constants beyond the bulk modulus, of numbers of state.

    functions(first) -> (volume, warmed, heated), first: place of the constants among the parameters:
    volume(e, parameters, old) -> [U', U, U''], all in proportion to parameters[0], the bulk modulus;
    warmed(e, parameters, old, rise) -> numbers of the state from the temperature rise on, at e and after heat that
    raises the temperature by `rise` [K]; heated(old, parameters, rise): the same at the e of the stored state.
    """

    functions: Any
    parameters: tuple[str, ...] = ()
    state: tuple[str, ...] = ()


@ti.func
def bulk(e, parameters, old):
    modulus = parameters[0]
    return [modulus * e, 0.5 * modulus * e * e, modulus + 0.0 * e]


@ti.func
def barrier(e, parameters, old):
    modulus = parameters[0]
    split = log_split(e)
    pressure = 0.5 * modulus * (e + e * split[1])  # J - 1/J = e + e/J
    energy = 0.25 * modulus * (e * e + 2.0 * split[0])
    return [pressure, energy, 0.5 * modulus * (1.0 + split[1] * split[1])]


@ti.func
def warmed(e, parameters, old, rise):
    return [old[WARMING] + rise]


@ti.func
def heated(old, parameters, rise):
    return [old[WARMING] + rise]


EQUATIONS_OF_STATE = {
    "bulk": EquationOfState(lambda first: (bulk, warmed, heated)),
    "barrier": EquationOfState(lambda first: (barrier, warmed, heated)),
    "mie_grueneisen": EquationOfState(mie_grueneisen.make_functions, mie_grueneisen.PARAMETERS, mie_grueneisen.STATE),
}
