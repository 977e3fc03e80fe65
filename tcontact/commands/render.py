"""`tcontact render FILE`: it draws pictures and animation of a stored run, coloured by a field."""

from __future__ import annotations

import argparse
import re
from pathlib import Path
from typing import Any

from ..base import validate
from ..base.errors import InputError
from ..results.stored import read_summary
from ..results.tables import nearest
from . import curves, origins, words
from . import options as shared
from .folder import result_file


def add(subparsers: Any) -> None:
    """Declare the command."""
    parser = subparsers.add_parser(
        "render",
        help="draw a stored run",
        description="Draw the frames of a stored run, and an animation of them. Without options these are the pictures"
        " that `tcontact run` drew, coloured by the von Mises stress; --field contact_pressure shows the contact.",
    )
    shared.add(parser, "FILE")
    parser.add_argument(
        "--field",
        metavar="NAME",
        help="field that colours the surface (tcontact info lists them; default: von_mises, or the first that the run"
        " stored beside displacements); body: a colour for each body",
    )
    parser.add_argument("--colours", metavar="MAP", help="a colour map of matplotlib, for example coolwarm")
    parser.add_argument("--range", metavar="LOW,HIGH", type=_pair, help="values at the two ends of the colours")
    parser.add_argument("--size", metavar="WxH", type=_size, help="size of a picture in pixels, for example 960x720")
    parser.add_argument("--view", choices=("above", "below"), help="look from above the obstacle or through it")
    parser.add_argument("--camera", metavar="X,Y,Z", type=_vector, help="direction from the body to the eye")
    parser.add_argument("--up", metavar="X,Y,Z", type=_vector, help="upward on the picture, with --camera (default: z)")
    parser.add_argument("--scale", metavar="N", type=words.number, help="factor on deformations (default: 1)")
    parser.add_argument(
        "--clip", metavar="'x>0.05'", type=_clip, action="append", help="leave such cells away; twice: a quarter"
    )
    parser.add_argument("--time", metavar="T", type=words.number, help="only the frame nearest to this time in seconds")
    parser.add_argument("--fps", metavar="N", type=words.positive, help="frames per second of the animation")
    parser.add_argument(
        "--mp4",
        action="store_true",
        help="insist on animation.mp4 (it needs imageio-ffmpeg; without this option it comes where that is installed)",
    )
    parser.add_argument(
        "--plots", action="store_true", help="only the curves of the run (contact force, gap, energies), from its files"
    )
    shared.add(parser, "--out", help="folder to write into (default: beside the file)")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Draw the run."""
    _refuse_unheard(arguments)
    if arguments.plots:
        return _plots(arguments)
    from ..results.files.vtkhdf import ResultData
    from ..show.render import Camera, Clip, render_frames, render_picture
    from ..show.render.series import command_field

    path = result_file(arguments.file)
    out = arguments.out or path.parent
    given = {name: getattr(arguments, name) for name in ("field", "size", "view", "colours", "range")}
    options: dict[str, Any] = {name: value for name, value in given.items() if value is not None}
    data = ResultData.open(path)
    options.setdefault("field", command_field(data))
    options["title"] = _title(path.parent)
    options["clip"] = [Clip(*one) for one in arguments.clip or ()]
    if arguments.scale is not None:
        options["deformation_scale"] = arguments.scale
    if arguments.camera is not None:
        if arguments.view is not None:
            raise InputError("--view", arguments.view, "give it or --camera, not both")
        try:
            options["camera"] = Camera(arguments.camera, arguments.up)
        except InputError as error:
            option = "--up" if error.field == "Camera.up" else "--camera"
            raise InputError(option, error.value, error.remedy) from error
    elif arguments.up is not None:
        raise InputError("--up", arguments.up, "give --camera too")
    if arguments.time is not None:
        drawn = float(data.times[nearest(data, arguments.time)]) if len(data) else arguments.time
        print(render_picture(data, out / f"picture-{options['field']}-{drawn:g}s.png", drawn, **options))
        return 0
    written = render_frames(data, out, fps=arguments.fps, video=True if arguments.mp4 else None, **options)
    for picture in written:
        if picture.parent.name != "frames":
            print(picture)
    print(out / "frames")
    return 0


def _refuse_unheard(arguments: argparse.Namespace) -> None:
    """Refuse options that would say nothing beside one that draws less. Raises `InputError`."""
    given = {name: value for name, value in vars(arguments).items() if value is not None and value is not False}
    for name, drawn, unheard in (("plots", "curves", ("time", "fps", "mp4")), ("time", "one frame", ("fps", "mp4"))):
        for other in unheard:
            if name in given and other in given:
                remedy = f"--{name} draws {drawn} only; leave one of the two options away"
                raise InputError(f"--{other}", given[other], remedy)


def _plots(arguments: argparse.Namespace) -> int:
    """Draw the curves alone."""
    from ..show.render.series import written_to

    given = arguments.file
    file = given / "result.vtkhdf" if validate.is_folder(given) else given
    summary = read_summary(file.parent) if file.name == "result.vtkhdf" else {}
    out = arguments.out or file.parent
    if "runs" not in summary:
        result_file(given)
    with written_to(out):
        for place in curves.draw_again(file, summary, out):
            print(place)
    return 0


def _title(folder: Path) -> str | None:
    """Return the line above the pictures of a run of the command line: its case and what was set; None of others."""
    summary = read_summary(folder)
    origin = origins.of(summary)
    return curves.caption_of(str(summary["case"]), origin["set"] if origin else []) if "case" in summary else None


def _size(text: str) -> tuple[int, int]:
    width, x, height = text.lower().partition("x")
    if not (x and width.isdigit() and height.isdigit() and int(width) and int(height)):
        raise argparse.ArgumentTypeError("give width x height in pixels, for example 960x720")
    return int(width), int(height)


def _numbers(text: str, count: int, example: str) -> tuple[float, ...]:
    try:
        found = tuple(float(part) for part in text.split(","))
    except ValueError:
        found = ()
    if len(found) != count:
        raise argparse.ArgumentTypeError(f"give {count} numbers, for example {example}")
    return found


def _vector(text: str) -> tuple[float, ...]:
    return _numbers(text, 3, "1,-2,0.5")


def _pair(text: str) -> tuple[float, ...]:
    return _numbers(text, 2, "0,4e5")


def _clip(text: str) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return point and normal of the plane where `x>0.05` begins to hold."""
    found = re.fullmatch(r"\s*([xyz])\s*([<>])\s*([-+.0-9eE]+)\s*", text)
    try:
        axis, side, value = "xyz".index(found[1]), 1.0 if found[2] == ">" else -1.0, float(found[3])  # type: ignore[index]
    except (TypeError, ValueError):
        raise argparse.ArgumentTypeError("give what to leave away, for example 'x>0.05' or 'z<0'") from None
    rows = [[0.0] * 3, [0.0] * 3]
    rows[0][axis], rows[1][axis] = value, side
    return tuple(rows[0]), tuple(rows[1])
