"""Every frame of a result as a picture, and what comes with them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..vtkhdf import ResultData
from .animation import animate
from .camera import Camera
from .studio import Studio


def render_frames(
    data: ResultData | Path | str,
    out: Path | str,
    field: str = "contact_pressure",
    size: tuple[int, int] = (960, 720),
    camera: Camera | None = None,
    deformation_scale: float = 1.0,
    obstacles: Sequence[Mapping[str, Any]] | None = None,
    fps: float | None = None,
    range: tuple[float, float] | None = None,
    view: str = "above",
    animation: bool = True,
    title: str | None = None,
) -> list[Path]:
    """Draw every frame of a result; returns the files written.

    `out`/frames/frame-0000.png ..., `out`/animation.gif, and, where bodies touched an obstacle, `out`/contact-face.png:
    the contact pressure seen from below at the instant of the largest contact force.

    field: any field of the file, vectors by their length, cell values one colour a face; size: picture [pixel]; camera:
    None = a three-quarter view of body and contact plane; deformation_scale: factor on displacements about each body's
    mean motion; obstacles: {"kind": "plane", "point": [3], "normal": [3]} each, None = those in the file's attributes;
    fps: frames per second of the animation, None = about six seconds in all; range: values at the two ends of the
    colours, None = those of the series, without the highest 1.5 %; view: "above" or "below" the first plane, which is
    then drawn as an outline; title: the second line, None = the attribute "title" of the file.
    Raises `InputError` for an unknown field (with those known), a file without frames and values out of place, before
    it writes.
    """
    data = data if isinstance(data, ResultData) else ResultData.open(data)
    if len(data) == 0:
        raise InputError("data", str(data.path), "the file holds no frames; run again with frames > 0")
    if not (len(size) == 2 and all(isinstance(n, (int, np.integer)) and 160 <= n <= 8192 for n in size)):
        raise InputError("size", size, "give width and height as whole numbers of pixels, 160 to 8192")
    if fps is not None and not (math.isfinite(fps) and fps > 0):
        raise InputError("fps", fps, "give a positive number of frames per second")
    if range is not None and not (len(range) == 2 and all(map(math.isfinite, range)) and range[0] < range[1]):
        raise InputError("range", range, "give two finite values, the lower one first")
    known = (*data.point_fields, *data.cell_fields)
    if field not in known:
        raise InputError("field", field, f"the file holds {', '.join(known)}")
    studio = Studio(data, size, deformation_scale, obstacles, title)
    limits = range or studio.limits(field)
    eye = studio.camera(view, camera)
    out = Path(out)
    folder = out / "frames"
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for index, _ in enumerate(data.times):
        path = folder / f"frame-{index:04d}.png"
        studio.picture(data.frame(index), field, limits, eye).save(path, compress_level=3)
        written.append(path)
    for stale in set(folder.glob("frame-[0-9]*.png")) - set(written):
        stale.unlink()  # of an earlier, longer series
    if animation:
        written.append(animate(written, out / "animation.gif", fps or min(25.0, max(4.0, len(data) / 6)), field))
    return written + studio.contact_face(out / "contact-face.png", limits if field == "contact_pressure" else None)
