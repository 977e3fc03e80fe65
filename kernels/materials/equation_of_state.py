"""Pressure of a metal from its volume: energy U(J) of the change of volume, with e = J - 1.

    bulk       U = K/2 e^2
    barrier    U = K/4 (J^2 - 1 - 2 ln J): grows without limit as J falls to 0

Both give p = -U' = -K e at small strains.
"""

from typing import Any, NamedTuple

import taichi as ti

from ..language.transcendental import log_split


class EquationOfState(NamedTuple):
    """volume(e, parameters, old) -> [U', U, U'']; parameters: names of its constants beyond the bulk modulus."""

    parameters: tuple[str, ...]
    volume: Any


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


EQUATIONS_OF_STATE = {"bulk": EquationOfState((), bulk), "barrier": EquationOfState((), barrier)}
