"""Tell which of two bodies bends where they come together: a curved or sharp surface against a flat, coarse one.

A row averages the gap over the faces around a slave node. Over a flat face of size h against a surface of curvature
kappa it differs from the gap at the nearest point by about h^2 kappa / 8, and where the face is covered in part it is
extrapolated: rows press where nothing touches, or too late. Such a surface has to be the slave, whose nodes a flat
master keeps off exactly, whatever the stiffness of the two. The bend of a surface is the angle by which it turns away
from its mean normal over half a face of the other body; that of an edge or a tip is the angle of its faces.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from .body import Body
from .meeting import TOGETHER, area_vectors, facing_faces, unit

BENT = 0.1  # bend [rad] of a surface within half a face of a flat body that makes it the slave
TWICE = 2.0  # bend over that of the other body, from which a surface is the one that bends
SHARP = 0.8  # angle [rad] between two faces beyond which their edge is sharp within any face, however small
AROUND = 16  # faces around a point that are asked for edges
SAMPLES = 6  # points along each side of a face, at most
SLACK = 0.1  # of the smaller face: what a face may lie behind another that it looks at


class Skin:
    """The contact faces of a body at the start.

    corners [f, 4|3, 3] [m]; velocity [3] [m/s]: its mean; size [m]: root of the mean area of a face.
    """

    def __init__(self, body: Body) -> None:
        self.corners = body.initial_at(body.contact_faces) if body.touches else np.zeros((0, 4, 3))
        self.velocity = body.initial_velocity.mean(axis=0) if body.touches else np.zeros(3)

    @cached_property
    def vectors(self) -> np.ndarray:
        """Area times outward unit normal [f, 3] [m^2] of every face."""
        return area_vectors(self.corners)

    @cached_property
    def size(self) -> float:
        """Root of the mean area [m] of a face."""
        return float(np.sqrt(np.linalg.norm(self.vectors, axis=1).mean()))

    @cached_property
    def plane(self) -> bool:
        """Whether all faces look into one direction."""
        normals = unit(self.vectors)
        return bool((normals @ unit(self.vectors.sum(axis=0)[None])[0] >= TOGETHER).all())

    @cached_property
    def box(self) -> tuple[np.ndarray, np.ndarray]:
        """The lowest and highest coordinates [3] [m]."""
        return self.corners.min(axis=(0, 1)), self.corners.max(axis=(0, 1))


def bent_one(one: Skin, other: Skin) -> int | None:
    """Return 0 or 1, the body that bends where the other one is flat in comparison; None if neither does.

    A hollow in which the other one fits counts against the bend of that.
    """
    if not len(one.corners) or not len(other.corners) or (one.plane and other.plane):
        return None
    shift = (one.velocity - other.velocity) * _entry(one, other)
    sides = (one.corners + shift, one), (other.corners, other)
    patches = _patches(sides)
    if patches is None:
        return None
    sizes = other.size, one.size
    own = [_bend(patch, middle, 0.5 * size) for (patch, middle), size in zip(patches, sizes, strict=True)]
    for number in (0, 1):
        bend, hollow = own[number], own[1 - number]
        fits = min(hollow, 0.0) * sizes[number] / sizes[1 - number]  # its bend over the same length
        if bend + fits > BENT and bend > TWICE * abs(hollow):
            return number
    return None


def _entry(one: Skin, other: Skin) -> float:
    """Return the time [s] after which the boxes of two bodies meet at their speed, 0 if they do or never will."""
    speed = one.velocity - other.velocity
    way = np.where(speed > 0.0, other.box[0] - one.box[1], other.box[1] - one.box[0])
    end = np.where(speed > 0.0, other.box[1] - one.box[0], other.box[0] - one.box[1])
    moves = speed != 0.0
    there = (other.box[0] <= one.box[1]) & (one.box[0] <= other.box[1])
    if not moves.any() or not (moves | there).all():
        return 0.0
    first, last = (way[moves] / speed[moves]).max(), (end[moves] / speed[moves]).min()
    return float(first) if 0.0 < first <= last else 0.0


def _patches(sides: Any) -> list[tuple[np.ndarray, np.ndarray]] | None:
    """Return of both bodies the faces [k, 4|3, 3] that look at each other where they are closest, and the place [3].

    sides: corners [f, 4|3, 3] and skin of both. None where no faces look at each other.
    """
    from scipy.spatial import cKDTree

    near = [_near_box(corners, sides[1 - number][0]) for number, (corners, _) in enumerate(sides)]
    sizes = [skin.size for _, skin in sides]
    counts = [int(np.clip(np.ceil(sizes[k] / sizes[1 - k]), 1, SAMPLES)) for k in (0, 1)]
    points = [_samples(sides[k][0][near[k]], counts[k]) for k in (0, 1)]
    distance, which = cKDTree(points[1].reshape(-1, 3)).query(points[0].reshape(-1, 3))
    closest = int(distance.argmin())
    found = []
    for k, place in enumerate((closest, int(which[closest]))):
        corners, own = sides[k][0], near[k][place // points[k].shape[1]]
        middle = points[k].reshape(-1, 3)[place]
        radius = max(0.5 * sizes[1 - k], np.linalg.norm(corners[own] - middle, axis=1).max())
        beside = np.linalg.norm(corners - middle, axis=2).min(axis=1) <= 1.001 * radius
        found.append((corners[beside], middle))
    slack = SLACK * min(sizes)
    kept = [facing_faces(found[k][0], found[1 - k][0], np.inf, slack) for k in (0, 1)]
    if not kept[0].any() or not kept[1].any():
        return None
    return [(faces[some], middle) for (faces, middle), some in zip(found, kept, strict=True)]


def _near_box(corners: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Return the numbers of the faces that may be the closest to another body, by the distance from its box."""
    low, high = others.min(axis=(0, 1)), others.max(axis=(0, 1))
    away = np.linalg.norm(np.maximum(0.0, np.maximum(low - corners, corners - high)), axis=2)
    face, corner = np.unravel_index(int(away.argmin()), away.shape)
    bound = np.linalg.norm(others - corners[face, corner], axis=2).min()
    own = np.linalg.norm(corners - corners.mean(axis=1)[:, None], axis=2).max(axis=1)
    return np.flatnonzero(away.min(axis=1) <= bound + own)


def _samples(corners: np.ndarray, count: int) -> np.ndarray:
    """Return points [f, p, 3] of faces [f, 4|3, 3]: their corners and others at so many steps along each side."""
    steps = np.linspace(0.0, 1.0, max(count, 2) + 1)
    u, v = (part.reshape(-1) for part in np.meshgrid(steps, steps))
    if corners.shape[1] == 3:
        inside = u + v <= 1.0 + 1e-9
        u, v = u[inside], v[inside]
        shapes = np.stack([1.0 - u - v, u, v])
    else:
        shapes = np.stack([(1.0 - u) * (1.0 - v), u * (1.0 - v), u * v, (1.0 - u) * v])
    return np.asarray(np.einsum("ap,fai->fpi", shapes, corners))


def _bend(faces: np.ndarray, middle: np.ndarray, reach: float) -> float:
    """Return the bend [rad] of faces [k, 4|3, 3] around a point [3] [m] within a reach [m]; negative where hollow."""
    vectors = area_vectors(faces)
    area, normals = np.linalg.norm(vectors, axis=1), unit(vectors)
    mean = unit(vectors.sum(axis=0)[None])[0]
    angles = np.arccos(np.clip(normals @ mean, -1.0, 1.0))
    apart = faces.mean(axis=1) - middle
    apart -= np.outer(apart @ mean, mean)
    way = float(np.sqrt(area @ (apart**2).sum(axis=1) / area.sum()))
    apart -= area @ apart / area.sum()
    sign = float(np.sign((area[:, None] * (normals - mean) * apart).sum()))
    if way == 0.0 or _has_edge(faces, normals, middle):
        return sign * float(angles.max())
    return sign * reach * float(np.sqrt(area @ angles**2 / area.sum())) / way


def _has_edge(faces: np.ndarray, normals: np.ndarray, middle: np.ndarray) -> bool:
    """Return whether two of the faces closest to a point that share an edge make a sharp one."""
    closest = np.linalg.norm(faces - middle, axis=2).min(axis=1).argsort(kind="stable")[:AROUND]
    own, directions = faces[closest], normals[closest]
    nearer = 1e-6 * np.linalg.norm(own[:, 0] - own[:, 1], axis=1).min()
    common = np.linalg.norm(own[:, None, :, None] - own[None, :, None], axis=4) <= nearer
    beside = common.any(axis=3).sum(axis=2) >= 2
    return bool((beside & (directions @ directions.T < np.cos(SHARP))).any())
