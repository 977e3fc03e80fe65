"""Obstacles with a shape: they are drawn as shaded surfaces, or as outlines where they would hide the body."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...base.errors import InputError
from .camera import Eye
from .colours import INK_TABLE, OBSTACLE
from .triangles import Triangles, ribbons

SIZES = {"sphere": 2, "cylinder": 2, "box": 3, "sdf": 0}  # parameters that are needed
FINE = 48  # pieces around a round shape, and along the edge of a block
REACH = 2.0  # length of endless shapes that is drawn, in radii of what is seen
Mesh = tuple[np.ndarray, np.ndarray]  # points [k, 3], triangles [m, 3]


@dataclass(frozen=True)
class Pose:
    """Place of an obstacle at the times of a series: points [m, 3] of reference, frames [m, 3, 3]; one row if fixed."""

    times: np.ndarray
    points: np.ndarray
    frames: np.ndarray

    @staticmethod
    def read(obstacle: Mapping[str, Any], index: int) -> Pose:
        """Read the place from what `obstacles.description.describe` gives. Raises `InputError`."""
        start = {"time": [0.0], "point": [obstacle.get("point")], "frame": [obstacle.get("frame") or np.eye(3)]}
        motion = obstacle.get("motion") or start
        try:
            times, points, frames = (np.array(motion[key], dtype=np.float64) for key in ("time", "point", "frame"))
        except (KeyError, TypeError, ValueError) as error:
            raise InputError(f"obstacles[{index}] motion", motion, "give time, point and frame") from error
        count = len(times)
        shapes = points.shape == (count, 3) and frames.shape == (count, 3, 3) and count > 0
        if not shapes or not np.isfinite(points).all() or not np.isfinite(frames).all():
            raise InputError(f"obstacles[{index}]", motion, "give finite points [m, 3] and frames [m, 3, 3]")
        return Pose(times, points, frames)

    def at(self, time: float) -> tuple[np.ndarray, np.ndarray]:
        """Return point [3] and frame [3, 3] at the recorded time nearest to this one."""
        row = int(np.argmin(np.abs(self.times - time)))
        return self.points[row], self.frames[row]

    @property
    def moves(self) -> bool:
        """Whether there is more than one row."""
        return len(self.times) > 1


@dataclass(frozen=True)
class Solid:
    """A sphere, cylinder, block or surface; `side` -1 where bodies are inside."""

    kind: str
    parameters: tuple[float, ...]
    pose: Pose
    surface: Mesh | None

    def mesh(self, time: float, centre: np.ndarray, radius: float) -> Mesh:
        """Return its triangles at a time, oriented towards the bodies; round shapes only near `centre`, by `radius`."""
        point, frame = self.pose.at(time)
        if self.kind == "sphere":
            return _sphere(point, self.parameters[0], self.parameters[1], centre, radius)
        if self.kind == "cylinder":
            return _cylinder(point, frame[2], self.parameters[0], self.parameters[1], centre, radius)
        points, triangles = _box(self.parameters) if self.surface is None else self.surface
        return point + points @ frame, triangles


def read_solids(obstacles: Sequence[Mapping[str, Any]]) -> list[Solid]:
    """Return all obstacles but the planes. Raises `InputError` for kinds and numbers that cannot be drawn."""
    solids = []
    for index, obstacle in enumerate(obstacles):
        kind = obstacle.get("kind")
        if kind == "plane":
            continue
        if kind not in SIZES:
            raise InputError(f"obstacles[{index}] kind", kind, f"use one of plane, {', '.join(SIZES)}")
        try:
            parameters = tuple(float(value) for value in obstacle.get("parameters", ()))
            surface = None
            if kind == "sdf":
                surface = np.array(obstacle["points"], dtype=np.float64), np.array(obstacle["triangles"], dtype=int)
        except (KeyError, TypeError, ValueError) as error:
            raise InputError(f"obstacles[{index}]", dict(obstacle), f"its numbers cannot be read ({error})") from error
        if len(parameters) < SIZES[kind] or not np.isfinite(parameters).all():
            raise InputError(f"obstacles[{index}]", parameters, f"give {SIZES[kind]} finite parameters")
        solids.append(Solid(kind, parameters, Pose.read(obstacle, index), surface))
    return solids


def shaded(mesh: Mesh, eye: Eye) -> Triangles:
    """Return the faces that look at the eye."""
    points, triangles = mesh
    normal, facing = _facing(mesh, eye)
    triangles, normal = triangles[facing], normal[facing] @ eye.axes.T
    key = np.array([-0.42, 0.72, 0.55])
    light = 0.66 + 0.22 * np.maximum(0.0, normal @ (key / np.linalg.norm(key))) + 0.2 * np.abs(normal[:, 2])
    screen = eye.project(points)[triangles]
    plain = Triangles.plain(screen, OBSTACLE)
    return Triangles(screen, plain.value, light, plain.table, plain.edges, plain.ink)


def outlined(mesh: Mesh, eye: Eye, unit: float) -> Triangles:
    """Return the edges between faces that look at the eye and others, and the sharp ones."""
    points, triangles = mesh
    normal, facing = _facing(mesh, eye)
    ends = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    face = np.repeat(np.arange(len(triangles)), 3)
    order = np.lexsort(ends.T)
    ends, face = ends[order], face[order]
    twin = np.flatnonzero((ends[1:] == ends[:-1]).all(axis=1))
    first, second = face[twin], face[twin + 1]
    seen = (facing[first] != facing[second]) | (np.einsum("ni,ni->n", normal[first], normal[second]) < 0.8)
    a, b, c = (points[triangles[:, i]] for i in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    sound = area > 0.05 * np.median(area)  # slivers, and triangles around a pole, have no sure normal
    seen &= sound[first] & sound[second]
    screen = eye.project(points)
    start, end = (screen[ends[twin[seen], side]] for side in (0, 1))
    return ribbons(start, end, 0.9 * unit, INK_TABLE)


def hides(mesh: Mesh, eye: Eye, body: np.ndarray) -> bool:
    """Tell whether faces that look at the eye stand before much of the body, of which points [k, 3] are given."""
    points, triangles = mesh
    corner = eye.project(points)[triangles[_facing(mesh, eye)[1]]]
    corner = corner[np.isfinite(corner).all(axis=(1, 2))]
    samples = eye.project(body[:: max(1, len(body) // 60)])
    covered = 0
    for sample in samples:
        to = corner[:, :, :2] - sample[:2]
        turn = [to[:, i, 0] * to[:, (i + 1) % 3, 1] - to[:, i, 1] * to[:, (i + 1) % 3, 0] for i in range(3)]
        within = np.abs(np.sign(turn).sum(axis=0)) == 3
        covered += bool((corner[within, :, 2].min(axis=1) > sample[2]).any())
    return covered > 0.15 * len(samples)


def _facing(mesh: Mesh, eye: Eye) -> tuple[np.ndarray, np.ndarray]:
    """Return unit normals [m, 3] and whether the faces look at the eye."""
    a, b, c = (mesh[0][mesh[1][:, i]] for i in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1).clip(1e-300)[:, None]
    return normal, np.einsum("ni,ni->n", normal, eye.position - a) > 0.0


def _strip(points: np.ndarray, turned: bool) -> Mesh:
    """Return the triangles of a sheet of points [p, q, 3]."""
    ids = np.arange(points.shape[0] * points.shape[1]).reshape(points.shape[:2])
    quads = np.stack([ids[:-1, :-1], ids[1:, :-1], ids[1:, 1:], ids[:-1, 1:]], axis=-1).reshape(-1, 4)
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    return points.reshape(-1, 3), triangles[:, ::-1] if turned else triangles


def _axes(third: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    first = np.eye(3)[np.argmin(np.abs(third))]
    first = first - third * (first @ third)
    first /= np.linalg.norm(first)
    return first, np.cross(third, first)


def _sphere(middle: np.ndarray, radius: float, side: float, centre: np.ndarray, seen: float) -> Mesh:
    """Return the whole ball, or of a large one the cap towards `centre`."""
    away = centre - middle
    length = np.linalg.norm(away)
    pole = away / length if length > 0 else np.array([0.0, 0.0, 1.0])
    first, second = _axes(pole)
    widest = np.pi if REACH * seen > radius else 2.0 * np.arcsin(REACH * seen / radius / 2.0)
    polar, turn = np.meshgrid(np.linspace(0, widest, FINE + 1), np.linspace(0, 2 * np.pi, 2 * FINE + 1), indexing="ij")
    around = np.cos(turn)[..., None] * first + np.sin(turn)[..., None] * second
    outward = np.cos(polar)[..., None] * pole + np.sin(polar)[..., None] * around
    return _strip(middle + radius * outward, side < 0)


def _cylinder(point: np.ndarray, axis: np.ndarray, radius: float, side: float, centre: np.ndarray, seen: float) -> Mesh:
    """Return the part of the cylinder beside `centre`: all around, or of a large one the part towards it."""
    foot = point + axis * (axis @ (centre - point))
    away = centre - foot
    length = np.linalg.norm(away)
    first = away / length if length > 1e-9 * radius else _axes(axis)[0]
    second = np.cross(axis, first)
    widest = np.pi if REACH * seen > radius else 2.0 * np.arcsin(REACH * seen / radius / 2.0)
    along, turn = np.meshgrid(
        np.linspace(-REACH * seen, REACH * seen, FINE + 1), np.linspace(-widest, widest, 2 * FINE + 1), indexing="ij"
    )
    outward = np.cos(turn)[..., None] * first + np.sin(turn)[..., None] * second
    return _strip(foot + along[..., None] * axis + radius * outward, side > 0)


def _box(half: tuple[float, ...]) -> Mesh:
    """Return six faces in small pieces: the raster drops triangles that reach far out of the picture."""
    line = np.linspace(-1.0, 1.0, FINE + 1)
    a, b = np.meshgrid(line, line, indexing="ij")
    points: list[np.ndarray] = []
    triangles: list[np.ndarray] = []
    for axis in range(3):
        for side in (-1.0, 1.0):
            face = np.empty((*a.shape, 3))
            face[..., axis], face[..., (axis + 1) % 3], face[..., (axis + 2) % 3] = side, a, b
            sheet, cells = _strip(face, side < 0)
            triangles.append(cells + len(sheet) * len(points))
            points.append(sheet)
    kept, number = np.unique(np.round(np.concatenate(points), 9), axis=0, return_inverse=True)
    return kept * np.array(half[:3]), number.reshape(-1)[np.concatenate(triangles)]
