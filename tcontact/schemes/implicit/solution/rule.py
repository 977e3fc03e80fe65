"""The rule of an implicit scheme, as the equations of a step read it: formulas of its parts and options (METHOD 4).

    R(x1) = M (c d - b) + f* - fc* - f_ext = 0,   d = x1 - x0,   c = 2/dt^2, b = 2 v0/dt,   v1 = 2 d/dt - v0

The class has the parts of the trapezoidal family; a scheme overrides those that differ.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ....base import validate
from ....base.errors import InputError
from ....scene.contact_models import MasslessContact
from ....scene.scene import Scene


@dataclass(frozen=True)
class ImplicitRule:
    """The formula of an implicit scheme: levels and weights of its forces, and its options (`ImplicitScheme`)."""

    dt: float | None = None
    cfl: float | None = None
    rtol: float = 1e-12
    iterations: int = 15
    mass: str = "lumped"
    reproject: bool | None = None
    solver: str = "auto"
    verbose: bool = False

    name: ClassVar[str] = ""
    order: ClassVar[int] = 2
    conserves: ClassVar[tuple[str, ...]] = ("linear momentum", "angular momentum")
    implicit: ClassVar[bool] = True
    stress: ClassVar[str] = "end"  # name of a rule of implicit stresses in the kernels
    level: ClassVar[float] = 1.0  # level between x0 and x1 of an "end" rule
    conserving: ClassVar[bool] = False  # contact by difference quotients of its potential
    dissipates: ClassVar[bool] = False  # by design
    chi: ClassVar[float] = 0.0  # dissipation

    def __post_init__(self) -> None:
        if self.dt is None and self.cfl is None:
            raise InputError(
                "dt",
                None,
                f"{type(self).__name__} is not bounded by the stable step: give dt [s], or cfl as its multiple",
            )
        for field in ("dt", "cfl", "rtol"):
            if getattr(self, field) is not None:
                validate.keep(self, field, low=0.0, high=1e-2 if field == "rtol" else None)
        if self.dt is not None and self.cfl is not None:
            raise InputError("dt", self.dt, f"cfl = {self.cfl:g} is given too; give one of the two")
        validate.whole("iterations", self.iterations, 1)
        validate.choice("mass", self.mass, ("lumped", "consistent"))
        validate.choice("solver", self.solver, ("auto", "direct", "krylov"))
        validate.flag("verbose", self.verbose)
        if self.reproject is not None:
            validate.flag("reproject", self.reproject)

    def step_size(self, dt_limit: float) -> float:
        """Return the step [s] for a stable step dt_limit [s]."""
        return self.dt if self.dt is not None else float(self.cfl or 1.0) * dt_limit

    @property
    def present(self) -> float:
        """Weight of the force of this step."""
        return 1.0

    @property
    def past(self) -> float:
        """Weight of the force of the level before."""
        return 0.0

    @property
    def hourglass_level(self) -> float:
        """Level between x0 and x1 at which the hourglass stiffness is taken."""
        return 1.0 if self.stress == "end" else 0.5

    @property
    def contact_level(self) -> float:
        """Level between x0 and x1 whose normals exact contact has: that of the mean force of the step.

        The multiplier of exact contact is this mean force, and along the normals at x1 it would be of first order only
        where normals turn.
        """
        return 0.5 if self.conserving else self.present * self.level

    @property
    def balances_the_end(self) -> bool:
        """Return whether massless components are in equilibrium at x1 already."""
        return self.stress == "end" and self.level == 1.0 and self.past == 0.0

    @property
    def reprojects(self) -> bool:
        """Return whether massless components are brought to equilibrium after every step."""
        return self.reproject if self.reproject is not None else not self.balances_the_end

    def contact_loss(self, scene: Scene) -> str | None:
        """Return by what contact takes energy that the scheme would keep, in words; None where it keeps it."""
        contact = scene.contact
        if not scene.touching or not isinstance(contact, MasslessContact):
            return None
        if contact.penalty is None:
            return "exact contact of nodes without mass takes energy in every step in which a gap closes"
        return "bringing nodes without mass to equilibrium after every step takes energy" if self.reprojects else None

    @property
    def remedy(self) -> str:
        """What to try where a step has no solution."""
        more = f" or more than {self.iterations} iterations" if self.iterations < type(self).iterations else ""
        if "energy" in self.conserves:
            return f"use a smaller dt{more}; where a load or support crushes the body, lower it or refine the mesh"
        return f"use a smaller dt{more}, or a scheme that conserves energy (gonzalez takes every law)"

    def inertia(self, dt: float, v0: np.ndarray, a0: np.ndarray) -> tuple[float, np.ndarray]:
        """Return c [1/s^2] and b [n, 3] [m/s^2]."""
        return 2.0 / (dt * dt), 2.0 / dt * v0

    def motion(self, dt: float, d: np.ndarray, v0: np.ndarray, a0: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return velocity and acceleration after the step, [n, 3]."""
        return 2.0 / dt * d - v0, a0

    @property
    def blend(self) -> float:
        """Share of the force of this step in its impulse; the rest is the force of the step before."""
        return 1.0
