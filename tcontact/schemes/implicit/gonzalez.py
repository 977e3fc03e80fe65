"""Gonzalez' energy-conserving stress (2000; paper eq. 12): f* = int F_m S* : grad U,

S* = S(C_m) + [W1 - W0 - S(C_m):dC/2] 2 dC/(dC:dC)      so that S*:dC/2 = W1 - W0 for any law
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from .scheme import ImplicitScheme


@dataclass(frozen=True)
class Gonzalez(ImplicitScheme):
    """The scheme conserves energy and momenta, also in contact by a penalty; second order. Options: `ImplicitScheme`.

    Exact contact of nodes without mass, and bringing them to equilibrium (`reproject`), take energy when gaps close.
    """

    name: ClassVar[str] = "gonzalez"
    conserves: ClassVar[tuple[str, ...]] = ("energy", "linear momentum", "angular momentum")
    stress: ClassVar[str] = "gonzalez"
    conserving: ClassVar[bool] = True
