"""Metals of the friction layer: yield stress after Steinberg, Cochran and Guinan, and heat conduction."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base import validate
from ..base.errors import InputError
from .steinberg_guinan import SteinbergGuinan


@dataclass(frozen=True)
class Metal:
    """A metal with Y = Y0 (1 + beta ep)^n (1 + a_P P - b_T (T - T_ref)) exp(-f T/(T_f - T)) and its heat conduction.

    Equation (4) of Le Tallec, Dambakizi and Hauret (2007) without their misprints (METHOD 5). T is the absolute
    temperature. Limits of no hardening and no sharp melting are small numbers, not 0: hardening = 1e-3 with
    hardening_exponent = 1, sharpness -> 0. Raises `InputError`.

    shear_modulus: G [Pa]; yield_stress: Y0 [Pa]; hardening: beta [-]; hardening_exponent: n [-], at most 1;
    pressure_factor: a_P [1/Pa]; thermal_softening: b_T [1/K]; sharpness: f [-]; melting_temperature: T_f [K];
    reference_temperature: T_ref [K]; conductivity: k [W/(m K)]; heat_capacity: c [J/(kg K)]; density: rho [kg/m^3].
    """

    shear_modulus: float
    yield_stress: float
    hardening: float
    hardening_exponent: float
    pressure_factor: float
    thermal_softening: float
    sharpness: float
    melting_temperature: float
    conductivity: float
    heat_capacity: float
    density: float
    reference_temperature: float = 300.0

    def __post_init__(self) -> None:
        self.hardening_law  # noqa: B018 - checks the constants of the yield stress
        for name in ("shear_modulus", "conductivity", "heat_capacity", "density"):
            validate.keep(self, name, low=0.0)

    @property
    def effusivity(self) -> float:
        """Effusivity sqrt(k rho c) [J/(m^2 K s^(1/2))]: two bodies in sliding contact share the heat in this ratio."""
        return (self.conductivity * self.volumetric_heat) ** 0.5

    @property
    def diffusivity(self) -> float:
        """Thermal diffusivity k/(rho c) [m^2/s]."""
        return self.conductivity / self.volumetric_heat

    @property
    def volumetric_heat(self) -> float:
        """Heat capacity per volume rho c [J/(m^3 K)]."""
        return self.density * self.heat_capacity

    @property
    def hardening_law(self) -> SteinbergGuinan:
        """Its yield stress alone, as `ElastoPlastic` takes it."""
        return SteinbergGuinan(
            self.yield_stress,
            self.hardening,
            self.hardening_exponent,
            self.pressure_factor,
            self.thermal_softening,
            self.sharpness,
            self.melting_temperature,
            self.reference_temperature,
        )

    def yields_at(self, temperature: np.ndarray, pressure: np.ndarray, plastic_strain: np.ndarray) -> np.ndarray:
        """Return the yield stress Y [Pa], see `SteinbergGuinan.yields_at`."""
        return self.hardening_law.yields_at(temperature, pressure, plastic_strain)


STAINLESS_304 = Metal(
    shear_modulus=77e9,
    yield_stress=0.34e9,
    hardening=43.0,
    hardening_exponent=0.35,
    pressure_factor=2.26e-11,
    thermal_softening=4.55e-4,
    sharpness=1e-3,
    melting_temperature=1900.0,
    conductivity=16.2,
    heat_capacity=500.0,
    density=7900.0,
)
"""Stainless steel 304: Steinberg, Cochran, Guinan, J. Appl. Phys. 51, 1498 (1980); T_f after the paper (METHOD 5)."""

COPPER = Metal(
    shear_modulus=47.7e9,
    yield_stress=0.12e9,
    hardening=36.0,
    hardening_exponent=0.45,
    pressure_factor=2.83e-11,
    thermal_softening=3.77e-4,
    sharpness=1e-3,
    melting_temperature=1356.0,
    conductivity=401.0,
    heat_capacity=385.0,
    density=8930.0,
)
"""OFHC copper: G, Y0, beta, n, G'_P/G0 and -G'_T/G0 as in Steinberg, Cochran and Guinan (1980) and Steinberg's report
UCRL-MA-106439 (1996); handbook values (CRC) for melting at ambient pressure, k, c, rho at room temperature."""

ALUMINIUM_6061 = Metal(
    shear_modulus=27.6e9,
    yield_stress=0.29e9,
    hardening=125.0,
    hardening_exponent=0.10,
    pressure_factor=6.52e-11,
    thermal_softening=6.16e-4,
    sharpness=1e-3,
    melting_temperature=855.0,
    conductivity=167.0,
    heat_capacity=896.0,
    density=2703.0,
)
"""Aluminium 6061-T6: Steinberg, Cochran and Guinan (1980) and UCRL-MA-106439 (1996) as for copper; T_f the solidus of
the alloy, k and c at room temperature from the usual data sheets (ASM)."""


def checked_metal(field: str, given: Any) -> None:
    """Refuse what is neither a metal nor None. Raises `InputError`."""
    if given is not None and not isinstance(given, Metal):
        raise InputError(field, given, "give a friction_layer.Metal, such as STAINLESS_304, or None")


METALS = {"stainless-304": STAINLESS_304, "copper": COPPER, "aluminium-6061": ALUMINIUM_6061}
