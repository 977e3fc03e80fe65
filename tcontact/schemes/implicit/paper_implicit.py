"""The paper's scheme of section 4.4: trapezoidal rule for the inertia, backward Euler for stiffness and contact.

2/dt^2 M (x1 - x0 - dt v0) + f(x1) - fc(x1) = f_ext       first order, dissipates: 35 % of a cube's impact energy
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from .scheme import ImplicitScheme


@dataclass(frozen=True)
class PaperImplicit(ImplicitScheme):
    """The scheme f* = f(x1), fc* = fc(x1) of Fig. 4 of Le Tallec, Dambakizi, Hauret 2007. Options: `ImplicitScheme`."""

    name: ClassVar[str] = "paper-implicit"
    dissipates: ClassVar[bool] = True
    order: ClassVar[int] = 1
    conserves: ClassVar[tuple[str, ...]] = ("linear momentum",)
