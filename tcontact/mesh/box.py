"""Make structured meshes of boxes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..base.errors import InputError
from ..base.validate import choice, vector, whole
from .elements import ELEMENTS
from .geometry import FloatArray, IntArray, Surface, face_keys, skin_of
from .mesh import Mesh

NODE_LIMIT = 2**31 // 24  # 24 numbers per hex8 must count in 32 bits


def box_mesh(
    size: Sequence[float], cells: Sequence[int], kind: str = "hex8", origin: Sequence[float] = (0.0, 0.0, 0.0)
) -> Mesh:
    """Make a box of equal cells with its edges along the axes.

    size: edge lengths [m]; cells: number of hexes along each axis; kind: see `Mesh`;
    kinds other than "hex8" cut every hex alike, conforming and repeating from hex to hex, so that opposite faces match
    (`Element.in_box`: "tet4" is Freudenthal's division into six tetrahedra about one diagonal);
    origin: the corner with the lowest coordinates [m]. Node ids run along x first, then y, then z.
    Face sets xmin xmax ymin ymax zmin zmax; end coordinates are exact.

    Raises `InputError` for sizes that are not positive, counts that are no whole numbers of at least 1, NaN.
    """
    kind = choice("kind", kind, ELEMENTS)
    edges, corner = vector("size", size), vector("origin", origin)
    if (edges <= 0.0).any():
        raise InputError("size", size, "give three positive edge lengths in metres")
    counts = _counts(cells)
    lines = [_line(corner[k], edges[k], counts[k]) for k in range(3)]
    nodes = np.empty((counts[2] + 1, counts[1] + 1, counts[0] + 1, 3))
    for axis in range(3):
        nodes[..., axis] = lines[axis].reshape(-1, *[1] * axis)
    corners = _cells(kind, counts)
    skin, sides = _boundary(corners, kind, counts)
    mesh = Mesh.trusted(nodes.reshape(-1, 3), corners, kind, {}, sides)
    mesh.__dict__["_surface"] = skin
    return mesh


def _counts(cells: Any) -> list[int]:
    remedy = "give three whole numbers of at least 1, the cells along x, y and z"
    try:
        counts = [whole("cells", count, 1) for count in cells]
    except (TypeError, ValueError) as error:
        raise InputError("cells", cells, remedy) from error
    if len(counts) != 3:
        raise InputError("cells", cells, remedy)
    if (counts[0] + 1) * (counts[1] + 1) * (counts[2] + 1) > NODE_LIMIT:
        raise InputError("cells", cells, f"more than {NODE_LIMIT} nodes; use fewer cells")
    return counts


def _line(start: float, length: float, count: int) -> FloatArray:
    """Return equally spaced coordinates whose first and last are exact."""
    with np.errstate(over="ignore", invalid="ignore"):
        line = np.linspace(start, start + length, count + 1)
        steps = np.diff(line) * count / length
        volume = length * length * length / count**3
    if not (np.isfinite(line).all() and np.allclose(steps, 1.0, rtol=0.0, atol=1e-3) and 0.0 < volume < np.inf):
        raise InputError("size, origin", (length, start), "cells are lost in rounding; use metres near the origin")
    return line


def _cells(kind: str, counts: list[int]) -> IntArray:
    """Return the cells [m, corners], hexahedron after hexahedron, each cut alike."""
    nx, ny, nz = counts
    row, layer = nx + 1, (nx + 1) * (ny + 1)
    first = np.arange(nx) + row * np.arange(ny)[:, None] + layer * np.arange(nz)[:, None, None]
    bottom = np.array([0, 1, row + 1, row])
    offsets = np.concatenate([bottom, bottom + layer])[np.array(ELEMENTS[kind].in_box)].reshape(-1)
    cells = np.empty((first.size, len(offsets)), dtype=np.int64)
    for place, offset in enumerate(offsets):
        np.add(first.reshape(-1), offset, out=cells[:, place])
    return cells.reshape(-1, ELEMENTS[kind].corners)


def _boundary(cells: IntArray, kind: str, counts: list[int]) -> tuple[Surface, dict[str, IntArray]]:
    """Return the surface, and its faces by side, outward."""
    inner = np.zeros(counts[::-1], dtype=bool)  # hexahedra
    inner[1:-1, 1:-1, 1:-1] = True
    outer = cells.reshape(inner.size, -1)[~inner.reshape(-1)].reshape(-1, cells.shape[1])
    table = ELEMENTS[kind].face_table
    faces, shape = outer[:, table].reshape(-1, table.shape[1]), np.array(counts) + 1
    place = faces[:, :, None] // np.cumprod([1, *shape[:2]]) % shape
    at_side = np.concatenate([(place == 0).all(axis=1), (place == counts).all(axis=1)], axis=1)
    on_side = at_side.any(axis=1)
    faces, at_side = faces[on_side], at_side[on_side]
    sides = {
        letter + end: faces[at_side[:, axis + 3 * (end == "max")]]
        for axis, letter in enumerate("xyz")
        for end in ("min", "max")
    }
    return skin_of(faces, face_keys(faces, int(np.prod(shape))), faces[:0]), sides
