"""Dissipation of a scene besides contact and friction: mass damping, bulk viscosity."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ..base import validate
from ..base.errors import InputError


class Damping:
    """Base class of the laws of damping proportional to the mass.

    name: name of the term, of the law in kernels/nodes/damping.py and of its columns (kernels/columns.py).
    """

    name: ClassVar[str]

    @property
    def constants(self) -> tuple[float, ...]:
        """Its constants for the kernels."""
        return tuple(vars(self).values())

    @property
    def factors(self) -> dict[str, float]:
        """Factors of its columns, the integrals over time."""
        raise NotImplementedError


@dataclass(frozen=True)
class MassDamping(Damping):
    """Force -rate M v on everything with mass, to let a body settle; rate [1/s] above 0.

    Free motion decays like exp(-rate t), a mode of angular frequency omega fastest at rate = 2 omega. It does not cut
    the stable step; above rate = 2/dt velocities change sign from step to step. History: `damping_work` [J],
    dissipated so far, and `damping_impulse` [N s], the impulse of the damping force on the bodies so far.
    Raises `InputError`.
    """

    rate: float
    name: ClassVar[str] = "mass-damping"

    def __post_init__(self) -> None:
        validate.keep(self, "MassDamping.rate", low=0.0, high=1e30)

    @property
    def factors(self) -> dict[str, float]:
        """Factors for the power rate v.Mv and the force -rate M v."""
        return {"damping_work": 2.0 * self.rate, "damping_impulse": -self.rate}


@dataclass(frozen=True)
class BulkViscosity:
    """An extra pressure in cells whose volume changes, so that shocks spread over a few cells and do not ring.

    q = rho h (linear c |e| + quadratic^2 h e^2) in compression, -rho h linear c e in expansion, with the volumetric
    strain rate e, the shortest height h and the wave speed c (Landshoff; von Neumann and Richtmyer 1950). Both numbers
    are pure and at least 0, one of them above; usual are 0.06 and 1.2. Cells with massless contact nodes have none,
    unless they are of a metal. In metals what it dissipates is heat of the cells. It
    cuts the stable step (`Result.dt_limit` holds the linear part; a run shortens its step as the quadratic one asks
    for it). History: `viscous_work` [J], dissipated so far. Raises `InputError`.
    """

    linear: float = 0.06
    quadratic: float = 1.2

    def __post_init__(self) -> None:
        validate.keep(self, "BulkViscosity.linear", low=0.0, strict=False)
        validate.keep(self, "BulkViscosity.quadratic", low=0.0, strict=False)
        if self.linear == 0.0 and self.quadratic == 0.0:
            raise InputError("BulkViscosity.linear", self.linear, "both parts are 0; give Scene(viscosity=None)")
