"""Make structured meshes of boxes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..base.errors import InputError
from ..base.validate import choice, vector, whole
from .elements import ELEMENTS
from .geometry import FloatArray, IntArray, surface
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
    z, y, x = np.meshgrid(lines[2], lines[1], lines[0], indexing="ij")
    nodes = np.stack([x.reshape(-1), y.reshape(-1), z.reshape(-1)], axis=1)
    element = ELEMENTS[kind]
    corners = _hexes(counts)[:, np.array(element.in_box)].reshape(-1, element.corners)
    return Mesh.trusted(nodes, corners, kind, {}, _sides(corners, kind, counts))


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


def _hexes(counts: list[int]) -> IntArray:
    nx, ny, nz = counts
    row, layer = nx + 1, (nx + 1) * (ny + 1)
    k, j, i = np.meshgrid(np.arange(nz), np.arange(ny), np.arange(nx), indexing="ij")
    first = (i + row * j + layer * k).reshape(-1).astype(np.int64)
    bottom = np.array([0, 1, row + 1, row])
    return first[:, None] + np.concatenate([bottom, bottom + layer])


def _sides(cells: IntArray, kind: str, counts: list[int]) -> dict[str, IntArray]:
    """Return the boundary faces by side, outward."""
    shape = np.array(counts) + 1
    faces = surface([(kind, cells)], int(np.prod(shape))).faces
    sides, left = {}, faces
    for axis, letter in enumerate("xyz"):
        place = left // int(np.prod(shape[:axis])) % shape[axis]
        low, high = (place == 0).all(axis=1), (place == counts[axis]).all(axis=1)
        sides[letter + "min"], sides[letter + "max"] = left[low], left[high]
        left = left[~low & ~high]
    return sides
