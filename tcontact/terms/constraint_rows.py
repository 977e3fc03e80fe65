"""The constraint rows of the contact nodes: what a search fills and every kind of contact reads."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .. import arrays

if TYPE_CHECKING:
    from ..kernels.bundles import RowPlaces


class ConstraintRows:
    """values [k * slots, width]: the numbers of the rows, as kernels/bundles.RowPlaces places them.

    coefficient: of friction, of every row; without friction it has no place.
    """

    def __init__(self, nodes: int, slots: int, places: RowPlaces, coefficient: float) -> None:
        self.slots, self.places = slots, places
        values = np.zeros((nodes * slots, places.width))
        if places.coefficient >= 0:
            values[:, places.coefficient] = coefficient
        self.values = arrays.put(values)

    def pressing(self) -> np.ndarray:
        """lambda [k] [N] of every contact node, all its rows together; only with friction."""
        values = arrays.get(self.values).reshape(-1, self.slots, self.places.width)
        return np.asarray(values[:, :, self.places.pressing].sum(axis=1))
