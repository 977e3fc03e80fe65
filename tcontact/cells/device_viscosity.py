"""Viscosity of the contact cells on a GPU: the same numbers, placed for a thread per cell."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..kernels.lanes import COUNTING, WIDTH
from .cell_viscosity import CellViscosity


class DeviceCellViscosity(CellViscosity):
    """`CellViscosity` with its numbers placed as in kernels/contact/device_viscosity.py.

    The steps on the GPU launch over its cells (schemes/explicit/device_contact.py).
    """

    def _lanes(self, counts: list[int]) -> tuple[list[int], np.ndarray]:
        blocks, kinds = self.domain.blocks, self.domain.kinds
        starts, firsts, lane = [0] * len(counts), [], 0
        for kind in kinds:
            firsts.append(lane)
            for number, (block, count) in enumerate(zip(blocks, counts, strict=True)):
                if block.kind == kind:
                    starts[number] = lane
                    lane += -(-count // WIDTH) * WIDTH
        return starts, np.array(firsts, dtype=np.float64)

    def first_place(self) -> int:
        """Return the first place of a corner of contact cells in `connectivity`."""
        packs = self.internal_force.packs
        return len(packs.connectivity) - COUNTING - packs.corner_rows

    def _force_places(self, corners: np.ndarray) -> np.ndarray:
        first = 3 * (corners - corners % WIDTH) + corners % WIDTH
        return np.asarray(first[:, None] + WIDTH * np.arange(3))

    def _pass(self) -> Callable[..., None] | None:
        return None
