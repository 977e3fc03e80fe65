"""Discrete gradient for each invariant: S*:dC/2 = W1 - W0 without a quotient 0/0 (METHOD 4).

W = a (I1 - 3) + b (I2 - 3) + h(J):   S* = 2a I + 2b (tr(C_m) I - C_m) + 2 [h(J1) - h(J0)]/(J1 - J0) G,
G:dC = J1 - J0,   f* = int F_m S* : grad U
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from .scheme import ImplicitScheme


@dataclass(frozen=True)
class DiscreteGradient(ImplicitScheme):
    """The scheme conserves energy and momenta, also in contact by a penalty; second order. Options: `ImplicitScheme`.

    Exact contact of nodes without mass, and bringing them to equilibrium (`reproject`), take energy when gaps close.
    """

    name: ClassVar[str] = "discrete-gradient"
    conserves: ClassVar[tuple[str, ...]] = ("energy", "linear momentum", "angular momentum")
    stress: ClassVar[str] = "discrete"
    conserving: ClassVar[bool] = True
