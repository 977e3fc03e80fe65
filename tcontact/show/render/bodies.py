"""Bodies in a picture: their names and colours, a legend, and names written on what is seen of each body."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...results.files.vtkhdf import ResultData
from .colours import BACKGROUND, BODY_COLOURS, FAINT_TEXT, TEXT

if TYPE_CHECKING:
    from PIL import ImageDraw, ImageFont

CELL = 4  # pixels from one place to the next that a name may have
ROOM = 0.4  # share of the picture's width that a legend may take


def names_of(data: ResultData) -> list[str]:
    """Return the names of the bodies of a result file in its order; [] where it has one body only."""
    if "body" not in data.cell_fields or not len(data):
        return []
    count = int(data.frame(0).cell_data["body"].max()) + 1
    known = data.attributes.get("bodies")
    known = known if isinstance(known, (list, tuple)) else ()
    return [str(known[number]) if number < len(known) else f"body-{number}" for number in range(count)]


def legend(
    draw: ImageDraw.ImageDraw,
    names: list[str],
    colours: np.ndarray,
    limits: tuple[float, float],
    size: tuple[int, int],
    unit: float,
    font: ImageFont.FreeTypeFont,
) -> None:
    """Write the names of the bodies at the right of a picture, each beside its colour; what finds no room is counted.

    colours [256, 3]: the map of the picture; limits: the body numbers at its ends; size: of the picture [pixels].
    """
    width, height = size
    line = 26 * unit
    most = max(1, int((height - 180 * unit) / line))
    shown = names if len(names) <= most else names[: most - 1]
    texts = [_fitted(name, font, ROOM * width) for name in shown]
    if len(shown) < len(names):
        texts.append(f"and {len(names) - len(shown)} more")
    left = width - 26 * unit - max(font.getlength(text) for text in texts) - 24 * unit
    for row, text in enumerate(texts):
        y = 120 * unit + row * line
        if row < len(shown):
            level = (float(colour_number(np.array(row), limits)) - limits[0]) / (limits[1] - limits[0])
            colour = tuple(int(c) for c in colours[int(min(1.0, level) * 255 + 0.5)])
            draw.rectangle((left, y, left + 15 * unit, y + 15 * unit), fill=colour, outline=FAINT_TEXT)
        draw.text((left + 24 * unit, y + 7 * unit), text, TEXT, font, anchor="lm")


def colour_number(body: np.ndarray, limits: tuple[float, float]) -> np.ndarray:
    """Return the values by which bodies find their colours: after the last band of their own map the first follows."""
    return np.asarray(body % len(BODY_COLOURS) if limits == own_limits() else body, dtype=np.float64)


def own_limits() -> tuple[float, float]:
    """Return the body numbers at the ends of the map of bodies, in which each has a band."""
    return -0.5, len(BODY_COLOURS) - 0.5


def write_names(
    draw: ImageDraw.ImageDraw, names: list[str], seen: np.ndarray, unit: float, font: ImageFont.FreeTypeFont
) -> None:
    """Write the name of each body on what is seen of it; small parts stay free.

    seen [height, width]: number of the body at a pixel + 1, 0 where there is none.
    """
    coarse = seen[::CELL, ::CELL]
    for number, name in enumerate(names):
        wide, high = font.getlength(name) + 8 * unit, 24 * unit
        place = place_of(coarse == number + 1, wide / CELL, high / CELL)
        if place is not None:
            draw.text(
                (CELL * place[0], CELL * place[1]),
                name,
                TEXT,
                font,
                anchor="mm",
                stroke_width=max(1, round(2 * unit)),
                stroke_fill=BACKGROUND,
            )


def place_of(mask: np.ndarray, width: float, height: float) -> tuple[float, float] | None:
    """Return the column and row at which a box of this size lies on a mask, as near to its middle as possible.

    Where the box does not fit on it anywhere, its middle does; None where the mask is smaller than the box.
    """
    rows, columns = np.nonzero(mask)
    if len(rows) < width * height:
        return None
    # a little to the right of the middle: of two places as near, as on a ring, it is always the same one
    middle = np.array((columns.mean() + 0.05 * np.ptp(columns), rows.mean()))
    total = np.zeros((mask.shape[0] + 1, mask.shape[1] + 1), dtype=np.int64)
    total[1:, 1:] = np.cumsum(np.cumsum(mask, axis=0), axis=1)
    across, down = (max(1, round(float(length) / 2)) for length in (width, height))
    left, right = (np.clip(columns + step, 0, mask.shape[1]) for step in (-across, across + 1))
    top, bottom = (np.clip(rows + step, 0, mask.shape[0]) for step in (-down, down + 1))
    covered = total[bottom, right] - total[top, right] - total[bottom, left] + total[top, left]
    whole = covered == (2 * across + 1) * (2 * down + 1)
    points = np.stack([columns, rows], axis=1)[whole if whole.any() else slice(None)]
    best = points[np.argmin(((points - middle) ** 2).sum(axis=1))]
    return float(best[0]), float(best[1])


def _fitted(name: str, font: ImageFont.FreeTypeFont, room: float) -> str:
    """Return a name, cut where it is longer than the room [pixels]."""
    if font.getlength(name) <= room:
        return name
    length = next(n for n in range(len(name), -1, -1) if font.getlength(name[:n] + "…") <= room or n == 0)
    return name[:length] + "…"
