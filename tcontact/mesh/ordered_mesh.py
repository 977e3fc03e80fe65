"""A mesh whose nodes and cells stand in another order, in arrays that are kept anyway.

Node i and cell e of these arrays are node a_i and cell b_e of the mesh, so that

    nodes[a_i] = places[i],    cells[b_e] = a[rows[e]]
"""

from __future__ import annotations

from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import checks
from .geometry import FloatArray, IntArray, chunks_of
from .late_mesh import LateMesh
from .mesh import Mesh


class Ordered(NamedTuple):
    """Nodes and cells in another order: places [n, 3] [m], rows [m, corners], and a [n], b [m] as above."""

    places: FloatArray
    rows: NDArray[np.integer]
    node_order: NDArray[np.integer]
    cell_order: NDArray[np.integer]


class Facts(NamedTuple):
    """What a mesh has beside its nodes and cells: kind, `Mesh.cell_counts` and sets, all of them known to be valid."""

    kind: str
    cell_counts: tuple[tuple[str, int], ...]
    node_sets: dict[str, IntArray]
    face_sets: dict[str, IntArray]
    cell_sets: dict[str, IntArray]

    @classmethod
    def of(cls, mesh: Mesh) -> Facts:
        """Return those of a mesh."""
        return cls(mesh.kind, mesh.cell_counts, *map(dict, (mesh.node_sets, mesh.face_sets, mesh.cell_sets)))


class OrderedMesh(LateMesh):
    """A `Mesh` of nodes and cells that are kept in another order; kept: these."""

    kept: Ordered
    _counts: tuple[tuple[str, int], ...]

    @classmethod
    def of(cls, kept: Ordered, facts: Facts) -> OrderedMesh:
        """Make the mesh of arrays in another order, and of the rest of it."""
        kind, counts, *sets = facts
        return cls._without_arrays(kind, *sets, kept=kept, _counts=counts)

    @cached_property
    def nodes(self) -> FloatArray:
        """Coordinates [n, 3] [m]."""
        result = np.empty_like(self.kept.places)
        result[self.kept.node_order] = self.kept.places
        return np.asarray(checks.read_only(result))

    @cached_property
    def cells(self) -> IntArray:
        """Node ids [m, corners]."""
        rows = self.kept.rows
        result = np.empty(rows.shape, dtype=np.int64)
        for part in chunks_of(len(rows)):
            result[self.kept.cell_order[part]] = self.kept.node_order[rows[part]]
        return np.asarray(checks.read_only(result))

    @property
    def cell_counts(self) -> tuple[tuple[str, int], ...]:
        """Kinds of cells with the number of cells of each, as `blocks` has them."""
        return self._counts

    @property
    def node_count(self) -> int:
        """The number of nodes."""
        return len(self.kept.places)

    @property
    def cell_count(self) -> int:
        """The number of cells."""
        return len(self.kept.rows)

    def __reduce__(self) -> tuple[Any, ...]:
        return OrderedMesh.of, (self.kept, Facts.of(self))
