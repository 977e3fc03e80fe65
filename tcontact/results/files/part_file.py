"""The part of a result file that one rank writes: its cells, with all their nodes, and what is at these.

It is a result file of its own. Behind the nodes that the rank owns come copies of nodes that others own; the result
file of the run shows the owned ones alone (master_file.py), one rank after the other, and therefore the part has the
nodes of its cells also in that numbering.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...mesh.geometry import joined
from .part_places import PartPlace
from .vtkhdf import Blocks, ResultFile, store
from .vtkhdf_reader import ResultData

if TYPE_CHECKING:
    from typing_extensions import Self


@dataclass(frozen=True, eq=False)
class PartMesh:
    """The mesh of a part.

    place: of its nodes and cells in the mesh of the user; points [n, 3] [m]; blocks: nodes of its cells by kind; shown
    [n]: number of every node in the result file of the run; corner: number of the corners of cells on lower ranks.
    """

    place: PartPlace
    points: np.ndarray
    blocks: Blocks
    shown: np.ndarray
    corner: int

    @property
    def corners(self) -> int:
        """Number of corners of its cells."""
        return sum(cells.size for _, cells in self.blocks)

    @property
    def connectivity(self) -> np.ndarray:
        """Nodes of its cells, one cell after the other, in the numbering of the result file of the run."""
        return joined([self.shown[cells].reshape(-1) for _, cells in self.blocks])

    @property
    def offsets(self) -> np.ndarray:
        """Number of the corner behind each cell among those of all ranks; on the first rank with 0 before."""
        sizes = np.concatenate([np.full(len(cells), cells.shape[1], dtype=np.int64) for _, cells in self.blocks])
        ends = self.corner + np.cumsum(sizes)
        return ends if self.corner else np.concatenate([[0], ends])


class PartFile(ResultFile):
    """Writer of a part. check: checksum of the last frame; checks: of those kept by `reopen`."""

    check = 0
    checks: np.ndarray = np.zeros(0, dtype=np.uint32)

    @classmethod
    def start(
        cls, path: Path, mesh: PartMesh, attributes: Mapping[str, Any], static: Mapping[str, np.ndarray]
    ) -> PartFile:
        """Start a part at `path`; static: fields of its cells [m] that never change. Raises `OSError`."""
        found = cls.create(path, mesh.points, mesh.blocks, attributes, static)
        own = found._file["tcontact"].create_group("part")
        own.attrs["owned"] = np.int64(mesh.place.owned)
        lists = {"nodes": mesh.place.nodes, "cells": mesh.place.cells}
        for name, array in (lists | {"connectivity": mesh.connectivity, "offsets": mesh.offsets}).items():
            store(own, name, array)
        found.commit()
        return found

    @classmethod
    def _cut(cls, disk: Any, data: ResultData, frames: int, attributes: Mapping[str, Any]) -> Self:
        found = super()._cut(disk, data, frames, attributes)
        found.checks = found._file["tcontact/frames"][:frames]
        return found

    def _take(self, time: float, arrays: Mapping[str, np.ndarray]) -> None:
        super()._take(time, arrays)
        self.check = self._new[-1][1]

    @property
    def fields(self) -> dict[tuple[str, str], tuple[np.dtype[Any], tuple[int, ...]]]:
        """Kind and shape [..] of a row of every field that changes, by group and name."""
        return {key: (column.dtype, column.shape) for key, column in self._fields.items()}


def holds(data: ResultData, mesh: PartMesh) -> bool:
    """Return whether a stored part is that of this mesh."""
    place = data.place
    return (
        place is not None
        and place.owned == mesh.place.owned
        and all(np.array_equal(*pair) for pair in ((place.nodes, mesh.place.nodes), (place.cells, mesh.place.cells)))
    )
