"""Take a part of a mesh: some of its cells, with the nodes, faces and sets that belong to them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from .elements import face_corners
from .geometry import Blocks, FloatArray, IntArray, cell_face_keys, cells_at, face_keys

Sets = Mapping[str, IntArray]


class Whole(Protocol):
    """The parts of a `Mesh` that are read of the whole one."""

    @property
    def node_count(self) -> int:
        """The number of nodes."""
        ...

    @property
    def cell_counts(self) -> tuple[tuple[str, int], ...]:
        """Kinds of cells with the number of cells of each."""
        ...

    def nodes_at(self, numbers: IntArray) -> FloatArray:
        """Return the coordinates of nodes of these numbers."""
        ...

    def chosen_cells(self, numbers: NDArray[np.integer]) -> Blocks:
        """Return the cells of these numbers, ascending, by their kinds."""
        ...


def part_of(
    mesh: Whole, node_sets: Sets, face_sets: Sets, cell_sets: Sets, chosen: NDArray[np.integer]
) -> dict[str, Any]:
    """Return the arguments of `Mesh` for the cells of these numbers, ascending; numbers close up, empty sets go."""
    cells, count = mesh.chosen_cells(chosen), mesh.node_count
    inside = np.zeros(count, dtype=bool)
    for _, rows in cells:
        inside[rows] = True
    used = np.flatnonzero(inside)
    number = np.full(count, -1, dtype=np.int64)
    number[used] = np.arange(len(used))
    sets = {
        "node_sets": {name: number[ids][number[ids] >= 0] for name, ids in node_sets.items()},
        "face_sets": {name: number[faces[_among(faces, cells, count)]] for name, faces in face_sets.items()},
        "cell_sets": {name: _places(ids, chosen) for name, ids in cell_sets.items()},
    }
    kept = {group: {name: ids for name, ids in given.items() if len(ids)} for group, given in sets.items()}
    nodes = mesh.nodes_at(used)
    if len(cells) > 1:
        return {"nodes": nodes, "cells": {kind: number[rows] for kind, rows in cells}, **kept}
    kind, rows = cells[0]
    if len(mesh.cell_counts) > 1:  # triangles of a mesh of several kinds have a corner twice
        corners = face_corners(kind)[-1]
        kept["face_sets"] = {name: faces[:, :corners] for name, faces in kept["face_sets"].items()}
    return {"nodes": nodes, "cells": number[rows], "kind": kind, **kept}


def _among(faces: IntArray, cells: Blocks, node_count: int) -> np.ndarray:
    """Return whether each of the faces [k] is one of the cells."""
    marked = np.zeros(node_count, dtype=bool)
    marked[faces] = True
    near = [cell_face_keys(rows[cells_at(marked, rows)], kind, node_count) for kind, rows in cells]
    return np.isin(face_keys(faces, node_count), np.concatenate(near))


def _places(numbers: IntArray, chosen: NDArray[np.integer]) -> IntArray:
    """Return the places in `chosen` [c], ascending, of those of the numbers [k] that stand there."""
    place = np.minimum(np.searchsorted(chosen, numbers), len(chosen) - 1)
    return place[chosen[place] == numbers]
