"""The names of obstacles in a picture: a place on what is seen of each, where the whole name is written or nothing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .bodies import CELL, place_of
from .camera import Signs
from .colours import BACKGROUND, FAINT_TEXT
from .triangles import window

if TYPE_CHECKING:
    from PIL import ImageDraw, ImageFont


@dataclass(frozen=True)
class Sign:
    """A name with the pixel (column, row) of its middle, and half its width and height [pixel]."""

    name: str
    middle: tuple[float, float]
    half: tuple[float, float]

    def hidden(self, front: np.ndarray, samples: int) -> bool:
        """Return whether bodies are before a part of it; front [samples height, samples width]: 0 where none is."""
        (left, top), (right, bottom) = (
            [max(0, round(samples * (at + side * half))) for at, half in zip(self.middle, self.half, strict=True)]
            for side in (-1, 1)
        )
        return bool(front[top:bottom, left:right].any())


def placed_signs(signs: Signs, mask: np.ndarray, unit: float, font: ImageFont.FreeTypeFont) -> list[Sign]:
    """Return the names of the obstacles on what is seen of each beside the bodies; without a place there is no name.

    mask [height, width]: number of the obstacle at a pixel + 1, 0 where there is none.
    """
    found, seen, (height, width) = [], mask[::CELL, ::CELL].copy(), mask.shape
    for strip in (
        np.s_[: round(74 * unit / CELL)],
        np.s_[-round(46 * unit / CELL) :],
        np.s_[:, -round(122 * unit / CELL) :],
    ):
        seen[strip] = 0  # the other labels stand there
    free = seen.copy()
    rows, columns = window([signs.bodies], [0], width, height)
    free[rows.start // CELL : -(-rows.stop // CELL), columns.start // CELL : -(-columns.stop // CELL)] = 0
    for number, name in enumerate(signs.names):
        if not name:
            continue
        wide, high = font.getlength(name) + 10 * unit, 22 * unit
        size = wide / CELL, high / CELL
        place = place_of(free == number + 1, *size) or place_of(seen == number + 1, *size)
        if place is not None:
            found.append(Sign(name, (CELL * place[0], CELL * place[1]), (0.5 * wide, 0.5 * high)))
    return found


def write_signs(draw: ImageDraw.ImageDraw, signs: Sequence[Sign], unit: float, font: ImageFont.FreeTypeFont) -> None:
    """Write names of obstacles into a picture."""
    around = max(1, round(2 * unit))
    for sign in signs:
        draw.text(sign.middle, sign.name, FAINT_TEXT, font, "mm", stroke_width=around, stroke_fill=BACKGROUND)
