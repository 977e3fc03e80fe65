"""What a scene may dissipate besides contact and friction: damping of all motion, viscosity in shocks."""

from __future__ import annotations

from dataclasses import dataclass

from . import validate


@dataclass(frozen=True)
class MassDamping:
    """Force -rate M v on everything with mass, to let a body settle; rate [1/s] above 0.

    Free motion decays like exp(-rate t), a mode of angular frequency omega fastest at rate = 2 omega. It does not cut
    the stable step; above rate = 2/dt velocities change sign from step to step. History: `damping_work` [J],
    dissipated so far, and `damping_impulse` [N s], the impulse of the damping force on the bodies so far.
    Raises `InputError`.
    """

    rate: float

    def __post_init__(self) -> None:
        validate.number("MassDamping.rate", self.rate, low=0.0)
