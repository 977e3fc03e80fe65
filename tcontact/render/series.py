"""Every frame of a result as a picture, and what comes with them; or one picture at a time."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..vtkhdf import ResultData
from .animation import animate, can_film, film
from .camera import Camera
from .colours import colour_map
from .studio import Studio
from .surface import Clip


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
    colours: str | None = None,
    clip: Sequence[Clip] = (),
    video: bool | None = None,
) -> list[Path]:
    """Draw every frame of a result; returns the files written.

    `out`/frames/frame-0000.png ..., animation.gif, animation.mp4 (see video) and, where bodies touched an obstacle,
    contact-face.png: the contact pressure seen from below at the instant of the largest contact force.

    field: any field of the file, vectors by their length, cell values one colour a face; size: picture [pixel]; camera:
    None = a three-quarter view of body and contact plane; deformation_scale: factor on displacements about each body's
    mean motion; obstacles: {"kind": "plane", "point": [3], "normal": [3]} each, None = those in the file's attributes;
    fps: frames per second of the animation, None = about six seconds in all; range: values at the two ends of the
    colours, None = those of the series, without the highest 1.5 %; view: "above" or "below" the first plane, which is
    then drawn as an outline; title: the second line, None = the attribute "title" of the file; colours: a colour map of
    matplotlib, None = that of the field; clip: planes that cut the bodies open; video: an MP4 beside the GIF, None =
    where imageio-ffmpeg is installed.
    Raises `InputError` for an unknown field (with those known), a file without frames and values out of place, before
    it writes.
    """
    data = data if isinstance(data, ResultData) else ResultData.open(data)
    if fps is not None and not (math.isfinite(fps) and fps > 0):
        raise InputError("fps", fps, "give a positive number of frames per second")
    if video and not can_film():
        raise InputError("video", video, "needs the package imageio-ffmpeg: pip install imageio-ffmpeg")
    studio, limits = _opened(data, field, size, deformation_scale, obstacles, range, title, clip, colours)
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
        speed, pictures = fps or min(25.0, max(4.0, len(data) / 6)), list(written)
        written.append(animate(pictures, out / "animation.gif", speed, colour_map(field, colours)))
        if can_film() if video is None else video:
            written.append(film(pictures, out / "animation.mp4", speed))
    if clip:
        return written  # an opened body has no whole contact face
    return written + studio.contact_face(out / "contact-face.png", limits if field == "contact_pressure" else None)


def render_picture(
    data: ResultData | Path | str,
    path: Path | str,
    time: float | None = None,
    field: str = "contact_pressure",
    size: tuple[int, int] = (960, 720),
    camera: Camera | None = None,
    deformation_scale: float = 1.0,
    obstacles: Sequence[Mapping[str, Any]] | None = None,
    range: tuple[float, float] | None = None,
    view: str = "above",
    title: str | None = None,
    colours: str | None = None,
    clip: Sequence[Clip] = (),
) -> Path:
    """Draw the frame nearest to a time [s], None = the last one, into the file `path`; returns it.

    Colours and camera are those of the whole series, so that pictures of several times can be compared; the other
    options are those of `render_frames`.
    """
    data = data if isinstance(data, ResultData) else ResultData.open(data)
    if time is not None and not math.isfinite(time):
        raise InputError("time", time, "give a time in seconds, or None for the last frame")
    studio, limits = _opened(data, field, size, deformation_scale, obstacles, range, title, clip, colours)
    eye = studio.camera(view, camera)
    index = len(data) - 1 if time is None else int(np.argmin(np.abs(data.times - time)))
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    studio.picture(data.frame(index), field, limits, eye).save(path)
    return path


def _opened(
    data: ResultData,
    field: str,
    size: tuple[int, int],
    deformation_scale: float,
    obstacles: Sequence[Mapping[str, Any]] | None,
    range: tuple[float, float] | None,
    title: str | None,
    clip: Sequence[Clip],
    colours: str | None,
) -> tuple[Studio, tuple[float, float]]:
    """A studio for these wishes and the ends of the colours. Raises `InputError` for those that cannot be met."""
    if len(data) == 0:
        raise InputError("data", str(data.path), "the file holds no frames; run again with frames > 0")
    if not (len(size) == 2 and all(isinstance(n, (int, np.integer)) and 160 <= n <= 8192 for n in size)):
        raise InputError("size", size, "give width and height as whole numbers of pixels, 160 to 8192")
    if range is not None and not (len(range) == 2 and all(map(math.isfinite, range)) and range[0] < range[1]):
        raise InputError("range", range, "give two finite values, the lower one first")
    known = (*data.point_fields, *data.cell_fields)
    if field not in known:
        raise InputError("field", field, f"the file holds {', '.join(known)}")
    if not all(isinstance(one, Clip) for one in clip):
        raise InputError("clip", clip, "give a list of tcontact.render.Clip(point, normal)")
    colour_map(field, colours)
    studio = Studio(data, size, deformation_scale, obstacles, title, clip, colours)
    return studio, range or studio.limits(field)
