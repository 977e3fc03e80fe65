"""The boundary of a mesh as triangles to draw."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...base import validate
from ...base.errors import InputError
from ...mesh.elements import ELEMENTS
from ...scene.obstacles.base import direction as unit_of


@dataclass(frozen=True)
class Surface:
    """The boundary of a mesh as triangles: faces that belong to one cell only.

    A quadrilateral is cut into four triangles around its centre, so that colours on it do not depend on a diagonal.
    nodes [s] mesh nodes on the boundary; quads [q,4], triangles [t,3] faces in local numbers (0..s-1); owner [q+t] cell
    of a face; corners [T,3] drawn triangles in local numbers, s+i = centre of quad i; face [T] their face; edges [T]
    bits of their real edges.
    """

    nodes: np.ndarray
    quads: np.ndarray
    triangles: np.ndarray
    owner: np.ndarray
    corners: np.ndarray
    face: np.ndarray
    edges: np.ndarray

    @cached_property
    def halved(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Corners, face, edges of quadrilaterals cut in two: enough for one colour a face and for shadows."""
        count, quads = len(self.quads), self.quads
        number = np.arange(count + len(self.triangles))
        return (
            np.concatenate([quads[:, [0, 1, 2]], quads[:, [2, 3, 0]], self.triangles]),
            np.concatenate([number[:count], number]),
            np.repeat(np.array([5, 7], dtype=np.int32), [2 * count, len(self.triangles)]),
        )

    def spread(self, values: np.ndarray) -> np.ndarray:
        """Return nodal values [s] or [s,k] with the quad centres appended."""
        return np.concatenate([values, values[self.quads].mean(axis=1)])


def boundary_surface(blocks: Sequence[tuple[str, np.ndarray]]) -> Surface:
    """Return the surface of a mesh given as (kind, connectivity [m,k]) blocks."""
    found: dict[int, list[np.ndarray]] = {3: [], 4: []}
    owners: dict[int, list[np.ndarray]] = {3: [], 4: []}
    first = 0
    for kind, cells in blocks:
        for corners, parts in found.items():
            local = [face for face in ELEMENTS[kind].faces if len(face) == corners]
            if local:
                parts.append(cells[:, local].reshape(-1, corners))
                owners[corners].append(np.repeat(np.arange(first, first + len(cells)), len(local)))
        first += len(cells)
    faces = {}
    for corners in (3, 4):
        if found[corners]:
            every, owner = np.concatenate(found[corners]), np.concatenate(owners[corners])
            once = _used_once(every)
            faces[corners] = every[once], owner[once]
        else:
            faces[corners] = np.empty((0, corners), dtype=np.int64), np.empty(0, dtype=np.int64)
    (triangles, triangle_owner), (quads, quad_owner) = faces[3], faces[4]
    nodes = np.unique(np.concatenate([triangles.ravel(), quads.ravel()]))
    triangles, quads = np.searchsorted(nodes, triangles), np.searchsorted(nodes, quads)
    centre = len(nodes) + np.arange(len(quads))
    fan = [np.stack([quads[:, k], quads[:, (k + 1) % 4], centre], axis=1) for k in range(4)]
    number = np.arange(len(quads) + len(triangles))
    return Surface(
        nodes,
        quads,
        triangles,
        np.concatenate([quad_owner, triangle_owner]),
        np.concatenate([*fan, triangles]),
        np.concatenate([np.tile(number[: len(quads)], 4), number[len(quads) :]]),
        np.repeat(np.array([4, 7], dtype=np.int32), [4 * len(quads), len(triangles)]),
    )


@dataclass(frozen=True)
class Clip:
    """A plane that cuts bodies open: cells whose centre (undeformed) lies on the side of `normal` are not drawn.

    With several clips only what lies beyond all of them is left away: two cut out a quarter. Cells stay whole.
    """

    point: tuple[float, float, float]
    normal: tuple[float, float, float]

    def __post_init__(self) -> None:
        validate.vector("Clip.point", self.point)
        unit = unit_of("Clip.normal", self.normal, "give three finite numbers that are not all zero")
        object.__setattr__(self, "normal", tuple(unit.tolist()))


def clipped_surface(points: np.ndarray, blocks: Sequence[tuple[str, np.ndarray]], clips: Sequence[Clip]) -> Surface:
    """Return the surface of the cells that the clips leave. Raises `InputError` if none is left."""
    if not clips:
        return boundary_surface(blocks)
    left, numbers, first = [], [], 0
    for kind, cells in blocks:
        centres = points[cells].mean(axis=1)
        gone = np.ones(len(cells), dtype=bool)
        for clip in clips:
            gone &= (centres - np.array(clip.point)) @ np.array(clip.normal) > 0.0
        left.append((kind, cells[~gone]))
        numbers.append(first + np.flatnonzero(~gone))
        first += len(cells)
    number = np.concatenate(numbers)
    if len(number) == 0:
        raise InputError("clip", clips, "nothing is left to draw; move the plane or turn its normal")
    surface = boundary_surface([block for block in left if len(block[1])])
    return replace(surface, owner=number[surface.owner])


def _used_once(faces: np.ndarray) -> np.ndarray:
    """Return the indices of the faces [f,k] whose set of nodes occurs once, in their order."""
    key = np.sort(faces, axis=1)
    order = np.lexsort(key.T)
    new = np.concatenate([[True], (np.diff(key[order], axis=0) != 0).any(axis=1), [True]])
    return np.sort(order[new[:-1] & new[1:]])
