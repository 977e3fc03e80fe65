"""The constraint rows of the contact nodes, which the search fills and every contact term reads."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..device import arrays

if TYPE_CHECKING:
    from ..kernels.language.bundles import RowPlaces


class ConstraintRows:
    """Constraint rows of k contact nodes, `slots` rows each.

    values [k * slots, width]: numbers of the rows, placed as in kernels/language/bundles.RowPlaces; coefficient: that
    of friction in every row, which has no place without friction.
    """

    def __init__(self, nodes: int, slots: int, places: RowPlaces, coefficient: float) -> None:
        self.slots, self.places = slots, places
        values = np.zeros((nodes * slots, places.width))
        if places.coefficient >= 0:
            values[:, places.coefficient] = coefficient
        self.values = arrays.put(values)

    def set_coefficients(self, coefficient: float, nodes: np.ndarray, special: np.ndarray) -> None:
        """Set the coefficient of friction of all rows, and special ones of the last rows of contact nodes [k]."""
        values = arrays.get(self.values).reshape(-1, self.slots, self.places.width)
        values[:, :, self.places.coefficient] = coefficient
        values[nodes, -1, self.places.coefficient] = special
        arrays.set_values(self.values, values.reshape(-1))

    def pressing(self) -> np.ndarray:
        """Return the normal force lambda [k] [N] of every contact node, summed over its rows; only with friction."""
        values = arrays.get(self.values).reshape(-1, self.slots, self.places.width)
        return np.asarray(values[:, :, self.places.pressing].sum(axis=1))
