"""Materials: an elastic law with its constants and a density.

Each law names its stored energy W per reference volume [J/m^3]; the kernels take its Lame constants at run time.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from . import validate


@dataclass(frozen=True)
class Material:
    """Isotropic elastic material.

    young: Young's modulus [Pa] > 0; poisson: Poisson's ratio, -1 < poisson < 0.5; density [kg/m^3] > 0.
    Raises `InputError` for any other value.
    """

    young: float
    poisson: float
    density: float

    law: ClassVar[str]
    linear: ClassVar[bool] = False

    def __post_init__(self) -> None:
        validate.number("young", self.young, low=0.0)
        validate.number("poisson", self.poisson, low=-1.0, high=0.5)
        validate.number("density", self.density, low=0.0)

    @property
    def lame_lambda(self) -> float:
        """First Lame constant [Pa]."""
        return self.young * self.poisson / ((1.0 + self.poisson) * (1.0 - 2.0 * self.poisson))

    @property
    def lame_mu(self) -> float:
        """Shear modulus [Pa]."""
        return self.young / (2.0 * (1.0 + self.poisson))

    @property
    def wave_speed(self) -> float:
        """Dilatational wave speed sqrt((lambda + 2 mu)/density) [m/s]."""
        return ((self.lame_lambda + 2.0 * self.lame_mu) / self.density) ** 0.5


@dataclass(frozen=True)
class LinearElastic(Material):
    """Small strains: W = mu eps:eps + lambda/2 (tr eps)^2. A rotation strains it: for small rotations only."""

    law: ClassVar[str] = "linear_elastic"
    linear: ClassVar[bool] = True


@dataclass(frozen=True)
class StVenantKirchhoff(Material):
    """W = mu E:E + lambda/2 (tr E)^2 with Green's strain E; loses ellipticity in strong compression (J < 1/sqrt 3)."""

    law: ClassVar[str] = "st_venant_kirchhoff"


@dataclass(frozen=True)
class NeoHookean(Material):
    """W = mu/2 (I1 - 3) - mu ln J + lambda/2 (J - 1)^2: the default for finite deformations."""

    law: ClassVar[str] = "neo_hookean"
