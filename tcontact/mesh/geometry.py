"""Geometry and topology of cells: Jacobians, heights, volumes, boundary. The kinds of cells are in elements.py."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import reduce
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numpy.typing import NDArray

from .elements import BY_CORNERS, ELEMENTS, FloatArray, face_corners

IntArray = npt.NDArray[np.int64]
KeyArray = npt.NDArray[np.uint64]
Blocks = Sequence[tuple[str, IntArray]]  # kind of cells and their nodes [m, corners], as `Mesh.blocks`

_CHUNK = 4096  # cells at a time: temporaries stay in cache and small beside the mesh


def spanned_heights(kind: str, corners: FloatArray, span: int = 0) -> FloatArray:
    """Return the shortest height [m] of the parallelepiped of a cell (`Element.spans`); corners [m, a, 3] [m]."""
    axes = np.stack(
        [
            corners[:, list(there)].mean(axis=1) - corners[:, list(here)].mean(axis=1)
            for there, here in ELEMENTS[kind].spans[span]
        ],
        axis=1,
    )
    areas = np.cross(axes[:, [0, 1, 2]], axes[:, [1, 2, 0]])
    return np.asarray(np.abs(np.linalg.det(axes)) / np.linalg.norm(areas, axis=2).max(axis=1))


def shortest_heights(kind: str, corners: FloatArray) -> FloatArray:
    """Return the shortest of all heights [m] of each cell; corners [m, a, 3] [m]."""
    spans = range(len(ELEMENTS[kind].spans))
    return reduce(np.minimum, (spanned_heights(kind, corners, span) for span in spans))


def jacobians(
    nodes: FloatArray, cells: IntArray, gradient: FloatArray
) -> Iterator[tuple[slice, FloatArray, FloatArray]]:
    """Yield (cells, det [p, c], edges [p, c]) for chunks of c cells at p points with shape gradients [p, corners, 3].

    det is the determinant of J = dx/dxi [m^3], edges the product of the lengths of its three rows: |det| <= edges, and
    det / edges judges the shape of a cell whatever its size and aspect ratio.
    """
    points, corners, _ = gradient.shape
    operator = np.ascontiguousarray(gradient.transpose(0, 2, 1)).reshape(points * 3, corners)
    axes = [np.ascontiguousarray(nodes[:, k]) for k in range(3)]
    for start in range(0, len(cells), _CHUNK):
        part = slice(start, min(start + _CHUNK, len(cells)))
        ids = np.ascontiguousarray(cells[part].T)
        x = np.empty((corners, 3, ids.shape[1]))
        for k, axis in enumerate(axes):
            x[:, k] = axis[ids]
        x -= x[0].copy()  # differences: exact also far from the origin
        a, b, c = np.moveaxis((operator @ x.reshape(corners, -1)).reshape(points, 3, 3, -1), 1, 0)
        with np.errstate(over="ignore", invalid="ignore"):
            det = (
                a[:, 0] * (b[:, 1] * c[:, 2] - b[:, 2] * c[:, 1])
                + a[:, 1] * (b[:, 2] * c[:, 0] - b[:, 0] * c[:, 2])
                + a[:, 2] * (b[:, 0] * c[:, 1] - b[:, 1] * c[:, 0])
            )
            lengths = [np.sqrt(np.einsum("pkc,pkc->pc", row, row)) for row in (a, b, c)]
            edges = lengths[0] * lengths[1] * lengths[2]
        yield part, det, edges


def cell_volumes(nodes: FloatArray, cells: IntArray, kind: str) -> FloatArray:
    """Return the volume [m^3] of each cell [m], exact: every kind integrates its Jacobian determinant exactly."""
    volumes = np.empty(len(cells))
    _values, gradients, weights = ELEMENTS[kind].rule
    for part, det, _ in jacobians(nodes, cells, gradients):
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
    order = np.argsort(keys)
    ranked = keys[order]
    same = ranked[1:] == ranked[:-1]
    before, after = np.r_[False, same], np.r_[same, False]
    single = np.sort(order[~before & ~after])
    faces = rows(single)
    faces.flags.writeable = False
    third = order[1:-1][same[1:] & same[:-1] & ~np.r_[False, same[:-2]]] if len(same) > 1 else order[:0]
    single_keys = keys[single]
    rank = np.argsort(single_keys)
    return Surface(faces, single_keys[rank], rank, rows(third))


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
    marks = _node_marks(node_count)
    faces = ELEMENTS[kind].faces
    keys = np.empty((len(cells), len(faces)), dtype=np.uint64)
    for f, face in enumerate(faces):
        keys[:, f] = marks[cells[:, face[0]]]
        for corner in face[1:]:
            keys[:, f] += marks[cells[:, corner]]
    return keys.reshape(-1)


def face_keys(faces: IntArray, node_count: int) -> KeyArray:
    """Return a key of each face or cell [k, corners]: the sum of well-mixed 64-bit marks of its nodes.

    The sum does not depend on the order of the corners, so rows need no sorting; a last corner that repeats the one
    before does not count. Two different faces share a key with probability 2^-64: about 1e-6 for any pair among
    ten million faces.
    """
    marks = _node_marks(node_count)[faces]
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
    mark = (np.arange(count, dtype=np.uint64) + np.uint64(1)) * np.uint64(0x9E3779B97F4A7C15)
    mark = (mark ^ (mark >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    mark = (mark ^ (mark >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return mark ^ (mark >> np.uint64(31))


def shortest_edge(nodes: FloatArray, cells: IntArray) -> float:
    """Return the length of the shortest edge [m] of the cells [m, corners] of one kind."""
    edges = BY_CORNERS[cells.shape[1]].edges
    return min(float(np.linalg.norm(nodes[cells[:, a]] - nodes[cells[:, b]], axis=1).min()) for a, b in edges)


_UPPER = np.array([(k in (1, 2, 5, 6), k in (2, 3, 6, 7), k > 3) for k in range(8)])  # corners of a hex8 [8, axis]


def parallelepipeds(nodes: FloatArray, cells: IntArray) -> bool:
    """Return whether every hex8 is a parallelepiped, to 1e-11 of its size: its Jacobian is then constant."""
    for first in range(0, len(cells), _CHUNK):
        x = nodes[cells[first : first + _CHUNK]]
        edges = x[:, [1, 3, 4]] - x[:, :1]
        away = np.stack(
            [
                x[:, 2] - x[:, 0] - edges[:, 0] - edges[:, 1],
                x[:, 5] - x[:, 0] - edges[:, 0] - edges[:, 2],
                x[:, 7] - x[:, 0] - edges[:, 1] - edges[:, 2],
                x[:, 6] - x[:, 0] - edges.sum(axis=1),
            ],
            axis=1,
        )
        if (np.abs(away).max(axis=(1, 2)) > 1e-11 * np.abs(edges).max(axis=(1, 2))).any():
            return False
    return True


def boxes(nodes: FloatArray, cells: IntArray) -> bool:
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
