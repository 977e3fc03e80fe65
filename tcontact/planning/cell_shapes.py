"""Stored shapes: the geometry of cells at rest that the force pass reads instead of computing it from their corners.

A tetrahedron has A^-t and D = det A of A = dX/dr, a one-point hexahedron that is a parallelepiped has the same of
A = 8 dX/dr: 80 bytes a cell, for 12 or 24 gathered numbers and the inverse of A less in every step. They follow from
the positions, so that checkpoints do not hold them. Very large blocks compute them in every step instead (LARGEST).
"""

from __future__ import annotations

import numpy as np

from ..mesh.elements import FORMULATIONS
from ..mesh.geometry import boxes, parallelepipeds
from ..mesh.late_rows import Rows

NUMBERS = 10  # of a cell: A^-t, row by row, and D
STORED = {"tet4-stored": NUMBERS, "hex8-reduced-affine": NUMBERS}  # by the name of the element in the kernels
LARGEST = 2**27 // NUMBERS  # cells of a block, whose shapes take 1 GiB; places of numbers stay below 2^30 (vectors.py)
_EDGES = {4: (1.0, (1, 2, 3)), 8: (4.0, (1, 3, 4))}  # by corners: A over the edges from corner 0, and their ends


def variant(element: str, nodes: Rows, cells: Rows) -> str:
    """Return the name of an element in the kernels for these cells [m, corners].

    It ends in "-box" where all cells are boxes along the axes and in "-affine" where they are parallelepipeds, if the
    kernels make use of that, and in "-stored" where they read stored shapes of cells of any form.
    """
    if len(cells) <= LARGEST and f"{element}-stored" in STORED:
        return f"{element}-stored"
    if FORMULATIONS[element].box is not None and boxes(nodes, cells):
        return f"{element}-box"
    affine = f"{element}-affine"
    if FORMULATIONS[element].affine is None or (affine in STORED and len(cells) > LARGEST):
        return element
    return affine if parallelepipeds(nodes, cells) else element


def shapes(corners: np.ndarray) -> np.ndarray:
    """Return the stored numbers [m, NUMBERS] of cells with these corners [m, 4|8, 3]."""
    scale, ends = _EDGES[corners.shape[1]]
    a, b, c = (scale * (corners[:, end] - corners[:, 0]) for end in ends)  # columns of A
    normals = [np.cross(b, c), np.cross(c, a), np.cross(a, b)]
    d = (a * normals[0]).sum(axis=1, keepdims=True)
    turned = np.stack(normals, axis=2) / d[:, :, None]  # [m, component, direction]
    return np.concatenate([turned.reshape(-1, 9), d], axis=1)
