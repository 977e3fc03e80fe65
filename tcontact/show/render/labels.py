"""Labels of a picture: title, time, colour bar, axis names; round numbers."""

from __future__ import annotations

import math
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

import numpy as np

from ...results.files.vtkhdf import ResultData
from .bodies import legend
from .camera import Eye
from .colours import AXIS_COLOURS, FAINT_TEXT, FIELDS, TEXT, colour_table

if TYPE_CHECKING:
    from PIL import Image, ImageFont


class Sheet(Protocol):
    """A series of pictures as its labels see it: size [pixels], title, exaggeration of the deformation, frames."""

    unit: float
    size: tuple[int, int]
    title: str
    scale: float
    data: ResultData
    names: list[str]


def decorate(
    picture: Image.Image,
    studio: Sheet,
    eye: Eye,
    field: str,
    limits: tuple[float, float],
    time: float,
    peak: float,
    note: str,
    colours: str,
) -> None:
    """Write title, time, colour bar, or the names of the bodies by their colours, and axis names into the picture."""
    from PIL import ImageDraw

    draw, u, (width, height) = ImageDraw.Draw(picture), studio.unit, studio.size
    name, unit, _ = FIELDS.get(field, (field.replace("_", " ").capitalize(), "", ""))
    title, small, text = font(round(21 * u), bold=True), font(round(13 * u)), font(round(15 * u))
    draw.text((26 * u, 20 * u), name, TEXT, title)
    enlarged = "" if studio.scale == 1.0 else f"deformation × {studio.scale:g}"
    below = ", ".join(part for part in (studio.title, note, enlarged) if part)
    draw.text((26 * u, 48 * u), below, FAINT_TEXT, small)
    last = float(np.abs(studio.data.times).max()) or 1.0
    step = float(np.median(np.diff(studio.data.times))) if len(studio.data) > 1 else last
    factor, prefix = prefix_of(last)
    digits = min(6, max(0, math.ceil(-math.log10(max(step, 1e-6 * last) / factor) + 0.3)))
    draw.text(
        (width - 26 * u, 21 * u), f"t = {time / factor:.{digits}f} {prefix}s", TEXT, font(round(17 * u)), anchor="ra"
    )

    if field == "body":
        legend(draw, studio.names, colour_table(colours), limits, studio.size, u, text)
    else:
        _colour_bar(picture, studio, limits, unit, peak, colours)
    for axis, letter in enumerate("xyz"):
        right, upward = eye.axes[:2, axis]
        length = math.hypot(right, upward)
        if length > 0.15:
            reach = u * (30 + 12 / length)
            draw.text(
                (52 * u + reach * right, height - 52 * u - reach * upward),
                letter,
                AXIS_COLOURS[axis],
                small,
                anchor="mm",
            )


def _colour_bar(
    picture: Image.Image, studio: Sheet, limits: tuple[float, float], unit: str, peak: float, colours: str
) -> None:
    """Draw the colour bar with its marks at the right of the picture."""
    from PIL import Image, ImageDraw

    draw, u, (width, height) = ImageDraw.Draw(picture), studio.unit, studio.size
    small, text = font(round(13 * u)), font(round(15 * u))
    low, high = limits
    factor, prefix = prefix_of(max(abs(low), abs(high))) if unit else (1.0, "")
    x, y, w, h = (round(v * u) for v in (width / u - 104, 120, 18, height / u - 220))
    strip = colour_table(colours)[::-1].astype(np.uint8)[np.arange(h) * 256 // h]
    picture.paste(Image.fromarray(np.repeat(strip[:, None], w, axis=1)), (x, y))
    draw.rectangle((x - 1, y - 1, x + w, y + h), outline=FAINT_TEXT)
    draw.text((x, y - 12 * u), f"{prefix}{unit}", TEXT, text, anchor="ls")
    marks = ticks(low / factor, high / factor)
    places = max(0, *(len(f"{tick:.6g}".partition(".")[2]) for tick in marks))
    for tick in marks:
        row = y + (h - 1) * (1 - (tick * factor - low) / (high - low))
        draw.line((x + w, row, x + w + 4 * u, row), FAINT_TEXT, max(1, round(u)))
        draw.text((x + w + 9 * u, row), f"{tick:.{places}f}".replace("-", "\N{MINUS SIGN}"), TEXT, text, anchor="lm")
    if math.isfinite(peak):
        draw.text((x, y + h + 12 * u), f"max {peak / factor:.3g}", FAINT_TEXT, small, anchor="la")


def ticks(low: float, high: float) -> np.ndarray:
    """Return round numbers in [low, high], four to seven of them."""
    rough = (high - low) / 5
    power = 10.0 ** math.floor(math.log10(rough))
    step = min((s * power for s in (1, 2, 2.5, 5, 10)), key=lambda s: abs(s - rough))
    return np.arange(math.ceil(low / step - 1e-6), math.floor(high / step + 1e-6) + 1) * step


def round_up(value: float) -> float:
    """Return the next number with a simple first figure; 1 for nothing."""
    if not value > 0:
        return 1.0
    power = 10.0 ** math.floor(math.log10(value))
    return next(step for step in (1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10) if step * power >= value * (1 - 1e-9)) * power


def round_down(value: float) -> float:
    """Return a number of two figures not above this one."""
    step = 10.0 ** (math.floor(math.log10(value)) - 1) if value > 0 else 1.0
    return math.floor(value / step * (1 + 1e-9)) * step


def prefix_of(value: float) -> tuple[float, str]:
    power = min(4, max(-3, math.floor(math.log10(abs(value)) / 3 + 1e-9))) if value else 0
    return 1000.0**power, {-3: "n", -2: "µ", -1: "m", 0: "", 1: "k", 2: "M", 3: "G", 4: "T"}[power]


@cache
def font(size: int, bold: bool = False) -> ImageFont.FreeTypeFont:
    import matplotlib
    from PIL import ImageFont

    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    return ImageFont.truetype(str(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / name), size)
