"""The exact waves of a metal plate with linear hardening that strikes a rigid wall in uniaxial strain.

With m = 1 - J behind a wave, reference density rho, Lagrangian speed D of a jump from state 1 to state 2:

    u1 - u2 = D (m2 - m1),   sigma2 - sigma1 = rho D (u1 - u2),   e2 - e1 = (sigma1 + sigma2) (m2 - m1)/2

An elastic jump to the yield limit runs ahead of the plastic one unless the latter is faster: then one jump does all. On
the yield surface lambda, the elastic stretch at constant volume along the axis, solves

    mu (1/lambda - lambda^2) = Y(ep),   ep = ln lambda - 2/3 ln J,   sigma = p + 2/3 Y/J

The pressure is p(J), or that of the shock curve Us = c0 + s up with the energy e' of volume and heat (all that is
neither elastic change of shape nor cold work), p = p_H + Gamma (e' - p_H m/2), with p_H = rho c0^2 m/(1 - s m)^2. The
temperature is T = T_H + (e' - p_H m/2)/(rho c), where T_H along the shock curve solves

    dT_H/dm = Gamma T_H + (m dp_H/dm - p_H)/(2 rho c),   T_H(0) = T0
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

import tcontact as tc

STEPS = 100  # of the integration of T_H
MOST = 0.6  # compression m searched, at most; with a shock curve 0.9/s


@dataclass(frozen=True)
class State:
    """Behind a jump: m = 1 - J, stress [Pa], pressure [Pa], plastic strain, temperature [K], energy [J/m^3]."""

    compression: float
    stress: float
    pressure: float
    strain: float
    temperature: float
    energy: float


@dataclass(frozen=True)
class MetalShock:
    """The waves at a wall that a plate of this metal strikes with a speed [m/s]; the plate rests behind them.

    Raises `InputError` where the wave is elastic, or the hardening is not linear.
    """

    metal: tc.ElastoPlastic
    speed: float

    def __post_init__(self) -> None:
        if not isinstance(self.metal.hardening, tc.LinearHardening):
            raise tc.InputError("metal.hardening", self.metal.hardening, "the exact waves are for LinearHardening")
        if self.speed <= self.elastic.stress / (self.metal.density * self.elastic_speed):
            raise tc.InputError("speed", self.speed, "the wave at the wall is elastic; give a larger speed")

    @cached_property
    def elastic(self) -> State:
        """The state at the yield limit, behind the elastic jump."""
        metal = self.metal
        stretch = self._stretch(metal.hardening.yield_stress)
        m = -np.expm1(1.5 * np.log(stretch))
        _shape, normal = self._shape(m, 0.0, stretch)
        pressure = self._at_rest(m)[0]
        stress = pressure + normal
        return State(m, stress, pressure, 0.0, metal.initial_temperature, 0.5 * stress * m)

    @property
    def elastic_speed(self) -> float:
        """Speed of the elastic jump [m/s], of the reference state as all speeds here."""
        return float(np.sqrt(self.elastic.stress / (self.metal.density * self.elastic.compression)))

    @cached_property
    def overdriven(self) -> bool:
        """Whether one jump does all."""
        first, second = self.elastic, self._behind(self.elastic, self._left)
        rise = (second.stress - first.stress) / (second.compression - first.compression)
        return bool(rise > self.metal.density * self.elastic_speed**2)

    @property
    def ahead(self) -> State:
        """The state ahead of the plastic jump."""
        start = State(0.0, 0.0, 0.0, 0.0, self.metal.initial_temperature, 0.0)
        return start if self.overdriven else self.elastic

    @cached_property
    def behind(self) -> State:
        """The state behind both jumps, at the wall."""
        return self._behind(self.ahead, self.speed if self.overdriven else self._left)

    @property
    def shock_speed(self) -> float:
        """Speed of the plastic jump [m/s]."""
        one, two = self.ahead, self.behind
        return float(np.sqrt((two.stress - one.stress) / (self.metal.density * (two.compression - one.compression))))

    @property
    def _left(self) -> float:
        """Speed [m/s] behind the elastic jump."""
        return self.speed - self.elastic.stress / (self.metal.density * self.elastic_speed)

    def _behind(self, ahead: State, jump: float) -> State:
        """Return the state in which the plate has lost `jump` [m/s] of its speed."""

        def excess(m: float) -> float:
            stress = self._state(m, ahead).stress
            return (stress - ahead.stress) * (m - ahead.compression) - self.metal.density * jump**2

        most = MOST
        if isinstance(self.metal.pressure, tc.MieGrueneisen):
            most = min(MOST, 0.9 / max(self.metal.pressure.slope, 1e-9))
        found = self._state(_root(excess, ahead.compression, most), ahead)
        if isinstance(self.metal.pressure, tc.MieGrueneisen):
            return replace(found, temperature=found.temperature + self.curve_temperature(found.compression))
        return found

    def _state(self, m: float, ahead: State) -> State:
        """Return the state behind a jump to m on the yield surface; of MieGrueneisen the temperature less T_H."""
        metal, law = self.metal, self.metal.hardening

        def off(ep: float) -> float:
            return np.log(self._stretch(law.yield_stress + law.modulus * ep)) - 2.0 / 3.0 * np.log1p(-m) - ep

        ep = _root(lambda ep: -off(ep), 0.0, -np.log1p(-m)) if off(0.0) > 0.0 else 0.0
        shape, normal = self._shape(m, ep)
        cold = (1.0 - metal.heat_share) * ep * (law.yield_stress + 0.5 * law.modulus * ep)
        known = ahead.energy + 0.5 * ahead.stress * (m - ahead.compression) - shape - cold
        half = 0.5 * (m - ahead.compression)  # e' = known + half sigma
        capacity = np.inf if metal.specific_heat is None else metal.density * metal.specific_heat
        if not isinstance(metal.pressure, tc.MieGrueneisen):
            pressure, stored = self._at_rest(m)
            heat = known + half * (pressure + normal) - stored
            temperature = metal.initial_temperature + heat / capacity
        else:
            gamma = metal.pressure.gamma
            on_curve, _slope = self._shock_curve(m)
            pressure = on_curve + gamma * (known + half * normal - 0.5 * on_curve * m)
            pressure /= 1.0 - gamma * half
            heat = known + half * (pressure + normal) - 0.5 * on_curve * m
            temperature = heat / capacity
        energy = known + shape + cold + half * (pressure + normal)
        return State(m, pressure + normal, pressure, ep, temperature, energy)

    def _stretch(self, strength: float) -> float:
        """Return lambda on the yield surface."""
        return _root(lambda x: self.metal.lame_mu * (x * x - 1.0 / x) + strength, 0.5, 1.0)

    def _shape(self, m: float, ep: float, stretch: float | None = None) -> tuple[float, float]:
        """Return the elastic energy of the change of shape [J/m^3] and 2/3 Y/J [Pa]."""
        mu, law = self.metal.lame_mu, self.metal.hardening
        x = self._stretch(law.yield_stress + law.modulus * ep) if stretch is None else stretch
        return 0.5 * mu * (x * x + 2.0 / x - 3.0), 2.0 / 3.0 * mu * (1.0 / x - x * x) / (1.0 - m)

    def _at_rest(self, m: float) -> tuple[float, float]:
        """Return pressure and energy of a change of volume without heat; of MieGrueneisen only for a small one."""
        bulk, jacobian = self.metal.bulk_modulus, 1.0 - m
        if self.metal.pressure == "barrier":
            stored = 0.25 * bulk * (jacobian * jacobian - 1.0 - 2.0 * np.log1p(-m))
            return 0.5 * bulk * (1.0 / jacobian - jacobian), stored
        if isinstance(self.metal.pressure, tc.MieGrueneisen):
            return self._shock_curve(m)[0], 0.5 * self._shock_curve(m)[0] * m
        return bulk * m, 0.5 * bulk * m * m

    def _shock_curve(self, m: float) -> tuple[float, float]:
        """Return p_H and dp_H/dm [Pa]."""
        bulk, slope = self.metal.bulk_modulus, self.metal.pressure.slope
        left = 1.0 - slope * m
        return bulk * m / left**2, bulk * (1.0 + slope * m) / left**3

    def curve_temperature(self, m: float) -> float:
        """Return T_H [K] by the classical Runge-Kutta method."""
        metal = self.metal
        scale = 0.5 / (metal.density * metal.specific_heat)

        def rate(x: float, temperature: float) -> float:
            pressure, slope = self._shock_curve(x)
            return metal.pressure.gamma * temperature + scale * (x * slope - pressure)

        h, found = m / STEPS, metal.initial_temperature
        for step in range(STEPS):
            x = step * h
            one = rate(x, found)
            two = rate(x + 0.5 * h, found + 0.5 * h * one)
            three = rate(x + 0.5 * h, found + 0.5 * h * two)
            found += h / 6.0 * (one + 2.0 * two + 2.0 * three + rate(x + h, found + h * three))
        return found


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    """Return where a rising function changes its sign between two numbers, by bisection."""
    for _ in range(100):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if function(middle) < 0.0 else (low, middle)
    return 0.5 * (low + high)
