"""Yield stress of metals at high pressure and strain rate after Steinberg, Cochran and Guinan."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base import validate


@dataclass(frozen=True)
class SteinbergGuinan:
    """Yield stress Y = min(Y0 (1 + beta ep)^n, Ymax) (1 + a_P P - b_T (T - T_ref)) exp(-f T/(T_f - T)), 0 from T_f on.

    Steinberg, Cochran and Guinan, J. Appl. Phys. 51, 1498 (1980); equation (4) of Le Tallec, Dambakizi and Hauret
    (2007) without their misprints (METHOD 5). T is the absolute temperature, ep the plastic strain, P the pressure.
    Raises `InputError`.

    yield_stress: Y0 [Pa] > 0; hardening: beta [-] > 0; hardening_exponent: n [-], above 0, at most 1; pressure_factor:
    a_P [1/Pa]; thermal_softening: b_T [1/K]; sharpness: f [-]; melting_temperature: T_f [K]; reference_temperature:
    T_ref [K]; largest_yield_stress: Ymax [Pa], None for no limit.
    """

    yield_stress: float
    hardening: float
    hardening_exponent: float
    pressure_factor: float = 0.0
    thermal_softening: float = 0.0
    sharpness: float = 1e-3
    melting_temperature: float = 1e6
    reference_temperature: float = 300.0
    largest_yield_stress: float | None = None

    def __post_init__(self) -> None:
        for name in ("yield_stress", "hardening", "melting_temperature"):
            validate.keep(self, name, low=0.0)
        validate.keep(self, "hardening_exponent", low=0.0)
        validate.keep(self, "hardening_exponent", high=1.0, strict=False)
        for name in ("pressure_factor", "thermal_softening", "sharpness", "reference_temperature"):
            validate.keep(self, name, low=0.0, strict=False)
        if self.largest_yield_stress is not None:
            validate.keep(self, "largest_yield_stress", low=self.yield_stress, strict=False)

    def yields_at(self, temperature: np.ndarray, pressure: np.ndarray, plastic_strain: np.ndarray) -> np.ndarray:
        """Return the yield stress Y [Pa] at absolute temperature [K], pressure [Pa] and equivalent plastic strain [-].

        The three broadcast together; 0 where the metal has no strength left.
        """
        t, p, ep = (np.asarray(value, dtype=float) for value in (temperature, pressure, plastic_strain))
        softening = 1.0 + self.pressure_factor * p - self.thermal_softening * (t - self.reference_temperature)
        solid = (t < self.melting_temperature) & (softening > 0.0)
        room = np.where(solid, self.melting_temperature - t, 1.0)
        hardened = self.yield_stress * (1.0 + self.hardening * ep) ** self.hardening_exponent
        if self.largest_yield_stress is not None:
            hardened = np.minimum(hardened, self.largest_yield_stress)
        return np.where(solid, hardened * softening * np.exp(-self.sharpness * t / room), 0.0)
