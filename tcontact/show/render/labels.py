"""Labels of a picture: title, time, colour bar, axis names; round numbers."""

from __future__ import annotations

import math
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

import numpy as np

from ...base.window_backend import import_matplotlib
from ...results.files.vtkhdf import ResultData
from .bodies import legend
from .camera import Eye
from .colours import AXIS_COLOURS, BACKGROUND, FAINT_TEXT, FIELDS, TEXT, colour_table

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
    note: str,
    colours: str,
) -> None:
    """Write title, colour bar, or the names of the bodies by their colours, scale bar and axis names into the picture.

    They are the same in all pictures of a series; `write_figures` adds the others.
    """
    from PIL import ImageDraw

    draw, u, height = ImageDraw.Draw(picture), studio.unit, studio.size[1]
    name, unit, _ = FIELDS.get(field, (field.replace("_", " ").capitalize(), "", ""))
    title, small, text = font(round(21 * u), bold=True), font(round(13 * u)), font(round(15 * u))
    draw.text((26 * u, 20 * u), name, TEXT, title)
    enlarged = "" if studio.scale == 1.0 else f"deformation × {studio.scale:g}"
    below = ", ".join(part for part in (studio.title, note, enlarged) if part)
    draw.text((26 * u, 48 * u), below, FAINT_TEXT, small)
    if field == "body":
        legend(draw, studio.names, colour_table(colours), limits, studio.size, u, text)
    else:
        _colour_bar(picture, studio, limits, unit, colours)
    if eye.distance > 0.0:
        _scale_bar(picture, studio, eye)
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


def _scale_bar(picture: Image.Image, studio: Sheet, eye: Eye) -> None:
    """Draw a bar of a round length at the lower left, as long as that length is at the middle of the bodies."""
    from PIL import ImageDraw

    draw, u, height = ImageDraw.Draw(picture), studio.unit, studio.size[1]
    most = 150 * u * eye.distance / eye.focal  # metres that 150 pixels of a usual picture show
    if not 1e-300 < most < 1e300:  # a deformation enlarged beyond all lengths
        return
    power = 10.0 ** math.floor(math.log10(most))
    length = max(step for step in (1, 2, 5) if step * power <= most * (1 + 1e-9)) * power
    left, right, y = 122 * u, 122 * u + length * eye.focal / eye.distance, height - 36 * u
    line = max(1, round(1.6 * u))
    draw.line((left, y, right, y), FAINT_TEXT, line)
    for end in (left, right):
        draw.line((end, y - 4 * u, end, y + 4 * u), FAINT_TEXT, line)
    factor, prefix = prefix_of(length)
    place, text = ((left + right) / 2, y - 8 * u), f"{length / factor:.3g} {prefix}m"
    draw.text(place, text, TEXT, font(round(13 * u)), "ms", stroke_width=round(2 * u), stroke_fill=BACKGROUND)


def _colour_bar(picture: Image.Image, studio: Sheet, limits: tuple[float, float], unit: str, colours: str) -> None:
    """Draw the colour bar with its marks at the right of the picture."""
    from PIL import Image, ImageDraw

    draw, u = ImageDraw.Draw(picture), studio.unit
    text = font(round(15 * u))
    low, high = limits
    factor, prefix = _scale_of(limits, unit)
    x, y, w, h = _bar(studio)
    strip = colour_table(colours)[::-1].astype(np.uint8)[np.arange(h) * 256 // h]
    picture.paste(Image.fromarray(np.repeat(strip[:, None], w, axis=1)), (x, y))
    draw.rectangle((x - 1, y - 1, x + w, y + h), outline=FAINT_TEXT)
    draw.text((x, y - 12 * u), f"{prefix}{unit}", TEXT, text, anchor="ls")
    marks = ticks(low / factor, high / factor)
    places = _places_of(marks)
    for tick in marks:
        row = y + (h - 1) * (1 - (tick * factor - low) / (high - low))
        draw.line((x + w, row, x + w + 4 * u, row), FAINT_TEXT, max(1, round(u)))
        draw.text((x + w + 9 * u, row), f"{tick:.{places}f}".replace("-", "\N{MINUS SIGN}"), TEXT, text, anchor="lm")


def _scale_of(limits: tuple[float, float], unit: str) -> tuple[float, str]:
    """Return a factor and its name for the marks of a colour bar; a power of ten where prefixes are too large."""
    largest = max(abs(limits[0]), abs(limits[1]))
    if unit and not 0.0 < largest < 1e-12:
        return prefix_of(largest)
    factor, name = _power_of(largest)
    return factor, f"{name} " if unit else name


def _power_of(largest: float) -> tuple[float, str]:
    """Return a factor and its name for the marks of a number without a unit; 1 and no name from a thousandth on."""
    if not 0.0 < largest < 1e-3:
        return 1.0, ""
    power = max(-300, 3 * math.floor(math.log10(largest) / 3))
    return 10.0**power, f"1e\N{MINUS SIGN}{-power}"


def _places_of(marks: np.ndarray) -> int:
    """Return the decimal places that tell marks of equal distance apart, to a hundredth of that."""
    apart = abs(marks[1] - marks[0]) if len(marks) > 1 else 1.0
    for places in range(15):
        if all(abs(round(mark, places) - mark) <= 0.01 * apart for mark in marks):
            return places
    return 15


def write_figures(
    image: np.ndarray, studio: Sheet, field: str, limits: tuple[float, float], time: float, peak: float
) -> None:
    """Write time and largest value into a picture [height, width, 3]."""
    u, times = studio.unit, studio.data.times
    last = float(np.abs(times).max()) or 1.0
    step = float(np.median(np.diff(times))) if len(times) > 1 else last
    factor, prefix = prefix_of(last)
    digits = min(6, max(0, math.ceil(-math.log10(max(step, 1e-6 * last) / factor) + 0.3)))
    place = studio.size[0] - 26 * u, 21 * u
    stamp(image, place, f"t = {time / factor:.{digits}f} {prefix}s", TEXT, font(round(17 * u)), "ra")
    if field != "body" and math.isfinite(peak):
        unit = FIELDS.get(field, ("", "", ""))[1]
        factor = _scale_of(limits, unit)[0] if unit else 1.0
        x, y, _, h = _bar(studio)
        stamp(image, (x, y + h + 12 * u), f"max {peak / factor:.3g}", FAINT_TEXT, font(round(13 * u)), "la")


def stamp(
    image: np.ndarray,
    place: tuple[float, float],
    text: str,
    colour: tuple[int, int, int],
    font: ImageFont.FreeTypeFont,
    anchor: str,
) -> None:
    """Write a text into a picture [height, width, 3], of which only the part below the text is touched."""
    from PIL import Image, ImageDraw

    box = ImageDraw.Draw(Image.new("RGB", (1, 1))).textbbox(place, text, font, anchor)
    left, top = (max(0, math.floor(value) - 1) for value in box[:2])
    below = image[top : max(top, math.ceil(box[3]) + 1), left : max(left, math.ceil(box[2]) + 1)]
    if below.size:
        part = Image.fromarray(below)
        ImageDraw.Draw(part).text((place[0] - left, place[1] - top), text, colour, font, anchor)
        below[:] = np.asarray(part)


def _bar(studio: Sheet) -> tuple[int, int, int, int]:
    """Return left, top, width and height of the colour bar [pixel]."""
    u, (width, height) = studio.unit, studio.size
    x, y, w, h = (round(v * u) for v in (width / u - 104, 120, 18, height / u - 220))
    return x, y, w, h


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
    import_matplotlib()
    import matplotlib
    from PIL import ImageFont

    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    return ImageFont.truetype(str(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / name), size)
