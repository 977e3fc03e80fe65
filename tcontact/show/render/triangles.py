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

    def front_first(self, cull: bool = False) -> Triangles:
        """Return the triangles with those first whose corners run clockwise on the screen; cull: these alone.

        Faces of a body that look at the eye run so and hide the others, of which then nothing has to be shaded. The
        surface of a body is closed: where one of the others is, there is also one of these.
        """
        one, two = (self.screen[:, k, :2] - self.screen[:, 0, :2] for k in (1, 2))
        back = ~(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0] < 0.0)
        order = np.flatnonzero(~back) if cull else np.argsort(back, kind="stable")
        names = ("screen", "value", "light", "table", "edges", "ink")
        return Triangles(*(getattr(self, name)[order] for name in names))

    @staticmethod
    def joined(parts: Sequence[Triangles]) -> Triangles:
        names = ("screen", "value", "light", "table", "edges", "ink")
        return Triangles(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))


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


def draw(
    scene: Triangles,
    width: int,
    place: Place,
    factor: int,
    line: float,
    colours: np.ndarray,
    behind: np.ndarray,
    depth: np.ndarray,
    pixel: np.ndarray,
) -> None:
    """Draw triangles into a place of the buffers, which then hold nothing else.

    width: of the buffers, place in them [sample]; factor: samples per pixel along one axis, line: half width of a line
    [pixel]; behind: inverse depth of what hides triangles.
    """
    from ...kernels.pictures import raster

    screen = scene.screen * (factor, factor, 1.0)
    good = drawable(screen)
    grid = np.round(screen[good, :, :2] * 256) / 256
    y = grid[..., 1]
    rows = np.stack([np.ceil(y.min(axis=1) - 0.5), np.floor(y.max(axis=1) - 0.5) + 1.0], axis=1)
    raster.draw_triangles(
        len(grid),
        width,
        *(int(end) for part in place for end in (part.start, part.stop)),
        line * factor,
        rows.astype(np.int32).ravel(),
        np.ascontiguousarray(grid[..., 0]).ravel(),
        np.ascontiguousarray(y).ravel(),
        np.ascontiguousarray(screen[good, :, 2]).ravel(),
        scene.value[good].ravel(),
        scene.light[good],
        scene.table[good].astype(np.int32),
        scene.edges[good].astype(np.int32),
        scene.ink[good],
        colours,
        behind,
        depth,
        pixel,
    )
