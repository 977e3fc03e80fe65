"""What the energy of an own law is given, for annotations of that function (`own_laws.py`)."""

from __future__ import annotations

from typing import Protocol

import numpy as np


class Strain(Protocol):
    """The deformation at a point, of which the energy of `register_law` is a formula; tensors are 3x3 arrays.

        def energy(strain: tc.Strain, mu: float, bulk: float) -> float:
            return 0.5 * mu * (strain.I1_bar - 3.0) + 0.5 * bulk * (strain.J - 1.0) ** 2

    The types are those of the formula with numbers, for programs that check them; the class itself makes nothing.
    Functions of NumPy such as np.log return Any for these programs: so does then the energy. Without deformation
    F = C = I, J = 1 and all invariants are 3.
    """

    @property
    def H(self) -> np.ndarray:
        """Displacement gradient [3, 3]."""

    @property
    def F(self) -> np.ndarray:
        """Deformation gradient I + H [3, 3]."""

    @property
    def C(self) -> np.ndarray:
        """Right Cauchy-Green tensor F^t F [3, 3]."""

    @property
    def E(self) -> np.ndarray:
        """Green's strain (C - I)/2 [3, 3]."""

    @property
    def J(self) -> float:
        """Volume ratio det F."""

    @property
    def I1(self) -> float:
        """First invariant tr C."""

    @property
    def I2(self) -> float:
        """Second invariant ((tr C)^2 - tr C^2)/2."""

    @property
    def I1_bar(self) -> float:
        """First invariant J^(-2/3) I1 of the deformation without its change of volume."""

    @property
    def I2_bar(self) -> float:
        """Second invariant J^(-4/3) I2 of the deformation without its change of volume."""
