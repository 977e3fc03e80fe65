"""`tcontact render FILE`: pictures and animation of a stored run, coloured by a field."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from ..errors import InputError


def add(subparsers: Any) -> None:
    """Declare the command."""
    parser = subparsers.add_parser(
        "render", help="draw a stored run", description="Draw the frames of a stored run, and an animation of them."
    )
    parser.add_argument("file", metavar="FILE", type=Path, help="a result.vtkhdf or the folder of a run")
    parser.add_argument("--field", metavar="NAME", help="field that colours the surface (tcontact info lists them)")
    parser.add_argument("--size", metavar="WxH", type=_size, help="size of a picture in pixels, for example 960x720")
    parser.add_argument("--view", choices=("above", "below"), help="look from above the obstacle or through it")
    parser.add_argument("--out", metavar="DIR", type=Path, help="folder to write into (default: beside the file)")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Draw the run."""
    from ..render import render_frames

    path = arguments.file / "result.vtkhdf" if arguments.file.is_dir() else arguments.file
    if not path.is_file():
        raise InputError("file", str(path), "no such file; give a result.vtkhdf or the folder of a run")
    out = arguments.out or path.parent
    options = {key: value for key in ("field", "size", "view") if (value := getattr(arguments, key)) is not None}
    written = render_frames(path, out, **options, title=_case(path.parent / "summary.json"))
    for stale in set((out / "frames").glob("frame-*.png")) - set(written):
        stale.unlink()  # of an earlier, longer series
    for picture in written:
        if picture.parent.name != "frames":
            print(picture)
    print(out / "frames")
    return 0


def _case(summary: Path) -> str | None:
    """Name of the case that left this summary, None if there is none."""
    try:
        return str(json.loads(summary.read_text(encoding="utf-8"))["case"])
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _size(text: str) -> tuple[int, int]:
    width, x, height = text.lower().partition("x")
    if not (x and width.isdigit() and height.isdigit() and int(width) and int(height)):
        raise argparse.ArgumentTypeError("give width x height in pixels, for example 960x720")
    return int(width), int(height)
