"""Animations: pictures joined to a looping GIF with one palette, or to an MP4."""

from __future__ import annotations

import errno
import io
import struct
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...base.warning_kinds import warn
from ...device.atomic_file import replaced
from .colours import FIELD, INK_TABLE, OTHER_PLANES, SHADOWED, tables

if TYPE_CHECKING:
    from PIL import Image

IMAGE = 0x2C  # the byte that starts an image in a GIF
BOX, LONG = struct.Struct(">I4s"), struct.Struct(">Q")  # of an MP4
CUT = "no room for the whole film, or its program failed"


def animate(pictures: Iterable[np.ndarray], palette: Image.Image, path: Path, fps: float) -> Path:
    """Join pictures [h,w,3] to a looping GIF with one palette for all; they are taken one by one."""
    from PIL import Image

    hundredths = max(2, round(100 / fps))
    with replaced(path, synced=False) as part, part.open("wb") as file:
        before: np.ndarray | None = None
        for picture in pictures:
            flat = Image.fromarray(picture).quantize(palette=palette, dither=Image.Dither.NONE)
            numbers = np.asarray(flat)
            if before is None:
                file.write(gif_head(flat.size, bytes(palette.getpalette() or [])))
                before = 256 + np.zeros_like(numbers, np.int16)  # other than all colours
            top, bottom, left, right = changed(before, numbers)
            file.write(gif_frame(flat.crop((left, top, right, bottom)), left, top, hundredths))
            before = numbers
        file.write(b";")
    return path


def changed(one: np.ndarray, other: np.ndarray) -> tuple[int, int, int, int]:
    """Return the rows and columns (first, end; first, end) of the box in which two pictures differ; never empty."""
    differs = one != other
    rows, columns = np.flatnonzero(differs.any(axis=1)), np.flatnonzero(differs.any(axis=0))
    if len(rows) == 0:
        return 0, 1, 0, 1
    return int(rows[0]), int(rows[-1]) + 1, int(columns[0]), int(columns[-1]) + 1


def gif_head(size: tuple[int, int], colours: bytes) -> bytes:
    """Return the head of a GIF that is shown again and again, with 256 colours for all frames.

    Format: https://www.w3.org/Graphics/GIF/spec-gif89a.txt
    """
    screen = struct.pack("<HHBBB", *size, 0b11110111, 0, 0)  # a table of 256 colours of 8 bits
    return b"GIF89a" + screen + colours.ljust(768, b"\0") + b"!\xff\x0bNETSCAPE2.0\x03\x01\0\0\0"


def gif_frame(part: Image.Image, left: int, top: int, hundredths: int) -> bytes:
    """Return a frame that replaces a part of what is seen and stays for some hundredths of a second."""
    alone = io.BytesIO()
    part.save(alone, "GIF", optimize=False, interlace=False)
    data = alone.getvalue()
    start = 13 + 3 * 2 ** ((data[10] & 7) + 1)  # behind the head and its colours
    while data[start] != IMAGE:  # extensions: a number, then blocks until an empty one
        start += 2
        while data[start]:
            start += 1 + data[start]
        start += 1
    control = b"!\xf9\x04" + struct.pack("<BHBB", 1 << 2, hundredths, 0, 0)  # the frame stays when its time is over
    place = struct.pack("<BHHHHB", IMAGE, left, top, *part.size, 0)
    return control + place + data[start + len(place) : -1]


def why_no_film() -> str:
    """Return why there is no MP4 and what helps, "" where the package imageio-ffmpeg is installed and works."""
    install = "pip install imageio-ffmpeg"
    if find_spec("imageio_ffmpeg") is None:
        return f"needs the package imageio-ffmpeg: {install}"
    try:
        import imageio_ffmpeg

        imageio_ffmpeg.get_ffmpeg_version()
    except Exception as error:
        said = str(error) or type(error).__name__
        return f"the package imageio-ffmpeg does not work ({said}); mend it: {install} --force-reinstall"
    return ""


def can_film() -> bool:
    """Tell whether an MP4 can be made; where imageio-ffmpeg is installed and does not work, warn."""
    why = why_no_film()
    if why and find_spec("imageio_ffmpeg") is not None:
        warn(f"there is no animation.mp4: {why}", RuntimeWarning)
    return not why


@contextmanager
def film(path: Path, fps: float, size: tuple[int, int]) -> Iterator[Callable[[np.ndarray], None]]:
    """Yield a function that adds a picture [h,w,3] (of `size` [pixel]) to an MP4 (H.264) with all its colours.

    It takes an imageio-ffmpeg that works, see `why_no_film`. Raises `OSError` if the film does not become whole.
    """
    import imageio_ffmpeg

    width, height = size[0] // 2 * 2, size[1] // 2 * 2  # H.264 halves the colours in both directions
    with replaced(path, synced=False) as part:
        writer = imageio_ffmpeg.write_frames(
            str(part),
            (width, height),
            fps=fps,
            codec="libx264",  # else every encoder that there may be is tried out
            quality=None,
            macro_block_size=2,
            ffmpeg_log_level="fatal",
            # As true to the pictures as veryfast at crf 10, in half the time and twice the room; one quality for all
            # frames saves a sixth against crf 13, which is as true and as long.
            output_params=["-preset", "ultrafast", "-qp", "9", "-threads", "1", "-f", "mp4"],
        )
        writer.send(None)

        def add(picture: np.ndarray) -> None:
            try:
                writer.send(np.ascontiguousarray(picture[:height, :width]))
            except OSError as error:  # the program has ended; the text is its whole command line
                raise OSError(errno.EIO, CUT) from error

        try:
            yield add
        finally:
            writer.close()
        if not is_whole_film(part):  # the program does not tell of a full disk
            raise OSError(errno.EIO, CUT)


def is_whole_film(path: Path) -> bool:
    """Tell whether the boxes of an MP4 fill the file and the last one is its index, which is written at the end.

    Format: ISO/IEC 14496-12, 4.2: a box begins with its size and its name; size 1: 8 bytes behind the name have it.
    """
    try:
        with path.open("rb") as file:
            end, at, name = file.seek(0, io.SEEK_END), 0, b""
            while at < end:
                file.seek(at)
                size, name = BOX.unpack(file.read(BOX.size))
                size = LONG.unpack(file.read(LONG.size))[0] if size == 1 else size
                if size < BOX.size:
                    return False
                at += size
    except (OSError, struct.error):
        return False
    return at == end and name == b"moov"


def common_palette(images: Sequence[np.ndarray], colours_of: str) -> Image.Image:
    """Return 256 colours for all images [h,w,3]: frequent ones and the scenery exactly, the rest by shades."""
    from PIL import Image

    colours = np.concatenate([image[::2, ::2].reshape(-1, 3) for image in images]).astype(np.int32)
    code, count = np.unique(colours[:, 0] << 16 | colours[:, 1] << 8 | colours[:, 2], return_counts=True)
    frequent = code[np.argsort(-count, kind="stable")[:16]]
    maps = tables(colours_of).reshape(-1, 256, 3).astype(np.int64)
    lit = [np.minimum(255, maps[FIELD, ::8] * percent // 100) for percent in (82, 92, 102)]
    fixed = np.concatenate([*lit, maps[FIELD, -1:], maps[INK_TABLE:OTHER_PLANES, 0], *maps[SHADOWED:, ::20]])
    exact = np.unique(np.concatenate([frequent, fixed @ (65536, 256, 1)]))
    coarse, count = np.unique(code & 0xFCFCFC, return_counts=True)
    weighed = np.repeat(coarse, np.minimum(8, count)) | 0x020202
    sample = np.stack([weighed >> 16, weighed >> 8 & 255, weighed & 255], axis=1).astype(np.uint8)
    mixed = Image.fromarray(sample[None]).quantize(colors=256 - len(exact), method=Image.Quantize.MEDIANCUT)
    table = [channel for c in exact for channel in (int(c) >> 16, int(c) >> 8 & 255, int(c) & 255)] + (
        mixed.getpalette() or []
    )
    palette = Image.new("P", (1, 1))
    palette.putpalette((table + [0] * 768)[:768])
    return palette
