"""The mesh of a box as its coordinates along the axes: nodes, cells and surface follow from these.

Node (i, j, k) has the number i + (nx + 1) (j + (ny + 1) k) and the place (x_i, y_j, z_k); the hexahedra run likewise,
and each is cut alike into the cells of a kind. A layer of hexahedra along z needs two layers of nodes.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base.validate import number, vector
from . import checks
from .elements import ELEMENTS
from .geometry import Blocks, FloatArray, IntArray, Surface, chunks_of, face_keys, shortest_edge, skin_of
from .late_mesh import LateMesh
from .late_rows import LateRows, Rows
from .mesh import Mesh
from .rotation import rotation_matrix

Lines = tuple[FloatArray, FloatArray, FloatArray]
AT_ONCE = 4096  # hexahedra of the surface in a portion


class BoxMesh(LateMesh):
    """A `Mesh` of a box; lines: coordinates [nx + 1], [ny + 1], [nz + 1] [m] along x, y and z.

    Arrays of all nodes or cells are made where they are first read, and kept; `node_count`, `cell_counts`, `bounds`,
    `nodes_at` and the faces do without.
    """

    lines: Lines

    @classmethod
    def of(cls, lines: Lines, kind: str) -> BoxMesh:
        """Make the mesh of a box with the face sets of its sides."""
        counts = tuple(len(line) - 1 for line in lines)
        skin, sides = _boundary(kind, counts)
        return cls._made(lines, kind, {}, sides, {}, skin)

    @classmethod
    def _made(cls, lines: Lines, kind: str, nodes: Any, faces: Any, cells: Any, skin: Surface) -> BoxMesh:
        for array in (*lines, *nodes.values(), *faces.values(), *cells.values()):
            checks.read_only(array)
        return cls._without_arrays(kind, nodes, faces, cells, lines=lines, _surface=skin)

    @property
    def counts(self) -> tuple[int, int, int]:
        """Number of hexahedra along x, y and z."""
        return len(self.lines[0]) - 1, len(self.lines[1]) - 1, len(self.lines[2]) - 1

    @cached_property
    def nodes(self) -> FloatArray:
        """Coordinates [n, 3] [m]."""
        return checks.read_only(self._layers(0, self.counts[2] + 1))

    @cached_property
    def cells(self) -> IntArray:
        """Node ids [m, corners]."""
        return checks.read_only(_cells(self.kind, self.counts, np.arange(int(np.prod(self.counts)))))

    def has_cells_of(self, other: Mesh) -> bool:
        """Return whether another mesh has the same cells, with the same nodes."""
        if isinstance(other, BoxMesh):
            return (self.kind, self.counts) == (other.kind, other.counts)
        return super().has_cells_of(other)

    @property
    def node_count(self) -> int:
        """The number of nodes."""
        return int(np.prod([len(line) for line in self.lines]))

    @property
    def cell_count(self) -> int:
        """The number of cells."""
        return int(np.prod(self.counts)) * len(ELEMENTS[self.kind].in_box)

    @property
    def cell_counts(self) -> tuple[tuple[str, int], ...]:
        """Kinds of cells with the number of cells of each, as `blocks` has them."""
        return ((self.kind, self.cell_count),)

    @cached_property
    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Lowest and highest corner of the bounding box [m], each [3]."""
        low, high = (np.array([end(line) for line in self.lines]) for end in (np.min, np.max))
        return checks.read_only(low), checks.read_only(high)

    @cached_property
    def shortest_edge(self) -> float:
        """The length of the shortest edge of its cells [m]."""
        return min(shortest_edge(nodes, cells) for nodes, cells in self.layers())

    def nodes_at(self, numbers: IntArray) -> FloatArray:
        """Return the coordinates [.., 3] [m] of nodes of these numbers [..]. Raises `InputError` for others."""
        return self._places(checks.checked_numbers(numbers, self.node_count))

    @property
    def node_rows(self) -> Rows:
        """`nodes`, made when they are read unless they are there."""
        if "nodes" in self.__dict__:
            return self.nodes
        return LateRows(self._places, (self.node_count, 3), np.float64)

    @property
    def cell_rows(self) -> Rows:
        """`cells`, made when they are read unless they are there."""
        if "cells" in self.__dict__:
            return self.cells
        return LateRows(self._rows, (self.cell_count, ELEMENTS[self.kind].corners), np.int64)

    def _places(self, numbers: NDArray[np.integer]) -> FloatArray:
        """Return the coordinates [.., 3] [m] of nodes of these numbers [..]."""
        rest, i = np.divmod(numbers, len(self.lines[0]))
        k, j = np.divmod(rest, len(self.lines[1]))
        return np.stack([line[place] for line, place in zip(self.lines, (i, j, k), strict=True)], axis=-1)

    def _rows(self, numbers: NDArray[np.integer]) -> IntArray:
        """Return the nodes [m, corners] of cells of these numbers [m]."""
        several, corners = len(ELEMENTS[self.kind].in_box), _corners(self.kind, self.counts)
        if several == 1:
            return _cells(self.kind, self.counts, numbers)
        first = _first_nodes(self.counts, numbers // several)
        return np.asarray(first[:, None] + corners.reshape(several, -1)[numbers % several])

    def layers(self) -> Iterator[tuple[FloatArray, IntArray]]:
        """Yield for every layer of hexahedra along z the nodes [k, 3] of its two sides, and its cells by these."""
        nx, ny, nz = self.counts
        cells = _cells(self.kind, self.counts, np.arange(nx * ny))
        for layer in range(nz):
            yield self._layers(layer, layer + 2), cells

    def portions(self, name: str) -> Iterator[np.ndarray]:
        """Yield the rows of "nodes" or "cells", those of a layer of hexahedra at a time unless they are there."""
        if name in self.__dict__:
            yield self.__dict__[name]
            return
        nx, ny, nz = self.counts
        if name == "nodes":
            for layer in range(nz + 1):
                yield self._layers(layer, layer + 1)
            return
        cells = _cells(self.kind, self.counts, np.arange(nx * ny))
        for layer in range(nz):
            yield cells + layer * (nx + 1) * (ny + 1)

    @property
    def cell_portions(self) -> Iterable[tuple[str, IntArray]]:
        """Kinds of cells, each with the nodes [k, corners] of a portion of them, see `Mesh.cell_portions`."""
        return self.blocks if "cells" in self.__dict__ else _Portions(self)

    def chosen_cells(self, numbers: NDArray[np.integer]) -> Blocks:
        """Return kinds of cells with the nodes of those of these numbers, ascending, see `Mesh.chosen_cells`."""
        if "cells" in self.__dict__:
            return super().chosen_cells(numbers)
        if not len(numbers):
            return ()
        return ((self.kind, self._rows(numbers)),)

    def translated(self, offset: Any) -> Mesh:
        """Return the mesh moved by `offset` [m], three numbers."""
        moved = vector("offset", offset)
        lines = self.lines[0] + moved[0], self.lines[1] + moved[1], self.lines[2] + moved[2]
        return self._at(lines) or super().translated(offset)

    def rotated(self, rotation: Any, about: Any = (0.0, 0.0, 0.0)) -> Mesh:
        """Return the mesh turned about the point `about` [m], see `Mesh.rotated`; the identity leaves it a box."""
        vector("about", about)
        return self if np.array_equal(rotation_matrix(rotation), np.eye(3)) else super().rotated(rotation, about)

    def scaled(self, factor: float) -> Mesh:
        """Return the mesh with all coordinates multiplied by a positive factor."""
        times = number("factor", factor, low=0.0)
        return self._at((self.lines[0] * times, self.lines[1] * times, self.lines[2] * times)) or super().scaled(factor)

    def _at(self, lines: Lines) -> BoxMesh | None:
        """Return the box with other coordinates along the axes; None where rounding can have damaged its cells."""
        mesh = self._made(lines, self.kind, self.node_sets, self.face_sets, self.cell_sets, self._surface)
        return mesh if mesh.keeps_shape else None

    def _with(self, node_sets: Any, face_sets: Any, cell_sets: Any) -> Mesh:
        return self._made(self.lines, self.kind, node_sets, face_sets, cell_sets, self._surface)

    def _layers(self, first: int, last: int) -> FloatArray:
        """Return the nodes of some layers along z."""
        x, y, z = self.lines
        nodes = np.empty((last - first, len(y), len(x), 3))
        nodes[..., 0], nodes[..., 1], nodes[..., 2] = x, y[:, None], z[first:last, None, None]
        return nodes.reshape(-1, 3)

    def __reduce__(self) -> tuple[Any, ...]:
        sets = dict(self.node_sets), dict(self.face_sets), dict(self.cell_sets)
        return _again, (self.lines, self.kind, *sets)


class _Portions:
    """The cells of a box, a layer at a time, as often as they are asked for."""

    def __init__(self, mesh: BoxMesh) -> None:
        self.mesh = mesh

    def __iter__(self) -> Iterator[tuple[str, IntArray]]:
        return ((self.mesh.kind, rows) for rows in self.mesh.portions("cells"))


def _again(
    lines: Lines, kind: str, nodes: Mapping[str, Any], faces: Mapping[str, Any], cells: Mapping[str, Any]
) -> Mesh:
    return BoxMesh.of(lines, kind)._with(nodes, faces, cells)


def _cells(kind: str, counts: tuple[int, ...], hexes: NDArray[np.integer]) -> IntArray:
    """Return the cells [m, corners] of some hexahedra, hexahedron after hexahedron, each cut alike."""
    corners = _corners(kind, counts)
    cells = np.empty((len(hexes), len(corners)), dtype=np.int64)
    for part in chunks_of(len(hexes)):
        np.add(_first_nodes(counts, hexes[part])[:, None], corners, out=cells[part])
    return cells.reshape(-1, ELEMENTS[kind].corners)


def _corners(kind: str, counts: tuple[int, ...]) -> IntArray:
    """Return the nodes of the cells that a hexahedron is cut into, one cell after the other, less its first node."""
    row, layer = counts[0] + 1, (counts[0] + 1) * (counts[1] + 1)
    bottom = np.array([0, 1, row + 1, row])
    return np.asarray(np.concatenate([bottom, bottom + layer])[np.array(ELEMENTS[kind].in_box)].reshape(-1))


def _first_nodes(counts: tuple[int, ...], hexes: NDArray[np.integer]) -> IntArray:
    """Return the lowest node [m] of some hexahedra."""
    rest, i = np.divmod(hexes.astype(np.int64, copy=False), counts[0])
    k, j = np.divmod(rest, counts[1])
    return np.asarray(i + (counts[0] + 1) * (j + (counts[1] + 1) * k))


def _boundary(kind: str, counts: tuple[int, ...]) -> tuple[Surface, dict[str, IntArray]]:
    """Return the surface, and its faces by side, outward."""
    inner = np.zeros(counts[::-1], dtype=bool)  # hexahedra
    inner[1:-1, 1:-1, 1:-1] = True
    outer = np.flatnonzero(~inner.reshape(-1))
    table, shape = ELEMENTS[kind].face_table, np.array(counts) + 1
    found, sides_of = [], []
    for part in chunks_of(len(outer), AT_ONCE):
        faces = _cells(kind, counts, outer[part])[:, table].reshape(-1, table.shape[1])
        place = faces[:, :, None] // np.cumprod([1, *shape[:2]]) % shape
        at_side = np.concatenate([(place == 0).all(axis=1), (place == counts).all(axis=1)], axis=1)
        on_side = at_side.any(axis=1)
        found.append(faces[on_side])
        sides_of.append(at_side[on_side])
    faces, at_side = np.concatenate(found), np.concatenate(sides_of)
    sides = {
        letter + end: faces[at_side[:, axis + 3 * (end == "max")]]
        for axis, letter in enumerate("xyz")
        for end in ("min", "max")
    }
    return skin_of(faces, face_keys(faces, int(np.prod(shape))), faces[:0]), sides
