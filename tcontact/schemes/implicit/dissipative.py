"""Discrete gradient with dissipation that keeps the momenta (Armero and Romero 2001): S* + chi/2 (S1 - S0).

The energy falls by chi/4 int (S1 - S0):dC each step, first order in time where chi > 0
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ...base import validate
from .scheme import ImplicitScheme


@dataclass(frozen=True)
class Dissipative(ImplicitScheme):
    """The scheme dissipates by chi >= 0 (0: none) in the cells, not in contact. Other options: `ImplicitScheme`.

    One-point hexahedra lose angular momentum too, by an error of first order in the time step: their hourglass forces,
    taken beyond the middle of the step, have a moment.
    """

    chi: float = 0.1  # type: ignore[misc]

    name: ClassVar[str] = "dissipative"
    dissipates: ClassVar[bool] = True
    order: ClassVar[int] = 1
    stress: ClassVar[str] = "dissipative"
    conserving: ClassVar[bool] = True

    def __post_init__(self) -> None:
        super().__post_init__()
        validate.keep(self, "chi", low=0.0, strict=False)

    @property
    def hourglass_level(self) -> float:
        """Level of the hourglass stiffness between its levels: it dissipates with the stress."""
        return 0.5 * (1.0 + self.chi)
