"""Flat obstacles: they are read, and drawn as a chequered disc or an outline."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...base.errors import InputError
from .camera import Eye
from .colours import INK_TABLE, OTHER_PLANES, SHADOWED
from .solids import Pose
from .triangles import Triangles, ribbons

TILES = 14  # tiles along a diameter


def read_planes(obstacles: Sequence[Mapping[str, Any]]) -> list[tuple[np.ndarray, np.ndarray]]:
    planes = []
    for index, obstacle in enumerate(obstacles):
        if obstacle.get("kind") != "plane":
            continue
        point, normal = (np.array(obstacle.get(key, ()), dtype=np.float64) for key in ("point", "normal"))
        if point.shape != (3,) or normal.shape != (3,) or not np.isfinite([point, normal]).all() or not normal.any():
            raise InputError(
                f"obstacles[{index}]", dict(obstacle), "give a finite point [3] and a normal [3] that is not zero"
            )
        planes.append((point, normal / np.linalg.norm(normal)))
    return planes


@dataclass(frozen=True)
class Patch:
    """The part of a plane that is drawn: a disc of chequered tiles that fades into the background."""

    centre: np.ndarray
    first: np.ndarray
    second: np.ndarray
    radius: float
    shadowed: bool

    @staticmethod
    def under(points: np.ndarray, point: np.ndarray, normal: np.ndarray, shadowed: bool) -> Patch:
        first = np.eye(3)[np.argmin(np.abs(normal))]
        first = first - normal * (first @ normal)
        first /= np.linalg.norm(first)
        second = np.cross(normal, first)
        a, b = (points - point) @ first, (points - point) @ second
        centre = point + first * (a.min() + a.max()) / 2 + second * (b.min() + b.max()) / 2
        radius = max(0.95 * math.hypot(np.ptp(a), np.ptp(b)), 0.35 * np.ptp((points - point) @ normal))
        return Patch(centre, first, second, radius, shadowed)

    def carried(self, pose: Pose, time: float) -> Patch:
        """Return the disc moved with its plane, less whole pairs of tiles: it stays under the body."""
        start, axes = pose.at(0.0) if pose.moves else (pose.points[0], pose.frames[0])
        point, frame = pose.at(time)
        turn = axes.T @ frame  # rows of world vectors at t = 0 to those now
        first, second = self.first @ turn, self.second @ turn
        moved = point - start
        period = 4.0 * self.radius / TILES
        along = [(moved @ way) - period * round((moved @ way) / period) for way in (first, second)]
        normal = np.cross(first, second)
        centre = start + (self.centre - start) @ turn
        return replace(
            self,
            centre=centre + normal * (normal @ moved) + along[0] * first + along[1] * second,
            first=first,
            second=second,
        )

    def rim(self, part: float) -> np.ndarray:
        turn = np.radians(np.arange(0, 360, 15))
        return self.at(part * self.radius * np.cos(turn), part * self.radius * np.sin(turn))

    def at(self, a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return self.centre + np.multiply.outer(a, self.first) + np.multiply.outer(b, self.second)

    def tiles(self, eye: Eye) -> Triangles:
        count, parts = TILES, 3  # pieces of a tile, for a smooth fade
        line = np.linspace(-self.radius, self.radius, count * parts + 1)
        a, b = np.meshgrid(line, line, indexing="ij")
        screen = eye.project(self.at(a, b).reshape(-1, 3))
        fade = np.clip((np.hypot(a, b).ravel() / self.radius - 0.45) / 0.55, 0.0, 1.0)
        ids = np.arange(a.size).reshape(a.shape)
        quads = np.stack([ids[:-1, :-1], ids[1:, :-1], ids[1:, 1:], ids[:-1, 1:]], axis=-1)
        tile = np.arange(count * parts) // parts
        tone = ((tile[:, None] + tile[None, :]) % 2).ravel()
        quads = quads.reshape(-1, 4)
        inside = fade[quads].min(axis=1) < 1.0
        quads, tone = quads[inside], tone[inside]
        corners = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
        table = np.tile(tone, 2) + (SHADOWED if self.shadowed else OTHER_PLANES)
        return Triangles.plain(screen[corners], table, fade[corners])

    def outline(self, eye: Eye, unit: float) -> Triangles:
        side = 0.58 * self.radius
        square = self.at(np.array([-side, side, side, -side]), np.array([-side, -side, side, side]))
        line = eye.project(square)
        return ribbons(line, np.roll(line, -1, axis=0), 0.9 * unit, INK_TABLE)
