"""Cells of several elements or materials over a time step: those of every block by themselves, summed at the nodes."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from ....scene.cell_blocks import BodyBlock
from .cells import Cells
from .sparsity import Sparsity


class SeveralCells:
    """Forces and tangents of blocks of cells (block, nodes [m, corners]), in the words of `Cells`.

    sparsity: of all of them together, without what concerns single cells.
    """

    def __init__(
        self, blocks: Iterable[tuple[BodyBlock, np.ndarray]], reference: np.ndarray, unknowns: np.ndarray | None = None
    ) -> None:
        self.parts = [Cells(block, reference, cells, unknowns) for block, cells in blocks if len(cells)]
        count = len(self.parts[0].sparsity.diagonal)
        keys = [part.sparsity.rows * count + part.sparsity.columns for part in self.parts]
        every, place = np.unique(np.concatenate(keys), return_inverse=True)
        self.places = np.split(place.reshape(-1), np.cumsum([len(part) for part in keys])[:-1])
        none = np.zeros(0, dtype=np.int64)
        self.sparsity = Sparsity(
            starts=np.searchsorted(every, np.arange(count + 1) * count),
            columns=every % count,
            diagonal=np.searchsorted(every, np.arange(count) * (count + 1)),
            slots=none,
            order=none,
            colour_starts=none,
            node_starts=none,
            node_corners=none,
        )
        failing = [part for part in self.parts if not part.block.material.linear]
        self.failing = failing or self.parts

    def evaluate(self, rule: str, u0: np.ndarray, d: np.ndarray, tangents: bool = False, chi: float = 0.0) -> None:
        """Evaluate the points for a step from u0 to u0 + d, both [n, 3] [m]."""
        for part in self.parts:
            part.evaluate(rule, u0, d, tangents, chi)

    def force(self, level: float) -> np.ndarray:
        """Return nodal forces [n, 3] [N] of the last evaluation, see `Cells.force`."""
        return np.asarray(sum(part.force(level) for part in self.parts))

    def magnitude(self) -> float:
        """Return the largest force of a corner of a cell [N] in the last `force`."""
        return max(part.magnitude() for part in self.parts)

    def tangent_blocks(self, factor: float, level: float) -> np.ndarray:
        """Return blocks [b, 3, 3] of factor times d force/d u1 of the last evaluation with tangents."""
        result = np.zeros((len(self.sparsity.columns), 3, 3))
        for part, places in zip(self.parts, self.places, strict=True):
            result[places] += part.tangent_blocks(factor, level)
        return result

    def energy(self, u1: np.ndarray) -> tuple[float, float, float]:
        """Return elastic energy [J], smallest det F and hourglass energy [J] of the last evaluation, at u1.

        Beside nonlinear laws the cells of linear ones do not count for det F, as they may turn inside out.
        """
        found = [part.energy(u1) for part in self.parts]
        jacobians = [one[1] for part, one in zip(self.parts, found, strict=True) if part in self.failing]
        return sum(one[0] for one in found), min(jacobians), sum(one[2] for one in found)

    def owned(self) -> list[Any]:
        """Return its arrays."""
        return [array for part in self.parts for array in part.owned()]


def cells_of(
    blocks: list[tuple[BodyBlock, np.ndarray]], reference: np.ndarray, unknowns: np.ndarray | None = None
) -> Cells | SeveralCells:
    """Return the cells of blocks, without sums if there is one."""
    there = [(block, cells) for block, cells in blocks if len(cells)]
    if len(there) > 1:
        return SeveralCells(there, reference, unknowns)
    block, cells = there[0]
    return Cells(block, reference, cells, unknowns)
