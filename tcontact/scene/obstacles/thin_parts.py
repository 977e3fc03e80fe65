"""Find parts of a surface that are too thin for the grid on which its distance is sampled.

Between the nodes of the grid the distance is interpolated: a plate between two layers of nodes is outside everywhere.
At points p of the surface the ball that touches it there from within and is as large as it can be is found by shrinking
(Ma, Bae and Choi 2012, The Visual Computer 28): its diameter is the thickness. Where the interpolated distance at its
centre is positive the part is lost. An edge is always lost at its very tip, and the plane sides of a plate never meet:
lost points count where they are far from what is resolved, less far where the two sides are parallel.
"""

from __future__ import annotations

import numpy as np

from ...base.errors import InputError
from .interpolation import interpolate
from .nearest import TriangleTree, pieces_of

MAXIMUM_NODES = 2**26  # maximum number of nodes of a grid
PIECE = 1.0  # longest edge of the pieces whose centres are checked, in spacings
WIDE = 8.0  # longest edge of the pieces to which distances are measured, in spacings
ROUNDS = 12  # maximum number of shrinking steps; wedges converge by a factor in each
PARALLEL = np.cos(np.radians(8.0))  # angle of two sides below which they belong to a plate
PLATE = 2.0  # allowed distance of a lost part with parallel sides from a resolved one, in spacings
WEDGE = 8.0  # the same for any other part
ENOUGH = 2.0  # spacings across a part that is well resolved


def check_thickness(
    triangles: tuple[np.ndarray, np.ndarray], grid: np.ndarray, origin: np.ndarray, spacing: float, cells: int
) -> None:
    """Raise `InputError` where a part of a closed surface is lost between the nodes of the grid.

    triangles: points [k, 3] and triangles [m, 3]; grid [nx, ny, nz, 4], origin [3] [m], spacing [m]: of the sampled
    distance; cells: how many the user asked for.
    """
    corners = pieces_of(triangles[0][triangles[1]], PIECE * spacing)
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(across, axis=1)
    solid = np.flatnonzero(area > 0.0)
    points, normals = corners[solid].mean(axis=1), across[solid] / area[solid, None]
    # one point a cell and direction is enough
    alike = np.concatenate([np.floor(points / spacing), np.round(2.0 * normals)], axis=1)
    chosen = np.unique(alike, axis=0, return_index=True)[1]
    points, normals = points[chosen], normals[chosen]
    sides = pieces_of(triangles[0][triangles[1]], WIDE * spacing)
    radius, opposite = inner_balls(sides, points, normals, spacing)
    thin = np.flatnonzero(2.0 * radius < spacing)
    centres = points[thin] - radius[thin, None] * normals[thin]
    lost = thin[interpolate(grid, origin, spacing, centres)[0] > 0.0]
    if not len(lost):
        return
    reach = _reach(points[lost], np.delete(points, thin, axis=0))
    facing = sides[opposite[lost]]
    facing = np.cross(facing[:, 1] - facing[:, 0], facing[:, 2] - facing[:, 0])
    facing /= np.maximum(np.linalg.norm(facing, axis=1), 1e-300)[:, None]
    plate = np.einsum("ni,ni->n", normals[lost], facing) < -PARALLEL
    bad = (reach > WEDGE * spacing) | (plate & (reach > PLATE * spacing))
    if bad.any():
        bad = lost[bad & plate] if (bad & plate).any() else lost[bad]
        place = bad[radius[bad].argsort()[len(bad) // 2]]
        raise InputError("cells", cells, _remedy(2.0 * radius[place], points[place], grid.shape[:3], spacing, cells))


def inner_balls(
    corners: np.ndarray, points: np.ndarray, normals: np.ndarray, largest: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return radii [n] [m], at most `largest`, of the balls within the surface that touch it at points [n, 3].

    corners [m, 3, 3]: the triangles; normals [n, 3]: outward. The second answer [n] is the triangle that a ball touches
    on its other side, or one at its own point for a ball that is not held there.
    """
    radius, opposite = np.full(len(points), largest), np.zeros(len(points), dtype=np.int64)
    active, tree = np.arange(len(points)), TriangleTree(corners)
    for _ in range(ROUNDS):
        centres = points[active] - radius[active, None] * normals[active]
        found, owner = tree.nearest(centres, largest)
        apart = points[active] - found
        depth = np.einsum("ni,ni->n", apart, normals[active])
        inside = np.linalg.norm(found - centres, axis=1) < radius[active] * (1.0 - 1e-6)
        inside &= depth > 0.0
        active, apart, depth, owner = active[inside], apart[inside], depth[inside], owner[inside]
        if not len(active):
            break
        radius[active] = np.minimum(radius[active], np.einsum("ni,ni->n", apart, apart) / (2.0 * depth))
        opposite[active] = owner
    return radius, opposite


def _reach(lost: np.ndarray, resolved: np.ndarray) -> np.ndarray:
    """Return the distance [n] [m] of lost points to the nearest resolved one."""
    from scipy.spatial import cKDTree

    if not len(resolved):
        return np.full(len(lost), np.inf)
    return np.asarray(cKDTree(resolved).query(lost)[0])


def _remedy(thickness: float, place: np.ndarray, nodes: tuple[int, ...], spacing: float, cells: int) -> str:
    """Return the error and its remedy; nodes: number of nodes of the grid along x, y and z."""
    where = ", ".join(f"{x:.3g}" for x in place)
    text = f"the surface is {thickness:.3g} m thick near ({where}), and the grid has a node every {spacing:.3g} m only"
    finer = ENOUGH * spacing / max(thickness, 1e-9 * spacing)
    if np.prod(np.array(nodes) * finer) > MAXIMUM_NODES:
        return f"{text}: bodies would pass through it; thicken the part, or use a Box or Cylinder for it"
    return (
        f"{text}: bodies would pass through it; take cells={int(np.ceil(finer * cells))} or more, or thicken the part"
    )
