"""Metals: elasticity with plastic flow and heat, and the yield stresses to choose from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from ..base import validate
from ..base.errors import InputError
from ..friction_layer.metals import Metal
from ..friction_layer.steinberg_guinan import SteinbergGuinan
from .materials import Hookean

LARGEST_ELASTIC_STRAIN = 0.1  # Y0/mu at most: the flow modulus is an expansion in the elastic strain
UNLIMITED = 1e100  # a largest yield stress [Pa] that is never reached


@dataclass(frozen=True)
class LinearHardening:
    """Yield stress Y = Y0 + H ep, with the plastic strain ep.

    yield_stress: Y0 [Pa] > 0; modulus: H [Pa] >= 0, 0 for perfect plasticity. Raises `InputError` for any other value;
    softening (H < 0) is refused because the result would depend on the mesh.
    """

    yield_stress: float
    modulus: float = 0.0

    def __post_init__(self) -> None:
        validate.keep(self, "yield_stress", low=0.0)
        validate.keep(self, "modulus", low=0.0, strict=False)


@dataclass(frozen=True)
class JohnsonCook:
    """Yield stress Y = (A + B ep^n) (1 + C ln max(rate/rate0, 1)) (1 - T*^m), T* = (T - T_ref)/(T_f - T_ref) in 0..1.

    yield_stress: A [Pa] > 0; hardening: B [Pa] >= 0; hardening_exponent: n, above 0, at most 1; rate_factor: C >= 0;
    reference_rate: rate0 [1/s] > 0; softening_exponent: m > 0; reference_temperature: T_ref [K];
    melting_temperature: T_f [K] > T_ref. The rate is that of the plastic strain in the step, taken implicitly; the
    temperature that at its start. Raises `InputError`. (Johnson and Cook, Proc. 7th Int. Symp. Ballistics, 541, 1983.)
    """

    yield_stress: float
    hardening: float
    hardening_exponent: float
    rate_factor: float = 0.0
    softening_exponent: float = 1.0
    melting_temperature: float = 1e6
    reference_temperature: float = 298.0
    reference_rate: float = 1.0

    def __post_init__(self) -> None:
        validate.keep(self, "yield_stress", low=0.0)
        validate.keep(self, "hardening_exponent", low=0.0)
        validate.keep(self, "hardening_exponent", high=1.0, strict=False)
        for name in ("hardening", "rate_factor", "reference_temperature"):
            validate.keep(self, name, low=0.0, strict=False)
        for name in ("softening_exponent", "reference_rate"):
            validate.keep(self, name, low=0.0)
        validate.keep(self, "melting_temperature", low=self.reference_temperature)


@dataclass(frozen=True)
class MieGrueneisen:
    """Pressure of a metal from its shock curve Us = c0 + s up and its heat (kernels/materials/mie_grueneisen.py).

    slope: s >= 0 of the shock speed over the speed behind the shock; gamma: Grueneisen's Gamma >= 0 at the start, of
    which Gamma rho stays constant; sound_speed: c0 [m/s] > 0, which makes the bulk modulus rho c0^2; None for that of
    Young's modulus and Poisson's ratio. In tension the pressure is that of the bulk modulus; there is no limit to it.
    Raises `InputError`. (McQueen et al. in Kinslow, High-Velocity Impact Phenomena, 1970, for constants of metals.)
    """

    slope: float
    gamma: float
    sound_speed: float | None = None

    def __post_init__(self) -> None:
        validate.keep(self, "MieGrueneisen.slope", low=0.0, strict=False)
        validate.keep(self, "MieGrueneisen.gamma", low=0.0, strict=False)
        if self.sound_speed is not None:
            validate.keep(self, "MieGrueneisen.sound_speed", low=0.0)


Hardening = LinearHardening | SteinbergGuinan | JohnsonCook
HARDENINGS = (LinearHardening, SteinbergGuinan, JohnsonCook)


@dataclass(frozen=True)
class ElastoPlastic(Hookean):
    """A metal: large elastic and plastic strains, isotropic hardening, heat of plastic flow (METHOD 8).

    Multiplicative J2 plasticity: W = 3/2 mu y + U(J) with the elastic change of shape y, neo-Hookean at small strains;
    the von Mises stress of the Kirchhoff stress stays at or below the yield stress. Only explicit schemes have it.

    young [Pa], poisson, density [kg/m^3]: as in `NeoHookean`; hardening: `LinearHardening`, `SteinbergGuinan`,
    `JohnsonCook`, or a `friction_layer.Metal`, whose yield stress is taken; heat_share: share of the plastic work that
    becomes heat, 0 to 1, the rest stays in the metal as cold work; specific_heat [J/(kg K)]: None for a metal whose
    temperature does not change; initial_temperature [K]; pressure: "bulk" for U = K/2 (J - 1)^2, "barrier" for
    U = K/4 (J^2 - 1 - 2 ln J), which resists strong compression without limit, or a `MieGrueneisen`, which takes a
    specific heat and a start above 0 K.
    Raises `InputError`: a yield stress above 0.1 mu, melting at the start, any value out of its range.
    """

    hardening: Any = None
    heat_share: float = 0.9
    specific_heat: float | None = None
    initial_temperature: float = 300.0
    pressure: Any = "bulk"

    word: ClassVar[str] = "elasto-plastic"
    plastic: ClassVar[bool] = True

    def __post_init__(self) -> None:
        super().__post_init__()
        if isinstance(self.hardening, Metal):
            object.__setattr__(self, "hardening", self.hardening.hardening_law)
        if not isinstance(self.hardening, HARDENINGS):
            raise InputError(
                "ElastoPlastic.hardening",
                self.hardening,
                "give LinearHardening(yield_stress, modulus), SteinbergGuinan(...), JohnsonCook(...) or a Metal",
            )
        validate.keep(self, "ElastoPlastic.heat_share", low=0.0, high=1.0, strict=False)
        if self.specific_heat is not None:
            validate.keep(self, "ElastoPlastic.specific_heat", low=0.0)
        validate.keep(self, "ElastoPlastic.initial_temperature", low=0.0, strict=False)
        if not isinstance(self.pressure, MieGrueneisen):
            validate.choice("ElastoPlastic.pressure", self.pressure, EQUATIONS_OF_STATE)
        else:
            self._check_shock_curve()
        melting = getattr(self.hardening, "melting_temperature", None)
        if melting is not None and self.initial_temperature >= melting:
            raise InputError(
                "ElastoPlastic.initial_temperature",
                self.initial_temperature,
                f"the metal melts at {melting:g} K; start below",
            )
        if self.hardening.yield_stress > LARGEST_ELASTIC_STRAIN * self.lame_mu:
            raise InputError(
                "ElastoPlastic.hardening",
                self.hardening.yield_stress,
                f"the yield stress must be at most {LARGEST_ELASTIC_STRAIN:g} of the shear modulus"
                f" {self.lame_mu:.6g} Pa: the flow rule is for small elastic strains; look at the units",
            )

    def _check_shock_curve(self) -> None:
        """Refuse what the equation of state of Mie and Grueneisen cannot take. Raises `InputError`."""
        if self.specific_heat is None:
            raise InputError(
                "ElastoPlastic.specific_heat",
                self.specific_heat,
                "MieGrueneisen has the pressure of the heat: give the specific heat [J/(kg K)]",
            )
        if self.initial_temperature <= 0.0:
            raise InputError(
                "ElastoPlastic.initial_temperature", self.initial_temperature, "MieGrueneisen starts above 0 K"
            )
        if not self.bulk_modulus > 0.0:
            raise InputError("poisson", self.poisson, "MieGrueneisen needs a bulk modulus above 0")

    @property
    def law(self) -> str:  # type: ignore[override]
        """Name of its law in the kernels."""
        name = {LinearHardening: "linear", SteinbergGuinan: "steinberg_guinan", JohnsonCook: "johnson_cook"}
        equation = "mie_grueneisen" if isinstance(self.pressure, MieGrueneisen) else self.pressure
        return f"j2_{name[type(self.hardening)]}" + ("" if equation == "bulk" else f"_{equation}")

    @property
    def lame_lambda(self) -> float:
        """First Lame constant at small strains [Pa]; a sound speed of the shock curve sets the bulk modulus."""
        speed = getattr(self.pressure, "sound_speed", None)
        return super().lame_lambda if speed is None else self.density * speed * speed - 2.0 / 3.0 * self.lame_mu

    @property
    def barotropic(self) -> bool:  # type: ignore[override]
        """Return whether the pressure depends on the volume alone, not on heat."""
        return isinstance(self.pressure, str)

    @property
    def bulk_modulus(self) -> float:
        """Bulk modulus at small strains [Pa]."""
        return self.lame_lambda + 2.0 / 3.0 * self.lame_mu

    @property
    def parameters(self) -> tuple[float, ...]:
        """Constants for the kernels (kernels/materials/elasto_plastic.py)."""
        capacity = 0.0 if self.specific_heat is None else 1.0 / (self.density * self.specific_heat)
        own = (self.bulk_modulus, self.lame_mu, capacity, self.heat_share, self.initial_temperature)
        equation: tuple[float, ...] = ()
        if isinstance(self.pressure, MieGrueneisen):
            equation = (self.pressure.slope, self.pressure.gamma, 1.0 / (capacity * self.bulk_modulus))
        return (*own, *_constants(self.hardening), *equation)


EQUATIONS_OF_STATE = ("bulk", "barrier")


def _constants(law: Hardening) -> tuple[float, ...]:
    """Return the constants of a yield stress in the order of kernels/materials/yield_stress.py."""
    if isinstance(law, LinearHardening):
        return (law.yield_stress, law.modulus)
    if isinstance(law, SteinbergGuinan):
        largest = UNLIMITED if law.largest_yield_stress is None else law.largest_yield_stress
        shape = (law.yield_stress, law.hardening, law.hardening_exponent, largest)
        heat = (law.pressure_factor, law.thermal_softening, law.sharpness)
        return (*shape, *heat, law.melting_temperature, law.reference_temperature)
    cook = (law.yield_stress, law.hardening, law.hardening_exponent)
    return (
        *cook,
        law.rate_factor,
        law.reference_rate,
        law.softening_exponent,
        law.reference_temperature,
        law.melting_temperature,
    )
