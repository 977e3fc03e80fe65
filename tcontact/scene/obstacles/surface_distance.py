"""Sample the signed distance to a closed surface of triangles on a grid around it."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...base import validate
from ...base.errors import InputError
from .nearest import TriangleTree, pieces_of
from .surface import FIELD, closed_surface
from .winding import winding_numbers

MAXIMUM_NODES = 2**26  # maximum number of nodes of the grid
MARGIN = 4  # default number of cells around the solid
PIECE = 8.0  # longest edge of the pieces, in cells


def sample_surface(
    surface: Any, cells: int, margin: float | None, scale: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray, float, tuple[np.ndarray, np.ndarray]]:
    """Return distance [nx, ny, nz], gradient [nx, ny, nz, 3], origin [3], spacing and (points, triangles).

    The arguments are those of `Sdf.from_surface`. Raises `InputError`.
    """
    validate.whole("cells", cells, 4)
    if margin is not None:
        margin = validate.number("margin", margin, low=0.0)
    points, triangles = closed_surface(surface, scale)
    low, high = points.min(axis=0), points.max(axis=0)
    spacing = float((high - low).max()) / cells
    around = MARGIN * spacing if margin is None else margin
    wide = (high - low + 2.0 * around) / spacing + 2.0
    if not np.prod(wide) <= MAXIMUM_NODES:
        raise InputError(
            "cells, margin", (cells, margin), f"the grid has more than {MAXIMUM_NODES} nodes; take fewer cells"
        )
    count = np.ceil((high - low + 2.0 * around) / spacing - 1e-9).astype(np.int64) + 1
    count = np.maximum(count, MARGIN)
    nx, ny, nz = (int(n) for n in count)
    origin = 0.5 * (low + high) - 0.5 * spacing * (count - 1)
    nodes = np.stack(np.meshgrid(*(np.arange(n) for n in count), indexing="ij"), axis=-1).reshape(-1, 3)
    positions = origin + spacing * nodes

    corners = pieces_of(points[triangles], PIECE * spacing)
    shape = (nx, ny, nz)
    found, piece = TriangleTree(corners).nearest(positions, spacing)
    away = positions - found
    distance = np.linalg.norm(away, axis=1)
    side = _sides(surface, points, triangles, origin, spacing, shape, distance)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1).clip(1e-300)[:, None]
    # on the surface the direction to its nearest point is rounding
    clear = distance > 1e-7 * spacing
    safe = np.where(clear, distance, 1.0)[:, None]
    gradient = np.where(clear[:, None], side[:, None] * away / safe, normal[piece])
    return (side * distance).reshape(shape), gradient.reshape(*shape, 3), origin, spacing, (points, triangles)


def _sides(
    surface: Any,
    points: np.ndarray,
    triangles: np.ndarray,
    origin: np.ndarray,
    spacing: float,
    count: tuple[int, int, int],
    distance: np.ndarray,
) -> np.ndarray:
    """Return -1 for nodes [n] within the solid, 1 for the others."""
    winding = winding_numbers(points, triangles, origin, spacing, count)
    if winding is None:
        raise InputError(FIELD, surface, "inside and outside cannot be told apart; remove slivers, or change `cells`")
    winding = winding.reshape(-1)
    clear = winding[distance > 1e-3 * spacing]
    if (clear < 0).any():
        raise InputError(FIELD, surface, "one of its shells is oriented inward but bounds a solid; turn it around")
    if (clear > 1).any():
        remedy = "its shells overlap, or a cavity is oriented like a solid; unite the shells, turn the cavity around"
        raise InputError(FIELD, surface, remedy)
    return np.where(winding > 0, -1.0, 1.0)
