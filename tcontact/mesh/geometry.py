"""Geometry and topology of cells: Jacobians, heights, volumes, boundary. The kinds of cells are in elements.py."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import reduce
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from numpy.typing import NDArray

from .elements import BY_CORNERS, ELEMENTS, FloatArray, face_corners
from .late_rows import Rows

IntArray = npt.NDArray[np.int64]
KeyArray = npt.NDArray[np.uint64]
Blocks = Sequence[tuple[str, IntArray]]  # kind of cells and their nodes [m, corners], as `Mesh.blocks`

_CHUNK = 1024  # cells at a time: temporaries stay in cache and small beside the mesh


def chunks_of(count: int, size: int = _CHUNK) -> Iterator[slice]:
    """Yield the slices of so many rows in portions of at most `size`."""
    return (slice(start, min(start + size, count)) for start in range(0, count, size))


def joined(parts: Sequence[NDArray[Any]]) -> NDArray[Any]:
    """Return arrays [n_i, ..] one after the other in one; no copy of a single one."""
    return parts[0] if len(parts) == 1 else np.concatenate(parts)


def cells_at(marked: NDArray[np.bool_], cells: Rows) -> IntArray:
    """Return the numbers of the cells [m, corners], ascending, that have a marked node; marked [n]."""
    parts = (part.start + np.flatnonzero(marked.take(cells[part]).any(axis=1)) for part in chunks_of(len(cells)))
    return np.concatenate([np.zeros(0, dtype=np.int64), *parts])


def differences(nodes: Rows, cells: Rows, operator: FloatArray) -> Iterator[tuple[slice, FloatArray]]:
    """Yield (cells, vectors [k, 3, c]) for chunks of c cells: sums over the corners with weights operator [k, corners].

    The weights of a row add up to 0: the vectors are exact also far from the origin.
    """
    for part in chunks_of(len(cells)):
        x = nodes.take(cells[part].T, axis=0).transpose(0, 2, 1)
        yield part, (operator @ (x - x[0]).reshape(len(x), -1)).reshape(len(operator), 3, -1)


def spanned_heights(kind: str, nodes: Rows, cells: Rows, span: int = 0) -> FloatArray:
    """Return the shortest height [m] of the parallelepiped (`Element.spans`) of each cell [m, corners]."""
    spans = ELEMENTS[kind].spans[span]
    operator, heights = np.zeros((3, cells.shape[1])), np.empty(len(cells))
    for row, (there, here) in zip(operator, spans, strict=True):
        row[list(there)], row[list(here)] = 1.0 / len(there), -1.0 / len(here)
    for part, axes in differences(nodes, cells, operator):
        areas = [_cross(axes[i], axes[(i + 1) % 3]) for i in range(3)]
        volume = np.abs((axes[2] * areas[0]).sum(axis=0))
        heights[part] = volume / np.sqrt(np.max([(area * area).sum(axis=0) for area in areas], axis=0))
    return heights


def shortest_heights(kind: str, nodes: FloatArray, cells: NDArray[np.integer]) -> FloatArray:
    """Return the shortest of all heights [m] of each cell [m, corners]."""
    spans = range(len(ELEMENTS[kind].spans))
    return reduce(np.minimum, (spanned_heights(kind, nodes, cells, span) for span in spans))


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the products a x b of vectors [3, ...]."""
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def _rows_of_jacobians(nodes: Rows, cells: Rows, gradient: FloatArray) -> Iterator[tuple[slice, FloatArray]]:
    """Yield (cells, J^T [3, 3, p, c]) of J = dx/dxi: its columns dx/dxi_k first, then their components."""
    points, corners, _ = gradient.shape
    operator = np.ascontiguousarray(gradient.transpose(2, 0, 1)).reshape(3 * points, corners)
    for part, vectors in differences(nodes, cells, operator):
        yield part, vectors.reshape(3, points, 3, -1).transpose(0, 2, 1, 3)


def determinants(nodes: Rows, cells: Rows, gradient: FloatArray) -> Iterator[tuple[slice, FloatArray]]:
    """Yield (cells, det dx/dxi [p, c] [m^3]) for chunks of c cells at p points, see `jacobians`."""
    for part, (a, b, c) in _rows_of_jacobians(nodes, cells, gradient):
        yield part, (a * _cross(b, c)).sum(axis=0)


def jacobians(
    nodes: FloatArray, cells: IntArray, gradient: FloatArray
) -> Iterator[tuple[slice, FloatArray, FloatArray]]:
    """Yield (cells, det [p, c], edges [p, c]) for chunks of c cells at p points with shape gradients [p, corners, 3].

    det is the determinant of J = dx/dxi [m^3], edges the product of the lengths of its three rows: |det| <= edges, and
    det / edges judges the shape of a cell whatever its size and aspect ratio.
    """
    for part, (a, b, c) in _rows_of_jacobians(nodes, cells, gradient):
        with np.errstate(over="ignore", invalid="ignore"):
            lengths = [np.sqrt((row * row).sum(axis=0)) for row in (a, b, c)]
            det, edges = (a * _cross(b, c)).sum(axis=0), lengths[0] * lengths[1] * lengths[2]
        yield part, det, edges


def cell_volumes(nodes: FloatArray, cells: IntArray, kind: str) -> FloatArray:
    """Return the volume [m^3] of each cell [m], exact: every kind integrates its Jacobian determinant exactly."""
    volumes = np.empty(len(cells))
    _values, gradients, weights = ELEMENTS[kind].rule
    for part, det in determinants(nodes, cells, gradients):
        volumes[part] = (weights[:, None] * det).sum(axis=0)
    return volumes


class Surface(NamedTuple):
    """The faces with one cell, with keys to find them."""

    faces: IntArray  # [k, 4|3] node ids, outward, in the order of the cells; see `Mesh.boundary_faces`
    keys: KeyArray  # [k] sorted keys of those faces
    order: IntArray  # [k] face of each sorted key
    crowded: IntArray  # [j, 4|3] faces with more than two cells, each once; empty in a sound mesh

    def find(self, faces: IntArray, node_count: int) -> IntArray:
        """Return the index in `faces` of each given face in any corner order; -1 for a face not in the surface."""
        wanted = face_keys(faces, node_count)
        place = np.minimum(np.searchsorted(self.keys, wanted), len(self.keys) - 1)
        return np.where(self.keys[place] == wanted, self.order[place], -1)


def surface(blocks: Blocks, node_count: int) -> Surface:
    """Find the faces with one cell."""
    tables = [ELEMENTS[kind].face_table for kind, _ in blocks]
    width = max(table.shape[1] for table in tables)
    counts = [len(cells) * len(table) for (_, cells), table in zip(blocks, tables, strict=True)]
    first = np.concatenate([[0], np.cumsum(counts)])

    def rows(numbers: IntArray) -> IntArray:
        """Return faces [k, width] by their numbers, those of the first cell first."""
        result = np.empty((len(numbers), width), dtype=np.int64)
        for place, (_, cells) in enumerate(blocks):
            mine = (numbers >= first[place]) & (numbers < first[place + 1])
            cell, face = np.divmod(numbers[mine] - first[place], len(tables[place]))
            found = cells[cell[:, None], tables[place][face]]
            result[mine, : found.shape[1]] = found
            result[mine, found.shape[1] :] = found[:, -1:]
        return result

    parts = [cell_face_keys(cells, kind, node_count) for kind, cells in blocks]
    keys = parts[0] if len(parts) == 1 else np.concatenate(parts)
    del parts
    ranked = np.sort(keys)
    same = ranked[1:] == ranked[:-1]
    single = _places(keys, ranked[~(np.r_[False, same] | np.r_[same, False])])
    crowded = np.unique(ranked[2:][same[1:] & same[:-1]])
    places = _places(keys, crowded)
    third = places[np.unique(keys[places], return_index=True)[1]]
    return skin_of(rows(single), keys[single], rows(third))


def skin_of(faces: IntArray, keys: KeyArray, crowded: IntArray) -> Surface:
    """Return the surface of its faces [k, 4|3] with their keys [k]; crowded: see `Surface`."""
    faces.flags.writeable = False
    rank = np.argsort(keys)
    return Surface(faces, keys[rank], rank, crowded)


def _places(keys: KeyArray, wanted: KeyArray) -> IntArray:
    """Return the places in `keys`, ascending, of all that stand in the sorted `wanted`, a small part of them."""
    bits = np.uint64(max(10, 3 + len(wanted).bit_length()))  # a table of marks leaves few of them to search for
    table = np.zeros(1 << int(bits), dtype=bool)
    table[wanted >> (np.uint64(64) - bits)] = True
    found = [np.zeros(0, dtype=np.int64)]
    for part in chunks_of(len(keys), 1 << 16):
        here = np.flatnonzero(table[keys[part] >> (np.uint64(64) - bits)])
        own = keys[part][here]
        place = np.minimum(np.searchsorted(wanted, own), len(wanted) - 1)
        found.append(part.start + here[wanted[place] == own])
    return np.concatenate(found)


def cracks(skin: Surface, node_count: int) -> IntArray:
    """Find quadrilaterals [k] of the surface three of whose corners are a triangle of it: cells do not fit there."""
    if skin.faces.shape[1] == 3:
        return np.zeros(0, dtype=np.int64)
    quads = np.flatnonzero(skin.faces[:, -1] != skin.faces[:, -2])
    hit = np.zeros(len(quads), dtype=bool)
    for left_out in range(4):
        corners = np.delete(skin.faces[quads], left_out, axis=1)
        hit |= skin.find(np.concatenate([corners, corners[:, -1:]], axis=1), node_count) >= 0
    return quads[hit]


def cell_face_keys(cells: IntArray, kind: str, node_count: int) -> KeyArray:
    """Return keys of all faces of all cells [m * faces per cell], cell by cell."""
    marks = _node_marks(node_count).__getitem__ if cells.size > node_count else _marks
    faces = ELEMENTS[kind].faces
    keys = np.empty((len(cells), len(faces)), dtype=np.uint64)
    for f, face in enumerate(faces):
        keys[:, f] = marks(cells[:, face[0]])
        for corner in face[1:]:
            keys[:, f] += marks(cells[:, corner])
    return keys.reshape(-1)


def face_keys(faces: IntArray, node_count: int) -> KeyArray:
    """Return a key of each face or cell [k, corners]: the sum of well-mixed 64-bit marks of its nodes.

    The sum does not depend on the order of the corners, so rows need no sorting; a last corner that repeats the one
    before does not count. Two different faces share a key with probability 2^-64: about 1e-6 for any pair among
    ten million faces.
    """
    marks = _node_marks(node_count)[faces] if faces.size > node_count else _marks(faces)
    marks[faces[:, -1] == faces[:, -2], -1] = 0
    return np.asarray(marks.sum(axis=1, dtype=np.uint64))


def in_face_table(faces: IntArray, kind: str) -> IntArray:
    """Return faces [k, 4|3] as rows of one length: a triangle among quadrilaterals has its last corner twice.

    A row of four that has another corner twice is turned until it is the last. kind: of the mesh, also "mixed".
    """
    lengths = face_corners(kind)
    width = lengths[-1]
    if len(lengths) == 1:
        return faces
    result = np.concatenate([faces, np.repeat(faces[:, -1:], width - faces.shape[1], axis=1)], axis=1)
    for turn in range(1, width):
        turned = np.roll(result, turn, axis=1)
        result = np.where((turned[:, -1] == turned[:, -2])[:, None], turned, result)
    return result


def _node_marks(count: int) -> KeyArray:
    """Return a mixed 64-bit mark of each node id (splitmix64, Steele, Lea and Flood 2014)."""
    return _marks(np.arange(count))


def _marks(numbers: IntArray) -> KeyArray:
    """Return the marks [..] of nodes of these numbers [..]."""
    mark = (numbers.astype(np.uint64) + np.uint64(1)) * np.uint64(0x9E3779B97F4A7C15)
    mark = (mark ^ (mark >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    mark = (mark ^ (mark >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return mark ^ (mark >> np.uint64(31))


def shortest_edge(nodes: FloatArray, cells: IntArray) -> float:
    """Return the length of the shortest edge [m] of the cells [m, corners] of one kind."""
    shortest = np.inf
    for part in chunks_of(len(cells)):
        x = nodes.take(cells[part].T, axis=0)
        for a, b in BY_CORNERS[cells.shape[1]].edges:
            square = (x[a] - x[b]) ** 2
            shortest = min(shortest, float(np.sqrt((square[:, 0] + square[:, 1] + square[:, 2]).min())))
    return shortest


_UPPER = np.array([(k in (1, 2, 5, 6), k in (2, 3, 6, 7), k > 3) for k in range(8)])  # corners of a hex8 [8, axis]


def parallelepipeds(nodes: Rows, cells: Rows) -> bool:
    """Return whether every hex8 is a parallelepiped: its Jacobian is then constant.

    To 1e-11 of its longest edge and 1e-10 of its shortest, which bounds the error of the force of flat cells.
    """
    operator = np.zeros((7, 8))  # three edges, then the way from where the edges lead to a corner
    for row, ends in zip(operator, ((1,), (3,), (4,), (2, 1, 3), (5, 1, 4), (7, 3, 4), (6, 1, 3, 4)), strict=True):
        row[ends[0]], row[list(ends[1:])] = 1.0, -1.0
    operator[:, 0] = -operator.sum(axis=1)
    for _, vectors in differences(nodes, cells, operator):
        sizes = np.abs(vectors).max(axis=1)
        limit = np.minimum(1e-11 * sizes[:3].max(axis=0), 1e-10 * sizes[:3].min(axis=0))
        if (sizes[3:].max(axis=0) > limit).any():
            return False
    return True


def boxes(nodes: Rows, cells: Rows) -> bool:
    """Return whether every hex8 is a box along the axes, in the order of its corners: its Jacobian is then diagonal.

    Its corners are those of the box to 1e-13 of its shortest edge.
    """
    for first in range(0, len(cells), _CHUNK):
        x = nodes[cells[first : first + _CHUNK]]
        low, high = x[:, 0], np.stack([x[:, 1, 0], x[:, 3, 1], x[:, 4, 2]], axis=1)
        shortest = (high - low).min(axis=1)
        away = np.abs(x - np.where(_UPPER, high[:, None], low[:, None])).max(axis=(1, 2))
        if not (away <= 1e-13 * shortest).all():
            return False
    return True


def grid_planes(coordinate: NDArray[np.float64], tolerance: float) -> NDArray[np.int64]:
    """Return the plane number of each value; values within the tolerance of the next lower one share its plane."""
    order = np.argsort(coordinate, kind="stable")
    number = np.empty(len(coordinate), dtype=np.int64)
    number[order] = np.concatenate(([0], np.cumsum(np.diff(coordinate[order]) > tolerance)))
    return number
