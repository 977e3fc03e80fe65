"""Animations: pictures joined to a looping GIF with one palette, or to an MP4."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...base.errors import InputError
from ...device.atomic_file import unlinked
from .colours import FIELD, INK_TABLE, OTHER_PLANES, SHADOWED, tables

if TYPE_CHECKING:
    from PIL import Image


def animate(pictures: Iterable[Image.Image], palette: Image.Image, path: Path, fps: float) -> Path:
    """Join pictures to a looping GIF with one palette for all; they are taken one by one."""
    from PIL import Image

    frames = (picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in pictures)
    duration = max(20, round(100 / fps) * 10)  # GIF counts hundredths of a second
    shared = bytes(palette.getpalette() or [])  # named here, it is written once and not with every frame
    next(frames).save(
        unlinked(path),
        save_all=True,
        append_images=frames,
        duration=duration,
        loop=0,
        optimize=False,
        palette=shared,
    )
    return path


def can_film() -> bool:
    """Tell whether the package imageio-ffmpeg is installed."""
    return find_spec("imageio_ffmpeg") is not None


@contextmanager
def film(path: Path, fps: float, size: tuple[int, int]) -> Iterator[Callable[[Image.Image], None]]:
    """Yield a function that adds a picture (of `size` [pixel]) to an MP4 (H.264) with all its colours.

    Raises `InputError` without imageio-ffmpeg.
    """
    if not can_film():
        raise InputError("video", True, "needs the package imageio-ffmpeg: pip install imageio-ffmpeg")
    import imageio_ffmpeg

    width, height = size[0] // 2 * 2, size[1] // 2 * 2  # H.264 halves the colours in both directions
    writer = imageio_ffmpeg.write_frames(
        str(unlinked(path)),
        (width, height),
        fps=fps,
        quality=8,
        macro_block_size=2,
        ffmpeg_log_level="error",
        output_params=["-preset", "veryfast"],
    )
    writer.send(None)
    try:
        yield lambda picture: writer.send(np.ascontiguousarray(np.asarray(picture)[:height, :width]))
    finally:
        writer.close()


def common_palette(images: Sequence[np.ndarray], colours_of: str) -> Image.Image:
    """Return 256 colours for all images [h,w,3]: frequent ones and the scenery exactly, the rest by shades."""
    from PIL import Image

    colours = np.concatenate([image[::2, ::2].reshape(-1, 3) for image in images]).astype(np.int64)
    code, count = np.unique(colours @ (65536, 256, 1), return_counts=True)
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
