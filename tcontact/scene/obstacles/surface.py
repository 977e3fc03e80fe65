"""Read a closed surface of triangles, join equal points, check it and orient it outward."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from ...base import validate
from ...base.errors import InputError, Shown
from ...mesh.files.content import MeshFileError
from ...mesh.files.meshio_files import read_file
from .polygons import read_polygons
from .wavefront import read_wavefront

FIELD = "surface"
LARGEST = 1e60  # [m]
CLOSE = 1e-6  # distance over the size below which points are joined, where joining equal points leaves gaps


def closed_surface(given: Any, scale: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Return points [k, 3] [m] and triangles [m, 3], oriented outward, of a file or of (points, triangles).

    Raises `InputError` unless every edge belongs to two triangles that run through it in opposite directions.
    """
    factor = validate.number("scale", scale, low=0.0)
    points, triangles = _from_file(given) if isinstance(given, (str, os.PathLike)) else surface_arrays(given)
    with np.errstate(over="ignore", invalid="ignore"):
        points = points * factor
        size = float(np.ptp(points, axis=0).max()) if len(points) else 0.0
        if not (np.abs(points).max(initial=0.0) < LARGEST and (size == 0.0 or size > 1.0 / LARGEST)):
            raise InputError("scale", scale, "coordinates this large or small are lost in rounding; use metres")
    if len(triangles) == 0 or size == 0.0:
        raise InputError(FIELD, _name(given), "it has no triangles; give a closed surface")
    joined = _without_flat(*_joined(points, triangles))
    if _fault(joined[1]) is not None:
        joined = _without_flat(*_joined_close(*joined, CLOSE * size))
    fault = _fault(joined[1])
    if fault is not None:
        raise InputError(FIELD, _name(given), fault)
    points, triangles = joined
    if volume(points, triangles) < 0.0:
        triangles = triangles[:, ::-1]
    for within in _windings_within_shells(points, triangles):
        if within != 1:
            turn = "turn it around" if within < 1 else "unite the shells, or turn a cavity around"
            raise InputError(FIELD, _name(given), f"the surface winds {within} times around points at a shell; {turn}")
    return points, np.ascontiguousarray(triangles)


def volume(points: np.ndarray, triangles: np.ndarray) -> float:
    """Return the volume [m^3] within a closed surface, positive where it is oriented outward."""
    a, b, c = (points[triangles[:, i]] - points.mean(axis=0) for i in range(3))
    return float(np.einsum("ni,ni->", a, np.cross(b, c)) / 6.0)


def winding_number(points: np.ndarray, triangles: np.ndarray, position: np.ndarray) -> float:
    """Return the sum of the solid angles of the triangles over 4 pi (Van Oosterom and Strackee 1983)."""
    a, b, c = (points[triangles[:, i]] - position for i in range(3))
    la, lb, lc = (np.linalg.norm(x, axis=1) for x in (a, b, c))
    ab, bc, ca = (np.einsum("ni,ni->n", x, y) for x, y in ((a, b), (b, c), (c, a)))
    triple = np.einsum("ni,ni->n", a, np.cross(b, c))
    return float(np.arctan2(triple, la * lb * lc + ab * lc + bc * la + ca * lb).sum() / (2.0 * np.pi))


def _windings_within_shells(points: np.ndarray, triangles: np.ndarray) -> list[int]:
    """Return for each shell the winding number of the whole surface just beneath its largest triangle.

    It is 1 beneath the skin of a solid, and 1 beneath that of a cavity too, which is oriented the other way.
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    ends = triangles[:, [[0, 1], [1, 2]]].reshape(-1, 2)
    links = coo_matrix((np.ones(len(ends)), ends.T), shape=(len(points), len(points)))
    count, group = connected_components(links, directed=False)
    a, b, c = (points[triangles[:, i]] for i in range(3))
    normal = np.cross(b - a, c - a)
    area = np.linalg.norm(normal, axis=1)
    result = []
    for shell in range(count):
        members = np.flatnonzero(group[triangles[:, 0]] == shell)
        widest = members[area[members].argmax()]
        depth = 1e-5 * np.sqrt(area[widest])
        middle = (a[widest] + b[widest] + c[widest]) / 3.0
        result.append(round(winding_number(points, triangles, middle - depth * normal[widest] / area[widest])))
    return result


def _fault(triangles: np.ndarray) -> str | None:
    """Return why the surface is not closed or not oriented one way, with the remedy."""
    ends = triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    low, high = ends.min(axis=1), ends.max(axis=1)
    _, owner, count = np.unique(np.stack([low, high], axis=1), axis=0, return_inverse=True, return_counts=True)
    if len(count) == 0:
        return "all its triangles are flat; give a closed surface"
    if (count == 1).any():
        return f"it is open at {(count == 1).sum()} edges; close the holes (MeshLab, Blender: fill holes)"
    if (count > 2).any():
        return f"more than two triangles meet at {(count > 2).sum()} edges; separate or unite the parts"
    through = np.bincount(owner.reshape(-1), weights=np.where(ends[:, 0] == low, 1.0, -1.0))
    if through.any():
        wrong = int((through != 0).sum())
        return f"neighbours are oriented against each other at {wrong} edges; orient all triangles outward"
    return None


def _joined(points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Join equal points."""
    kept, number = np.unique(points + 0.0, axis=0, return_inverse=True)  # + 0.0: -0.0 and 0.0 are equal
    return kept, number.reshape(-1)[triangles]


def _joined_close(points: np.ndarray, triangles: np.ndarray, distance: float) -> tuple[np.ndarray, np.ndarray]:
    """Join points within a distance, in groups."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    pairs = cKDTree(points).query_pairs(distance, output_type="ndarray")
    links = coo_matrix((np.ones(len(pairs)), pairs.T), shape=(len(points), len(points)))
    count, group = connected_components(links, directed=False)
    kept = np.empty((count, 3))
    kept[group] = points
    return kept, group[triangles].astype(np.int64)


def _without_flat(points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Drop triangles that have a corner twice, and points that no triangle uses."""
    a, b, c = triangles.T
    triangles = triangles[(a != b) & (b != c) & (c != a)]
    used, number = np.unique(triangles, return_inverse=True)
    return points[used], number.reshape(-1, 3)


def surface_arrays(given: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return points [k, 3] [m] and triangles [m, 3] of a pair of arrays. Raises `InputError`."""
    remedy = "give the path of an STL, OBJ or PLY file, or (points [k, 3], triangles [m, 3])"
    if not isinstance(given, (tuple, list)) or len(given) != 2:
        raise InputError(FIELD, given, remedy)
    shape = validate.shape_of("surface points", given[0], "give finite numbers of shape [k, 3]")
    points = validate.floats("surface points", given[0], (shape[:1] or (0,)) + (3,))
    validate.shape_of("surface triangles", given[1], "give whole numbers of shape [m, 3]: ids of points")
    triangles = np.asarray(given[1])
    if triangles.ndim != 2 or triangles.shape[1] != 3 or not np.issubdtype(triangles.dtype, np.integer):
        raise InputError("surface triangles", given[1], "give whole numbers of shape [m, 3]: ids of points")
    if triangles.size and (triangles.min() < 0 or triangles.max() >= len(points)):
        raise InputError("surface triangles", given[1], f"ids run from 0 to {len(points) - 1}")
    return points, triangles.astype(np.int64)


def _from_file(given: str | os.PathLike[str]) -> tuple[np.ndarray, np.ndarray]:
    file = Path(given)
    validate.file_exists(FIELD, file, "no such file; check the name and the working directory")
    suffix = file.suffix.lower()
    if suffix not in FORMATS:
        raise InputError(FIELD, str(file), f"unknown extension; convert to one of {', '.join(FORMATS)}")
    try:
        points, corners = FORMATS[suffix](file)
    except MeshFileError as error:
        raise InputError(FIELD, str(file), str(error)) from error
    except Exception as error:  # readers raise all kinds of errors for broken files
        reason = " ".join(f"{type(error).__name__} {error}".split())
        raise InputError(FIELD, str(file), f"cannot be read ({reason}); save it again") from error
    if points.ndim != 2 or points.shape[1] != 3 or not np.isfinite(points).all():
        raise InputError(FIELD, str(file), "its points are not three finite numbers each; save it again")
    if corners.size and (corners.min() < 0 or corners.max() >= len(points)):
        raise InputError(FIELD, str(file), "triangles refer to points that it does not hold; save it again")
    return points, corners


def _from_stl(file: Path) -> tuple[np.ndarray, np.ndarray]:
    mesh = read_file(file, "stl")
    triangles = [np.asarray(block.data, dtype=np.int64) for block in mesh.cells if block.type == "triangle"]
    return np.asarray(mesh.points, dtype=np.float64), np.concatenate([np.zeros((0, 3), dtype=np.int64), *triangles])


FORMATS = {".stl": _from_stl, ".obj": read_wavefront, ".ply": read_polygons}


def _name(given: Any) -> Any:
    """Return what an error calls a surface: its file, or how many points and triangles its arrays have."""
    if isinstance(given, (str, os.PathLike)):
        return str(given)
    return Shown(f"{len(given[0])} points, {len(given[1])} triangles")
