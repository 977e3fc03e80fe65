"""Friction between the bodies and the obstacles of a scene."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ..base import validate
from ..base.errors import InputError
from ..friction_layer.grid import THICKEST, THINNEST
from ..friction_layer.layer import METHODS
from ..friction_layer.metals import STAINLESS_304, Metal

CELL_VISCOSITY = 0.2  # beta of the contact cells with normal removal at which flutter of the mesh does not grow
FLUTTERS = 0.6  # coefficient above which flutter reduces friction in spite of it
FLUTTERS_SOFT = (0.4, 0.4), (0.48, 0.25)  # Poisson's ratios, and the coefficient from which any face flutters there


@dataclass(frozen=True)
class NoFriction:
    """No friction on one obstacle or in one pair of bodies, in place of `Scene.friction`."""

    coefficient: ClassVar[float] = 0.0


@dataclass(frozen=True)
class Coulomb:
    """Coulomb friction, |t| <= min(mu lambda, limit A), t against the slip; sticking nodes do not creep (METHOD 3).

    coefficient: mu [-], at least 0, or in its place static and kinetic [-], at least 0, and decay [s/m] > 0:
    mu = kinetic + (static - kinetic) exp(-decay |v|) with the slip speed v at the end of the step before, 0 where a
    node sticks; without a decay mu is kinetic as soon as the node slips. limit [Pa]: largest shear stress on the area A
    of a contact node, None for none. With full removal the problem has one solution for mu up to about 1 on ordinary
    meshes; a scene with more is warned about. Raises `InputError`.
    """

    coefficient: float | None = None
    static: float | None = None
    kinetic: float | None = None
    decay: float | None = None
    limit: float | None = None

    def __post_init__(self) -> None:
        falling = {name: getattr(self, name) for name in ("static", "kinetic", "decay")}
        if self.coefficient is not None or not any(value is not None for value in falling.values()):
            if self.coefficient is None:
                remedy = "give a number, or static and kinetic (and decay) in its place"
                raise InputError("Coulomb.coefficient", None, remedy)
            for name, value in falling.items():
                if value is not None:
                    remedy = "leave it out beside a coefficient, or give static and kinetic (and decay) without one"
                    raise InputError(f"Coulomb.{name}", value, remedy)
            validate.keep(self, "Coulomb.coefficient", low=0.0, strict=False)
        else:
            for name, value in falling.items():
                if value is None and name == "decay":
                    continue
                if value is None:
                    raise InputError(f"Coulomb.{name}", None, "static and kinetic come together: give a number")
                validate.keep(self, f"Coulomb.{name}", low=0.0, strict=name == "decay")
        if self.limit is not None:
            validate.keep(self, "Coulomb.limit", low=0.0)


@dataclass(frozen=True)
class FrictionTable:
    """Friction with a measured coefficient mu(slip speed, pressure), else as Coulomb's (METHOD 3).

    speeds [m/s], pressures [Pa]: at least 0 and rising, one or several; coefficients [speeds, pressures] [-]: at least
    0, flat where there is one speed or one pressure. mu is linear in both between them and constant beyond the ends; a
    node that sticks has the speed 0, a node that slides that at the end of the step before. Raises `InputError`.
    """

    speeds: Any
    pressures: Any
    coefficients: Any

    def __post_init__(self) -> None:
        axes = {}
        for name in ("speeds", "pressures"):
            field, given = f"FrictionTable.{name}", getattr(self, name)
            shape = validate.shape_of(field, given, "give a list of numbers")
            if len(shape) > 1 or shape == (0,):
                raise InputError(field, given, "give one number or a list of numbers")
            values = np.atleast_1d(validate.floats(field, given, shape))
            if values[0] < 0.0 or not (np.diff(values) > 0.0).all():
                raise InputError(field, given, "give numbers of at least 0, each larger than the one before")
            axes[name] = tuple(values.tolist())
        field, counts = "FrictionTable.coefficients", tuple(map(len, axes.values()))
        shape = validate.shape_of(field, self.coefficients, f"give numbers of shape {list(counts)}")
        flat = min(counts) == 1 and shape == (max(counts),)
        values = validate.floats(field, self.coefficients, shape if flat else counts).reshape(counts)
        if (values < 0.0).any():
            raise InputError(field, self.coefficients, "give numbers of at least 0")
        for name, axis in axes.items():
            object.__setattr__(self, name, axis)
        object.__setattr__(self, "coefficients", tuple(map(tuple, values.tolist())))


@dataclass(frozen=True)
class RegularizedCoulomb:
    """Regularised Coulomb friction, |t| = mu lambda phi(|v|/e), phi(z) = z (2 - z) below 1, 1 above.

    This is the usual baseline (Oden and Martins 1985).

    coefficient: mu [-], at least 0; slip_speed: e [m/s] > 0, where friction is fully mobilised. Sticking
    nodes creep at a part of it. Raises `InputError`.
    """

    coefficient: float
    slip_speed: float

    def __post_init__(self) -> None:
        validate.keep(self, "RegularizedCoulomb.coefficient", low=0.0, strict=False)
        validate.keep(self, "RegularizedCoulomb.slip_speed", low=0.0)


@dataclass(frozen=True)
class FrictionLayer:
    """Friction by a thermo-plastic layer under every contact node, |t| = min(stick, layer, mu P) (METHOD 5, paper 2).

    material: the metal of the layer on bodies without their own (`Body.metal`); coefficient: mu [-], the limit of dry
    friction; points, grading, thickness [m], heat_share [-], plastic_heat [-], initial_temperature [K], method and
    reload: as in `friction_layer.solve`; tolerance: bound on the relative error that a step of the layers may make in
    their stress, and in their surface temperature where it spans several mechanical steps (the history reports it,
    `layer_error`): mechanical steps are cut into as many layer steps as that takes, at most `substeps` (with full
    removal friction uses the stress of the step before: the reported error includes that lag, which only a smaller
    mechanical step lowers).
    Layers between two bodies, and on an obstacle with a metal, have two sides: conduction then divides the heat, not
    heat_share. Through the far end of a layer heat flows into the cells of an `ElastoPlastic` with a specific heat.
    History: `layer_heat`, `obstacle_heat` and `body_heat` [J], whose sum is the friction work (with plastic_heat more);
    `layer_temperature_max` [K], `layer_shear_min` [Pa], `layer_error`, `layer_substeps`.
    All are values at the time of their row; while layers take one step for several mechanical ones (`layer_substeps`
    below 1) temperature and stress are those after the last of these. Raises `InputError`.
    """

    material: Metal = STAINLESS_304
    coefficient: float = 0.3
    points: int = 40
    grading: float = 30.0
    thickness: float = 10e-6
    heat_share: float = 0.5
    plastic_heat: float = 0.0
    initial_temperature: float = 300.0
    method: str = "bracketed-newton"
    reload: bool = True
    tolerance: float = 1e-2
    substeps: int = 64

    def __post_init__(self) -> None:
        if not isinstance(self.material, Metal):
            raise InputError(
                "FrictionLayer.material", self.material, "give a friction_layer.Metal, such as STAINLESS_304"
            )
        name = "FrictionLayer."
        validate.keep(self, name + "coefficient", low=0.0, strict=False)
        validate.whole(name + "points", self.points, 3, 10**5)
        validate.keep(self, name + "grading", low=1.0, strict=False)
        validate.keep(self, name + "thickness", low=THINNEST, high=THICKEST)
        validate.keep(self, name + "heat_share", low=0.0, high=1.0, strict=False)
        validate.keep(self, name + "plastic_heat", low=0.0, high=1.0, strict=False)
        validate.keep(self, name + "initial_temperature", low=0.0, strict=False)
        validate.choice(name + "method", self.method, METHODS)
        if not isinstance(self.reload, bool):
            raise InputError(name + "reload", self.reload, "give True or False")
        validate.keep(self, name + "tolerance", low=0.0)
        validate.whole(name + "substeps", self.substeps, 1, 10**6)
        if self.initial_temperature >= self.material.melting_temperature:
            raise InputError(
                name + "initial_temperature",
                self.initial_temperature,
                f"the metal melts at {self.material.melting_temperature:g} K; start below",
            )


FrictionModel = Coulomb | FrictionTable | RegularizedCoulomb | FrictionLayer | NoFriction


def coefficient_of(model: FrictionModel | None) -> float:
    """Return the largest coefficient of friction of a model, 0 without one."""
    if isinstance(model, FrictionTable):
        return float(np.max(model.coefficients))
    if isinstance(model, Coulomb) and model.coefficient is None:
        return float(max(model.static, model.kinetic))  # type: ignore[type-var, arg-type]
    return 0.0 if model is None else float(model.coefficient)  # type: ignore[arg-type]


def law_of(model: FrictionModel | None) -> str:
    """Return the name of its law in the kernels; "" without friction."""
    if model is None:
        return ""
    return "regularized" if isinstance(model, RegularizedCoulomb) else "coulomb"
