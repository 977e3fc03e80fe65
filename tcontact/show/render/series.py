"""Series of pictures: every frame of a result, and what comes with them; or one picture at a time."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...base import stages, validate
from ...base.errors import InputError
from ...device.atomic_file import refuse_link, refuse_lost_link, refuse_special
from ...results.files.vtkhdf import Frame, ResultData
from ...results.tables import nearest
from .animation import animate, can_film, common_palette, film, why_no_film
from .camera import Camera, Eye
from .colours import colour_map
from .png import save_picture
from .shots import Shots
from .studio import Studio
from .surface import Clip

if TYPE_CHECKING:
    from PIL import Image

BESIDE = ("animation.gif", "animation.mp4", "bodies.png", "contact-face.png")  # files of a series beside its frames
SIZE = "give width and height in pixels, 160 to 8192"


def render_frames(
    data: ResultData | Path | str,
    out: Path | str,
    field: str | None = None,
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
    """Draw every frame of a result; return the files written.

    `out`/frames/frame-0000.png ..., animation.gif, animation.mp4 (see video) and, where bodies touched an obstacle,
    contact-face.png: the contact pressure seen from below in the frame with the largest contact force (of one of
    several obstacles or pairs; its caption has force and time); with several bodies also bodies.png, the first frame
    with a colour for each body. Those of an earlier series in `out` that this one has not are removed, in the folder of
    the run itself but the ones that these options leave out: the contact face with `clip`, bodies.png with the field
    "body", the animation without `animation`.

    field: any field of the file, vectors by their length, cell values one colour a face, None = the contact pressure,
    in a file without it the von Mises stress or the first field; "body", in a file of several ones: a colour for each
    with its name, which other fields have written on the body; size: picture [pixel]; camera: None = a three-quarter
    view of body and contact plane; deformation_scale: factor on displacements about each body's mean motion; obstacles:
    {"kind": "plane", "point": [3], "normal": [3]} each, None = those in the file's attributes; fps: frames per second
    of the animation, None = about six seconds in all; range: values at the two ends of the colours, None = those of the
    series, without the highest 1.5 %; view: "above" or "below" the first plane, which is then drawn as an outline;
    title: the second line, None = the attribute "title" of the file; colours: a colour map of matplotlib, None = that
    of the field; clip: planes that cut the bodies open; video: an MP4 beside the GIF, None = where imageio-ffmpeg is
    installed and works, with a warning where it only is installed.
    Raises `InputError` for an unknown field (with those known), a file without frames and values out of place, before
    it writes.
    """
    data = data if isinstance(data, ResultData) else ResultData.open(data)
    out = validate.path("out", out, "give the name of a folder")
    refuse_lost_link(out)
    for name in BESIDE:
        refuse_special(out / name)
    if fps is not None:
        fps = validate.number("fps", fps, low=0.01, high=1000.0, strict=False)
    validate.flag("animation", animation)
    if video is not None and validate.flag("video", video) and (why := why_no_film()):
        raise InputError("video", video, why)
    field = usual_field(data) if field is None else field
    with data.opened() as read:
        studio, limits = _opened(data, field, size, deformation_scale, obstacles, range, title, clip, colours, read)
        stages.say("drawing")
        eye = _eye(studio, view, camera)
        filmed = animation and (can_film() if video is None else video)
        with written_to(out):
            earlier = any((out / "frames").glob("frame-[0-9]*.png"))
            written = _written(studio, field, limits, eye, out, fps, animation, filmed)
            if studio.names and field != "body":
                path = out / "bodies.png"
                save_picture(studio.picture(studio.frame(0), "body", studio.limits("body"), eye), path)
                written.append(path)
            if not clip:  # an opened body has no whole contact face
                known = limits if field == "contact_pressure" else None
                written += studio.contact_face(out / "contact-face.png", known)
            if earlier:
                of_this_run = out.resolve() == data.path.resolve().parent
                left_out = (not animation, not animation, field == "body", bool(clip))
                kept = [name for name, unasked in zip(BESIDE, left_out, strict=True) if of_this_run and unasked]
                _remove_stale(out, {path.name for path in written}.union(kept))
    return written


def _remove_stale(out: Path, kept: set[str]) -> None:
    """Remove the files of an earlier series that are not to be kept, such as the contact face of another run."""
    for path in (out / name for name in BESIDE if name not in kept):
        if path.is_symlink() or path.is_file():
            path.unlink()


def _written(
    studio: Studio,
    field: str,
    limits: tuple[float, float],
    eye: Eye,
    out: Path,
    fps: float | None,
    animation: bool,
    filmed: bool,
) -> list[Path]:
    """Draw all frames into pictures and, if wanted, animation and film; return their files."""
    folder, count = out / "frames", len(studio.data)
    refuse_link(folder)
    folder.mkdir(parents=True, exist_ok=True)
    written = [folder / f"frame-{index:04d}.png" for index in range(count)]
    speed = fps or min(25.0, max(4.0, count / 6))
    with (
        film(out / "animation.mp4", speed, studio.size) if filmed else nullcontext() as shoot,
        Shots(studio, field, limits, eye, written) as shots,
    ):
        pictures = shots.all(shoot)
        if animation:
            palette = common_palette(shots.sample(8), colour_map(field, studio.wish))
            animate(pictures, palette, out / "animation.gif", speed)
        for _ in pictures:
            pass
    for stale in set(folder.glob("frame-[0-9]*.png")) - set(written):
        stale.unlink()  # it belongs to an earlier, longer series
    if animation:
        written += [out / "animation.gif", *([out / "animation.mp4"] if filmed else [])]
    return written


def usual_field(data: Any, wanted: str = "contact_pressure") -> str:
    """Return the field that colours pictures where none is named: the wanted one, or one that the frames have."""
    known = (*data.point_fields, *data.cell_fields)
    return next((name for name in (wanted, "von_mises", *known) if name in known), wanted)


def command_field(data: ResultData) -> str:
    """Return the field that colours the pictures of `tcontact run` and `tcontact render` where none is named.

    It is the von Mises stress, in a file without it the first field but displacements, and these where they are alone.
    """
    known = (*data.point_fields, *data.cell_fields)
    named = [name for name in known if name not in ("displacement", "body")]
    return "von_mises" if "von_mises" in known else (*named, "displacement")[0]


def render_picture(
    data: ResultData | Path | str,
    path: Path | str,
    time: float | None = None,
    field: str | None = None,
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
    """Draw the frame nearest to a time [s], None = the last one, into the file `path`; return it.

    Colours and camera are those of the whole series, so that pictures of several times can be compared; the other
    options are those of `render_frames`. Raises `InputError` as that does, and for a time outside of the frames.
    """
    data = data if isinstance(data, ResultData) else ResultData.open(data)
    path = _picture_name(path)
    options = (camera, deformation_scale, obstacles, range, view, title, colours, clip)
    stored_picture(drawn_picture(data, time, field, size, *options), path)
    return path


def drawn_picture(
    data: Any,
    time: float | None,
    field: str | None,
    size: tuple[int, int],
    camera: Camera | None = None,
    deformation_scale: float = 1.0,
    obstacles: Sequence[Mapping[str, Any]] | None = None,
    range: tuple[float, float] | None = None,
    view: str = "above",
    title: str | None = None,
    colours: str | None = None,
    clip: Sequence[Clip] = (),
) -> Image.Image:
    """Draw the picture of `render_picture`; data: also a series in memory, `show.notebook.EndState`."""
    index = nearest(data, time) if len(data) else 0
    field = usual_field(data) if field is None else field
    studio, limits = _opened(data, field, size, deformation_scale, obstacles, range, title, clip, colours)
    eye = _eye(studio, view, camera)
    return studio.picture(studio.frame(index), field, limits, eye)


def stored_picture(picture: Image.Image, path: Path | str) -> None:
    """Write a picture into a file. Raises `InputError` for a name or a place that cannot be written."""
    path = _picture_name(path)
    refuse_lost_link(path.parent, "path")
    with written_to(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        save_picture(picture, path)


@contextmanager
def written_to(place: Path) -> Iterator[None]:
    """Raise `InputError` where the disk or the name does not let a picture be written."""
    try:
        yield
    except OSError as error:
        reason = error.strerror or error
        raise InputError("out", str(place), f"cannot be written ({reason}); make room or name another place") from error


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
    read: Callable[[int], Frame] | None = None,
) -> tuple[Studio, tuple[float, float]]:
    """Return a studio for these wishes and the ends of the colours. Raises `InputError` for what cannot be met."""
    if len(data) == 0:
        raise InputError("data", str(data.path), "the file holds no frames; run again with frames > 0")
    if validate.shape_of("size", size, SIZE) != (2,):
        raise InputError("size", size, SIZE)
    size = (validate.whole("size", size[0], 160, 8192), validate.whole("size", size[1], 160, 8192))
    known = (*data.point_fields, *data.cell_fields)
    if isinstance(field, str) and field == "body" and field not in known:
        words = ", ".join(repr(word) for word in known)
        raise InputError("field", field, f"only a run of several bodies has it; use one of {words}")
    validate.choice("field", field, known)
    if range is not None and field == "body":
        raise InputError("range", range, "bodies have a colour each and no values: leave it away")
    if range is not None:
        low, high = (float(end) for end in validate.floats("range", range, (2,)))
        if not low < high:
            raise InputError("range", range, "give two values, the lower one first")
        range = (low, high)
    if not isinstance(clip, (list, tuple)) or not all(isinstance(one, Clip) for one in clip):
        raise InputError("clip", clip, "give a list of tcontact.render.Clip(point, normal)")
    if obstacles is not None and (
        not isinstance(obstacles, (list, tuple)) or not all(isinstance(one, Mapping) for one in obstacles)
    ):
        raise InputError("obstacles", obstacles, 'give a list of dictionaries such as {"kind": "plane", ...}')
    if title is not None and not isinstance(title, str):
        raise InputError("title", title, "give a text, or None for that of the file")
    validate.number("deformation_scale", deformation_scale)
    colour_map(field, colours)
    studio = Studio(data, size, deformation_scale, obstacles, title, clip, colours, read)
    return studio, range or studio.limits(field)


def _eye(studio: Studio, view: str, camera: Camera | None) -> Eye:
    """Return the placed camera. Raises `InputError`."""
    validate.choice("view", view, ("above", "below"))
    if camera is not None and not isinstance(camera, Camera):
        raise InputError("camera", camera, "give a tcontact.render.Camera(direction, up), or None")
    return studio.camera(view, camera)


def _picture_name(path: Any) -> Path:
    """Return the name of a picture, of a kind that can be written. Raises `InputError`."""
    from PIL import Image

    remedy = "give the name of a picture, such as picture.png"
    found = validate.path("path", path, remedy)
    if Image.registered_extensions().get(found.suffix.lower()) not in Image.SAVE:
        raise InputError("path", str(found), remedy)
    refuse_special(found, "path")
    return found
