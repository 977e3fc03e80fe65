"""Transport averaging (Simo and Tarnow 1992, Crisfield 1997; paper 3.1): f* = int F_m S* : grad U, F_m = (F0 + F1)/2.

S* = S(C_m), C_m = (C0 + C1)/2,   or   S* = (S(C0) + S(C1))/2
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from .scheme import ImplicitScheme


@dataclass(frozen=True)
class TransportAveraging(ImplicitScheme):
    """The scheme F_m S(C_m) with conserving contact; energy exact for StVenantKirchhoff. Options: `ImplicitScheme`."""

    name: ClassVar[str] = "transport-averaging"
    stress: ClassVar[str] = "transport"
    conserving: ClassVar[bool] = True


@dataclass(frozen=True)
class StressAveraging(ImplicitScheme):
    """The scheme F_m (S(C0) + S(C1))/2 with conserving contact. Options: `ImplicitScheme`."""

    name: ClassVar[str] = "stress-averaging"
    stress: ClassVar[str] = "mean"
    conserving: ClassVar[bool] = True
