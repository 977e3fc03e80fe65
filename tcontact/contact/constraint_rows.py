"""The constraint rows of the contact nodes, which the search fills and every contact term reads."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..device import arrays
from ..kernels.lanes import HELD

if TYPE_CHECKING:
    from ..kernels.language.bundles import RowPlaces

UNKNOWN = -2.0  # law of a row before the kernels set its coefficient


class ConstraintRows:
    """Constraint rows of k contact nodes, `slots` rows each.

    values [k * slots, width]: numbers of the rows, placed as in kernels/language/bundles.RowPlaces; coefficients
    [slots]: those of friction in the rows of a node, which have no place without friction.
    """

    def __init__(self, nodes: int, places: RowPlaces, coefficients: np.ndarray) -> None:
        self.slots, self.places, self._coefficients = len(coefficients), places, coefficients
        values = np.zeros((nodes, self.slots, places.width))
        if places.coefficient >= 0:
            values[:, :, places.coefficient] = coefficients
        if places.law >= 0:
            values[:, :, places.law] = UNKNOWN
        self.values = arrays.put(values)

    def set_coefficients(self, nodes: np.ndarray, special: np.ndarray) -> None:
        """Set the constant coefficients of friction of all rows, special ones of the last rows of contact nodes [k]."""
        if self.places.law >= 0:
            return  # the kernels set them
        values = arrays.get(self.values).reshape(-1, self.slots, self.places.width)
        values[:, :, self.places.coefficient] = self._coefficients
        values[nodes, -1, self.places.coefficient] = special
        arrays.set_values(self.values, values.reshape(-1))

    def go_on(self) -> None:
        """Let the start solve keep the friction with which another run ended, where coefficients vary."""
        if self.places.law < 0:
            return
        values = arrays.get(self.values).reshape(-1, self.slots, self.places.width)
        values[:, :, self.places.law] = HELD
        arrays.set_values(self.values, values.reshape(-1))

    def pressing(self) -> np.ndarray:
        """Return the normal force lambda [k] [N] of every contact node, summed over its rows; only with friction."""
        values = arrays.get(self.values).reshape(-1, self.slots, self.places.width)
        return np.asarray(values[:, :, self.places.pressing].sum(axis=1))
