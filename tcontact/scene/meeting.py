"""Find the faces of a body that may meet another body.

The faces of the other body are taken in groups of one direction. A face may meet a group if the normals are opposite,

    n . d < FACING,    max_p n . (p - c) > -slack,    max_p d . (c - p) > -slack,    min_p |p - c| <= way + radii,

with n and c the outward normal and the centre of the face, d the mean normal of the group and p its points: each lies
in front of the other, and the bodies can come so far. Distances and angles alone decide, so that the faces found do not
depend on the axes and units of a scene.
"""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np

FACING = -0.3  # cosine between the outward normals of two faces below which they can touch
TOGETHER = 0.97  # cosine between the normals of the faces of one group and that of its first face, at least
CHUNK = 2**22  # products of a normal and a point at a time
ROUNDED = 1.0 - 1e-6  # factor on the slack: faces that lie behind by just as much are left out, whatever rounding says


class Group(NamedTuple):
    """Faces of about one direction [3]: corners [p, 3] and centres [m, 3] [m], the radius of the largest one [m]."""

    direction: np.ndarray
    points: np.ndarray
    centres: np.ndarray
    radius: float


class Faces:
    """Faces with corners [k, 4|3, 3] [m], and what comparisons with those of several other bodies share."""

    def __init__(self, corners: np.ndarray) -> None:
        self.corners = corners

    def __len__(self) -> int:
        return len(self.corners)

    @cached_property
    def normals(self) -> np.ndarray:
        """Unit outward normals [k, 3]."""
        return unit(area_vectors(self.corners))

    @cached_property
    def balls(self) -> tuple[np.ndarray, np.ndarray]:
        """Centres [k, 3] of the faces and radii [k] of the balls around them that hold their corners [m]."""
        centres = self.corners.mean(axis=1)
        return centres, np.linalg.norm(self.corners - centres[:, None], axis=2).max(axis=1)

    @cached_property
    def box(self) -> tuple[np.ndarray, np.ndarray]:
        """Lowest and highest corner [3] [m] of the box around the centres."""
        return self.balls[0].min(axis=0), self.balls[0].max(axis=0)

    @cached_property
    def largest(self) -> float:
        """Radius [m] of the largest ball."""
        return float(self.balls[1].max())

    @cached_property
    def groups(self) -> list[Group]:
        """The faces in groups of one direction."""
        found, (centres, radii) = [], self.balls
        for mine in groups_of(self.normals):
            direction = unit(self.normals[mine].sum(axis=0)[None])[0]
            found.append(Group(direction, self.corners[mine].reshape(-1, 3), centres[mine], radii[mine].max()))
        return found


def facing_faces(corners: np.ndarray, others: np.ndarray, way: float, slack: float) -> np.ndarray:
    """Return for every face of a body whether it may meet one of another body.

    corners [k, 4|3, 3], others [m, 4|3, 3]: corners of the faces [m]; way: how far the bodies can come towards each
    other [m]; slack: by how much a face may lie behind another [m].
    """
    return facing(Faces(corners), Faces(others), way, slack)


def facing(faces: Faces, others: Faces, way: float, slack: float) -> np.ndarray:
    """Return for every face whether it may meet one of the others, see `facing_faces`."""
    way, slack = way + ROUNDED * slack, ROUNDED * slack
    found = np.zeros(len(faces), dtype=bool)
    if not len(faces) or not len(others):
        return found
    normals, (centres, radii) = faces.normals, faces.balls
    for group in others.groups:
        direction, points = group.direction, group.points
        behind = centres @ direction - (points @ direction).min()
        asked = np.flatnonzero(~found & (normals @ direction < FACING) & (behind > -slack))
        asked = asked[_farthest(normals[asked], points) - _along(normals[asked], centres[asked]) > -slack]
        reach = way + radii[asked] + group.radius
        found[asked] = _near(centres[asked], group.centres, reach)
    return found


def groups_of(directions: np.ndarray) -> list[np.ndarray]:
    """Return the numbers of the directions [m, 3] in groups, each within an angle of its first one."""
    left, found = np.arange(len(directions)), []
    while len(left):
        near = directions[left] @ directions[left[0]] >= TOGETHER
        near[0] = True  # also a face without area
        found.append(left[near])
        left = left[~near]
    return found


def area_vectors(corners: np.ndarray) -> np.ndarray:
    """Return the area times the outward normal [k, 3] [m^2] of faces with corners [k, 4|3, 3]."""
    return np.asarray(0.5 * np.cross(corners[:, 2] - corners[:, 0], corners[:, -1] - corners[:, 1]))


def unit(vectors: np.ndarray) -> np.ndarray:
    """Return vectors [k, 3] with length 1, those without length as they are."""
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1)[:, None].clip(1e-300))


def _along(normals: np.ndarray, points: np.ndarray) -> np.ndarray:
    return np.asarray(np.einsum("ij,ij->i", normals, points))


def _farthest(normals: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return max_p n . p [k] over points [p, 3] for every normal n [k, 3]."""
    different, which = np.unique(normals, axis=0, return_inverse=True)
    found = np.empty(len(different))
    size = max(1, CHUNK // len(points))
    for first in range(0, len(different), size):
        part = slice(first, first + size)
        found[part] = (different[part] @ points.T).max(axis=1)
    return found[which.reshape(-1)]


def _near(centres: np.ndarray, points: np.ndarray, reach: np.ndarray) -> np.ndarray:
    """Return whether a point [p, 3] lies within the reach [k] of a centre [k, 3], for every centre."""
    if not len(centres):
        return np.zeros(0, dtype=bool)
    middle = points.mean(axis=0)
    away, radius = np.linalg.norm(centres - middle, axis=1), np.linalg.norm(points - middle, axis=1).max()
    if (away + radius <= reach).all():
        return np.ones(len(centres), dtype=bool)
    near = away - radius <= reach
    if near.any():
        from scipy.spatial import cKDTree

        near[near] = cKDTree(points).query(centres[near])[0] <= reach[near]
    return near
