"""Materials: an elastic law with its constants and a density.

Each law names its stored energy W per reference volume [J/m^3]; the kernels take its parameters at run time. `LAWS` at
the end is the list of laws: cases and the benchmark choose by its words, scene files by the names of its classes.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..base import validate
from ..base.errors import InputError

PAIRS = 3  # maximum number of pairs (mu_p, alpha_p) of an Ogden law
LARGEST_EXPONENT = 20.0  # largest exponent of an Ogden law: powers of a stretch of 10 then have finite squares


class Material:
    """Base class of isotropic elastic materials.

    young [Pa], poisson: at small strains; density [kg/m^3]; law: its name in the kernels; word: its name in cases and
    in the benchmark; linear: whether the stress is linear in the displacement; volumetric: whether parameters[0]/2
    times the square of the volume change is a part of W, which formulation="mean-dilatation" takes per cell; plastic:
    whether its points flow plastically (metals.py); barotropic: whether its pressure depends on the volume alone.
    """

    law: ClassVar[str]
    word: ClassVar[str]
    linear: ClassVar[bool] = False
    volumetric: ClassVar[bool] = True
    plastic: ClassVar[bool] = False
    barotropic: bool = True

    young: float
    poisson: float
    density: float

    @property
    def lame_lambda(self) -> float:
        """First Lame constant at small strains [Pa]."""
        raise NotImplementedError

    @property
    def lame_mu(self) -> float:
        """Shear modulus at small strains [Pa]."""
        raise NotImplementedError

    @property
    def parameters(self) -> tuple[float, ...]:
        """Constants for the kernels (kernels/materials/) [Pa]."""
        return (self.lame_lambda, self.lame_mu)

    @property
    def moduli(self) -> tuple[float, ...]:
        """Return `parameters` under their old name, which goes with the next version."""
        warnings.warn("Material.moduli is Material.parameters now", DeprecationWarning, stacklevel=2)
        return self.parameters

    @classmethod
    def of(cls, young: float, poisson: float, density: float) -> Material:
        """Return the material with these constants at small strains. Raises `InputError`."""
        raise NotImplementedError

    @property
    def wave_modulus(self) -> float:
        """Modulus of plane waves at small strains [Pa], which scales the hourglass stiffness: lambda + 2 mu."""
        return self.lame_lambda + 2.0 * self.lame_mu

    @property
    def wave_speed(self) -> float:
        """Speed sqrt(wave_modulus/density) of the fastest plane wave at small strains [m/s]."""
        return float((self.wave_modulus / self.density) ** 0.5)


@dataclass(frozen=True)
class Hookean(Material):
    """A law with two constants.

    young: Young's modulus [Pa] > 0; poisson: Poisson's ratio, -1 < poisson < 0.5; density [kg/m^3] > 0.
    Raises `InputError` for any other value.
    """

    young: float
    poisson: float
    density: float

    def __post_init__(self) -> None:
        validate.keep(self, "young", low=0.0)
        validate.keep(self, "poisson", low=-1.0, high=0.5)
        validate.keep(self, "density", low=0.0)

    @classmethod
    def of(cls, young: float, poisson: float, density: float) -> Hookean:
        """Return the material with these constants. Raises `InputError`."""
        return cls(young, poisson, density)

    @property
    def lame_lambda(self) -> float:
        """First Lame constant [Pa]."""
        return self.young * self.poisson / ((1.0 + self.poisson) * (1.0 - 2.0 * self.poisson))

    @property
    def lame_mu(self) -> float:
        """Shear modulus [Pa]."""
        return self.young / (2.0 * (1.0 + self.poisson))


@dataclass(frozen=True)
class LinearElastic(Hookean):
    """Linear elasticity at small strains: W = mu eps:eps + lambda/2 (tr eps)^2. For small rotations only.

    young: Young's modulus [Pa] > 0; poisson: Poisson's ratio, -1 < poisson < 0.5; density [kg/m^3] > 0.
    Raises `InputError` for any other value.
    """

    law: ClassVar[str] = "linear_elastic"
    word: ClassVar[str] = "linear"
    linear: ClassVar[bool] = True


@dataclass(frozen=True)
class StVenantKirchhoff(Hookean):
    """St Venant-Kirchhoff law W = mu E:E + lambda/2 (tr E)^2, Green's strain E; not elliptic for J < 1/sqrt 3.

    It softens in compression, so it suits large rotations with small strains. young: Young's modulus [Pa] > 0; poisson:
    Poisson's ratio, -1 < poisson < 0.5; density [kg/m^3] > 0. Raises `InputError` for any other value.
    """

    law: ClassVar[str] = "st_venant_kirchhoff"
    word: ClassVar[str] = "st-venant-kirchhoff"
    volumetric: ClassVar[bool] = False


@dataclass(frozen=True)
class NeoHookean(Hookean):
    """Neo-Hookean law W = mu/2 (I1 - 3) - mu ln J + lambda/2 (J - 1)^2: the default for finite deformations.

    young: Young's modulus [Pa] > 0 and poisson: Poisson's ratio, -1 < poisson < 0.5, both at small strains; density
    [kg/m^3] > 0. Raises `InputError` for any other value.

    With poisson < 0 lambda is negative and the energy has no least value: a body carries a limited tension, under equal
    stretches along all axes 0.11 of young at a stretch of 1.25 for poisson -0.1, 0.029 at 1.09 for -0.3, 0.011 at 1.043
    for -0.5 and 0.004 at 1.020 for -0.7, and expands without end beyond (tension_limit.py). In compression it is sound;
    where such a body is pulled take `StVenantKirchhoff`.
    """

    law: ClassVar[str] = "neo_hookean"
    word: ClassVar[str] = "neo-hookean"


class LameMaterial(Material):
    """Base class of materials whose Lame constants at small strains give their other elastic constants."""

    @property
    def young(self) -> float:  # type: ignore[override]
        """Young's modulus at small strains [Pa]."""
        lam, mu = self.lame_lambda, self.lame_mu
        return mu * (3.0 * lam + 2.0 * mu) / (lam + mu)

    @property
    def poisson(self) -> float:  # type: ignore[override]
        """Poisson's ratio at small strains."""
        return 0.5 * self.lame_lambda / (self.lame_lambda + self.lame_mu)


@dataclass(frozen=True)
class MooneyRivlin(LameMaterial):
    """W = c1 (I1 - 3) + c2 (I2 - 3) - 2 (c1 + 2 c2) ln J + bulk/2 (J - 1)^2, I1 = tr C, I2 = ((tr C)^2 - tr C^2)/2.

    For rubber; free of stress at F = I, neo-Hookean with mu = 2 c1, lambda = bulk for c2 = 0. At small strains
    mu = 2 (c1 + c2) and lambda = bulk + 4 c2. c1 [Pa] > 0; c2 [Pa] >= 0; bulk [Pa] > 0; density [kg/m^3] > 0.
    Raises `InputError` for any other value. (Ciarlet and Geymonat, C. R. Acad. Sci. Paris II 295, 423, 1982.)
    """

    c1: float
    c2: float
    bulk: float
    density: float

    law: ClassVar[str] = "mooney_rivlin"
    word: ClassVar[str] = "mooney-rivlin"

    def __post_init__(self) -> None:
        validate.keep(self, "c1", low=0.0)
        validate.keep(self, "c2", low=0.0, strict=False)
        validate.keep(self, "bulk", low=0.0)
        validate.keep(self, "density", low=0.0)

    @classmethod
    def of(cls, young: float, poisson: float, density: float, second: float = 0.2) -> MooneyRivlin:
        """Return the material with these constants at small strains and c2 = second (c1 + c2), 0 <= second < 1.

        Raises `InputError`; bulk > 0 requires lambda > 2 second mu, that is poisson > second/(1 + 2 second).
        """
        small = Hookean(young, poisson, density)
        second = validate.number("second", second, low=0.0, strict=False)
        second = validate.number("second", second, high=1.0)
        least = second / (1.0 + 2.0 * second)
        if second and not poisson > least:
            remedy = (
                f"c2 = {second:g} (c1 + c2) needs more than {least:.4g}; or give a smaller `second`, or use NeoHookean"
            )
            raise InputError("poisson", poisson, remedy)
        half = 0.5 * small.lame_mu
        return cls((1.0 - second) * half, second * half, small.lame_lambda - 4.0 * second * half, density)

    @property
    def lame_lambda(self) -> float:
        """First Lame constant at small strains, bulk + 4 c2 [Pa]."""
        return self.bulk + 4.0 * self.c2

    @property
    def lame_mu(self) -> float:
        """Shear modulus at small strains, 2 (c1 + c2) [Pa]."""
        return 2.0 * (self.c1 + self.c2)

    @property
    def parameters(self) -> tuple[float, ...]:
        """Constants bulk, 2 (c1 + 2 c2), 4 c2 [Pa]: W is neo-Hookean in the first two, plus a quadratic in E."""
        return (self.bulk, 2.0 * (self.c1 + 2.0 * self.c2), 4.0 * self.c2)


@dataclass(frozen=True)
class Ogden(Material):
    """W = sum over p, i of mu_p/alpha_p (l_i^alpha_p - 1) - sum of mu_p ln J + lambda/2 (J - 1)^2 with stretches l_i.

    For rubber at large stretches; free of stress at F = I, neo-Hookean for the one pair (mu, 2). At small strains its
    shear modulus is sum(mu_p alpha_p)/2 and lambda = 2 shear poisson/(1 - 2 poisson). mu [Pa], alpha: one to three
    pairs with mu_p alpha_p > 0 and |alpha_p| <= 20; 0 <= poisson < 0.5; density [kg/m^3] > 0.
    Raises `InputError` for any other value. (Ogden, Proc. R. Soc. Lond. A 328, 567, 1972.)
    """

    mu: tuple[float, ...]
    alpha: tuple[float, ...]
    poisson: float
    density: float

    law: ClassVar[str] = "ogden"
    word: ClassVar[str] = "ogden"

    def __post_init__(self) -> None:
        for name in ("mu", "alpha"):
            given = getattr(self, name)
            count = validate.shape_of(name, given, remedy := "give a list of one to three numbers")
            if len(count) != 1 or not 1 <= count[0] <= PAIRS:
                raise InputError(name, given, remedy)
            values = validate.floats(name, given, count).tolist()
            if any(isinstance(one, (bool, np.bool_)) for one in given):  # beside numbers NumPy takes them for 0 and 1
                raise InputError(name, given, f"{remedy}, without truth values")
            object.__setattr__(self, name, tuple(values))
        if len(self.mu) != len(self.alpha):
            raise InputError("alpha", self.alpha, f"give as many as there are in mu, {len(self.mu)}")
        for number, (mu, alpha) in enumerate(zip(self.mu, self.alpha, strict=True)):
            if 0.0 in (mu, alpha) or (mu > 0.0) != (alpha > 0.0):
                raise InputError(
                    f"alpha[{number}]", alpha, f"must have the sign of mu[{number}] = {mu:g}, neither of them 0"
                )
            low, high = -LARGEST_EXPONENT, LARGEST_EXPONENT
            validate.number(f"alpha[{number}]", alpha, low=low, high=high, strict=False)
        validate.keep(self, "poisson", low=0.0, strict=False)
        validate.keep(self, "poisson", high=0.5)
        validate.keep(self, "density", low=0.0)
        if not (self.lame_mu > 0.0 and np.isfinite(self.parameters).all()):
            given = f"mu/alpha and the shear modulus sum(mu alpha)/2 = {self.lame_mu:g}"
            raise InputError("mu", self.mu, f"{given} must be finite and above 0; give mu in Pa and other exponents")

    @classmethod
    def of(cls, young: float, poisson: float, density: float) -> Ogden:
        """Return the material with these constants at small strains and the three pairs of Ogden's rubber.

        Their exponents are 1.3, 5 and -2, their shares of the shear modulus those of Ogden (1972). Raises `InputError`.
        """
        shear = Hookean(young, poisson, density).lame_mu
        alpha, shares = (1.3, 5.0, -2.0), (6.3, 0.012, 0.1)
        total = sum(abs(exponent) * share for exponent, share in zip(alpha, shares, strict=True))
        mu = tuple(
            (1.0 if a > 0.0 else -1.0) * 2.0 * shear * share / total for a, share in zip(alpha, shares, strict=True)
        )
        return cls(mu, alpha, poisson, density)

    @property
    def lame_lambda(self) -> float:
        """First Lame constant [Pa]."""
        return 2.0 * self.lame_mu * self.poisson / (1.0 - 2.0 * self.poisson)

    @property
    def lame_mu(self) -> float:
        """Shear modulus at small strains [Pa]."""
        return 0.5 * sum(mu * alpha for mu, alpha in zip(self.mu, self.alpha, strict=True))

    @property
    def young(self) -> float:  # type: ignore[override]
        """Young's modulus at small strains [Pa]."""
        return 2.0 * self.lame_mu * (1.0 + self.poisson)

    @property
    def parameters(self) -> tuple[float, ...]:
        """Constants lambda and shear modulus [Pa], then mu_p/alpha_p [Pa] and alpha_p of each pair, else 0 and 1."""
        pairs = [(mu / alpha, alpha) for mu, alpha in zip(self.mu, self.alpha, strict=True)]
        pairs += [(0.0, 1.0)] * (PAIRS - len(pairs))
        return (self.lame_lambda, self.lame_mu, *[value for pair in pairs for value in pair])


# the laws by their words for cases and the benchmark; scene files know them by the names of their classes
LAWS: dict[str, type[Material]] = {
    kind.word: kind for kind in (NeoHookean, MooneyRivlin, LinearElastic, StVenantKirchhoff, Ogden)
}
