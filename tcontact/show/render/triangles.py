"""Triangles on the screen, and lines made of them, as the raster takes them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .colours import AXES

Place = tuple[slice, slice]  # rows and columns of a picture [pixel]
FAR = 2e5  # pixels; farther outside the picture the products of the raster would lose their exactness


@dataclass(frozen=True)
class Triangles:
    """Input of the raster: screen [n,3,3] x, y, w of the corners; value [n,3]; light, table, edges, ink [n]."""

    screen: np.ndarray
    value: np.ndarray
    light: np.ndarray
    table: np.ndarray
    edges: np.ndarray
    ink: np.ndarray

    @staticmethod
    def plain(screen: np.ndarray, table: int | np.ndarray, value: np.ndarray | float = 0.0) -> Triangles:
        n = len(screen)
        zero = np.zeros(n, dtype=np.int32)
        value = np.broadcast_to(value, (n, 3))
        return Triangles(screen, value, np.ones(n), zero + np.int32(table), zero, np.zeros(n))

    @staticmethod
    def joined(parts: Sequence[Triangles]) -> Triangles:
        names = ("screen", "value", "light", "table", "edges", "ink")
        return Triangles(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))


def fronts(screen: np.ndarray, corners: np.ndarray, cull: bool = False) -> np.ndarray:
    """Return the numbers of triangles, those first whose corners run clockwise on the screen; cull: these alone.

    screen [k,3]: points on the screen; corners [n,3]: which of them each triangle has. Faces of a body that look at the
    eye run so and hide the others, of which then nothing has to be shaded. The surface of a body is closed: where one
    of the others is, there is also one of these.
    """
    x, y = (np.ascontiguousarray(screen[:, axis])[corners].T for axis in (0, 1))
    front = (x[1] - x[0]) * (y[2] - y[0]) - (y[1] - y[0]) * (x[2] - x[0]) < 0.0
    return np.flatnonzero(front) if cull else np.argsort(~front, kind="stable")


def ribbons(start: np.ndarray, end: np.ndarray, half: float, table: int | np.ndarray) -> Triangles:
    """Return lines [n,3] on the screen as two triangles each, `half` pixels to either side."""
    along = end[:, :2] - start[:, :2]
    aside = np.zeros_like(start)
    aside[:, :2] = (
        half * np.stack([-along[:, 1], along[:, 0]], axis=1) / np.linalg.norm(along, axis=1)[:, None].clip(1e-9)
    )
    screen = np.concatenate(
        [
            np.stack([start - aside, end - aside, end + aside], 1),
            np.stack([start - aside, end + aside, start + aside], 1),
        ]
    )
    return Triangles.plain(screen, np.tile(np.broadcast_to(table, len(start)), 2))


def triad(axes: np.ndarray, x: float, y: float, unit: float) -> Triangles:
    """Return the coordinate directions in the lower left corner."""
    end = np.array([[x, y, 0.0]]) + 30 * unit * axes.T * np.array([1.0, -1.0, 0.0])
    depth = 1e6 + axes.T[:, 2]  # in front of everything, nearer axes first
    start, end = np.stack([np.full(3, x), np.full(3, y), depth], 1), np.stack([*end.T[:2], depth], 1)
    return ribbons(start, end, 1.3 * unit, AXES + np.arange(3))


def window(parts: Sequence[np.ndarray], margins: Sequence[int], width: int, height: int) -> Place:
    """Return the rows and columns of the picture [pixel] that hold the parts, each with a margin around it.

    parts: points on the screen [k,3] each, corners of all that is drawn.
    """
    size = np.array([width, height])
    low, high = size, np.zeros(2, int)
    for points, margin in zip(parts, margins, strict=True):
        sound = points[np.isfinite(points).all(axis=1), :2].clip(-FAR, FAR)
        if len(sound):
            low = np.minimum(low, np.floor(sound.min(axis=0)).astype(int) - 1 - margin)
            high = np.maximum(high, np.ceil(sound.max(axis=0)).astype(int) + 1 + margin)
    low = low.clip(0, size)
    high = high.clip(low, size)
    return slice(low[1], high[1]), slice(low[0], high[0])


def union(one: Place, other: Place) -> Place:
    """Return the smallest place that holds two places; one without rows or columns counts for nothing."""
    filled = [place for place in (one, other) if all(part.start < part.stop for part in place)]
    if len(filled) < 2:
        return filled[0] if filled else one
    rows, columns = (
        slice(min(part.start for part in parts), max(part.stop for part in parts))
        for parts in zip(one, other, strict=True)
    )
    return rows, columns


def drawable(screen: np.ndarray) -> np.ndarray | slice:
    """Return which of the triangles [n,3,3] the raster can draw; slice(None) for all."""
    near = np.abs(screen[..., :2]) < FAR  # not so for nan
    if near.all() and np.isfinite(screen[..., 2]).all():
        return slice(None)
    return near.all(axis=(1, 2)) & np.isfinite(screen[..., 2]).all(axis=1)
