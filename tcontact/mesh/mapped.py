"""Join mapped blocks of hexahedra into one mesh, and cut hexahedra into tetrahedra or prisms."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from .elements import HEX_CORNERS, WEDGE6
from .geometry import FloatArray, IntArray, grid_planes, surface
from .mesh import Mesh

CORNERS = ((HEX_CORNERS + 1) // 2).astype(int)  # of a hexahedron, in steps along the three directions of a block
SIDES = ((3, 2, 1, 0), (4, 5, 6, 7), (0, 1, 5, 4), (2, 3, 7, 6), (3, 0, 4, 7), (1, 2, 6, 5))
ROUNDING = 1e-9  # distance over size below which two points are one node


def between(first: FloatArray, last: FloatArray, shares: FloatArray) -> FloatArray:
    """Return points [a, b, k, 3] on the straight lines between two surfaces [a, b, 3], at the shares [k] of the way."""
    return np.asarray(first[:, :, None] + shares[:, None] * (last - first)[:, :, None])


def merged(points: FloatArray, size: npt.ArrayLike) -> tuple[FloatArray, IntArray]:
    """Return the different points, sorted by x, y and z, and the number [n] of every point among them.

    Points are one if they are closer than `ROUNDING` times the size, one number or one for each axis [m].
    """
    tolerance = ROUNDING * np.broadcast_to(np.asarray(size, dtype=np.float64), 3)
    planes = np.stack([grid_planes(points[:, axis], tolerance[axis]) for axis in range(3)], axis=1)
    _, first, number = np.unique(planes, axis=0, return_index=True, return_inverse=True)
    return points[first], number.reshape(-1)


def join(blocks: Sequence[FloatArray], skin: Mapping[str, Callable[[FloatArray], Any]], size: npt.ArrayLike) -> Mesh:
    """Return a mesh of hexahedra of blocks of points [a, b, c, 3], block after block.

    skin: sets of outer faces by name, each a function of face centres [f, 3] that says which belong to it; size: see
    `merged`. Its cell sets are "core", the first block, and "shell", the others.
    """
    points, cells, start = [], [], 0
    for grid in blocks:
        count = np.array(grid.shape[:3])
        number = start + np.arange(count.prod()).reshape(count)
        corner = [number[tuple(slice(o, n - 1 + o) for o, n in zip(at, count, strict=True))].ravel() for at in CORNERS]
        cells.append(np.stack(corner, axis=1))
        points.append(grid.reshape(-1, 3))
        start += len(points[-1])
    nodes, same = merged(np.concatenate(points), size)
    connected = same[np.concatenate(cells)]
    x = nodes[connected]
    turned = np.einsum("ij,ij->i", np.cross(x[:, 1] - x[:, 0], x[:, 3] - x[:, 0]), x[:, 4] - x[:, 0]) < 0
    connected[turned] = connected[turned][:, [4, 5, 6, 7, 0, 1, 2, 3]]
    faces = connected[:, SIDES].reshape(-1, 4)
    _, where, many = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    outer = faces[where[many == 1]]
    centres = nodes[outer].mean(axis=1)
    sets = {name: outer[inside(centres)] for name, inside in skin.items()}
    regions = dict(zip(("core", "shell"), np.split(np.arange(len(connected)), [len(cells[0])]), strict=True))
    return Mesh(nodes, connected, "hex8", face_sets=sets, cell_sets=regions)


def tetrahedra(mesh: Mesh) -> Mesh:
    """Return a mesh of hexahedra cut into tetrahedra: two on each face, with a new node in the middle of the cell.

    The diagonal of a face starts at its corner of the lowest number, so that the cells on both sides agree. Face sets
    and cell sets are those of the hexahedra.
    """
    count, cells = mesh.node_count, mesh.cells
    middles = count + np.arange(len(cells))

    def cut(faces: IntArray) -> IntArray:
        """Return the two triangles [2, f, 3] of faces [f, 4]."""
        first = faces.argmin(axis=1)[:, None]
        a, b, c, d = np.take_along_axis(faces, (first + np.arange(4)) % 4, axis=1).T
        return np.stack([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])

    tets = []
    for side in SIDES:
        for triangle in cut(cells[:, side]):
            tets.append(np.concatenate([triangle[:, ::-1], middles[:, None]], axis=1))
    nodes = np.concatenate([mesh.nodes, mesh.nodes[cells].mean(axis=1)])
    sets = {name: cut(faces).reshape(-1, 3) for name, faces in mesh.face_sets.items()}
    places = np.arange(len(tets))[:, None] * len(cells)
    regions = {name: (places + numbers).reshape(-1) for name, numbers in mesh.cell_sets.items()}
    return Mesh(nodes, np.concatenate(tets), "tet4", face_sets=sets, cell_sets=regions)


def prisms(mesh: Mesh) -> Mesh:
    """Return a mesh of hexahedra cut into two prisms each, along the diagonal of the corners 0 and 2.

    Face sets and cell sets are those of the hexahedra.
    """
    cells = mesh.cells[:, np.array(WEDGE6.in_box)].reshape(-1, 6)
    skin, sets = surface([("wedge6", cells)], mesh.node_count), {}
    for name, faces in mesh.face_sets.items():
        halves = [np.delete(faces, corner, axis=1)[:, [0, 1, 2, 2]] for corner in range(4)]
        found = np.concatenate([skin.find(part, mesh.node_count) for part in (faces, *halves)])
        sets[name] = skin.faces[np.unique(found[found >= 0])]
    regions = {name: (2 * numbers[:, None] + np.arange(2)).reshape(-1) for name, numbers in mesh.cell_sets.items()}
    return Mesh(mesh.nodes, cells, "wedge6", face_sets=sets, cell_sets=regions)
