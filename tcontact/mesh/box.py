"""Make structured meshes of boxes, which make their arrays when these are read."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..base.errors import InputError
from ..base.validate import choice, vector, whole
from .box_arrays import BoxMesh
from .elements import ELEMENTS
from .geometry import FloatArray
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
    Face sets xmin xmax ymin ymax zmin zmax; end coordinates are exact. The mesh keeps the coordinates along the axes
    and makes nodes and cells when they are read: processes that share a run need not have all (docs/SCALING.md).

    Raises `InputError` for sizes that are not positive, counts that are no whole numbers of at least 1, NaN.
    """
    kind = choice("kind", kind, ELEMENTS)
    edges, corner = vector("size", size), vector("origin", origin)
    if (edges <= 0.0).any():
        raise InputError("size", size, "give three positive edge lengths in metres")
    counts = _counts(cells)
    lines = [_line(corner[k], edges[k], counts[k]) for k in range(3)]
    return BoxMesh.of((lines[0], lines[1], lines[2]), kind)


def _counts(cells: Any) -> list[int]:
    remedy = "give three whole numbers of at least 1, the cells along x, y and z"
    try:
        counts = [whole("cells", count, 1, high=10**18) for count in cells]  # their product is checked below
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
