"""The pictures of a run for its page."""

from __future__ import annotations

import base64
import io
from pathlib import Path

import numpy as np

from ..render.studio import Studio

WIDTH = 720  # pixels
QUALITY = 82  # of JPEG


def pictures_of(studio: Studio, frames: list[int], folder: Path) -> list[str]:
    """Return a picture of each frame as base64 of JPEG: those in the folder of the run, or they are drawn."""
    from PIL import Image

    known = sorted((folder / "frames").glob("frame-[0-9]*.png"))
    if len(known) == len(studio.data):
        return [_coded(Image.open(known[index])) for index in frames]
    drawer = Studio(studio.data, (WIDTH, 3 * WIDTH // 4), 1.0, None)
    field = "von_mises" if "von_mises" in studio.data.cell_fields else studio.data.point_fields[0]
    limits, eye = drawer.limits(field), drawer.camera("above")
    return [_coded(Image.fromarray(np.asarray(drawer.pixels(drawer.frame(i), field, limits, eye)))) for i in frames]


def _coded(picture: object) -> str:
    from PIL import Image

    assert isinstance(picture, Image.Image)
    small = picture.convert("RGB")
    small.thumbnail((WIDTH, WIDTH))
    file = io.BytesIO()
    small.save(file, "JPEG", quality=QUALITY)
    return base64.b64encode(file.getvalue()).decode("ascii")
