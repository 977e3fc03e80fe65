"""`tcontact report DIR`: it writes a web page of a run, of runs side by side, or of a study."""

from __future__ import annotations

import argparse
import os
import sys
import webbrowser
from pathlib import Path
from typing import Any

from . import words

TOGETHER = "side-by-side.html"  # page of several folders, beside the page that the first one has of itself


def add(subparsers: Any) -> None:
    """Declare the command."""
    parser = subparsers.add_parser(
        "report",
        help="make a web page of a run",
        description="Write one web page, which needs no other file and no network, of a run, of several runs side by"
        " side, or of a study: how it ended, checks, curves to zoom, the film, the surface to turn.",
    )
    parser.add_argument("folders", metavar="DIR", nargs="+", type=Path, help="folder of a run, comparison or study")
    parser.add_argument(
        "--out",
        metavar="FILE",
        type=words.file,
        help=f"page to write (default: DIR/report.html; of several, {TOGETHER} in the first)",
    )
    parser.add_argument("--open", action="store_true", help="show the page in the browser")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Write the page."""
    path = page_of(*arguments.folders, out=arguments.out)
    print(path)
    if arguments.open:
        show(path)
    return 0


def page_of(*folders: Path, out: Path | None = None) -> Path:
    """Write the page of runs or studies, into the first folder if no file is named; return it."""
    from ..show.page.document import write_page

    first, name = folders[0], "report.html" if len(folders) == 1 else TOGETHER
    return write_page(folders, out or (first if first.is_dir() else first.parent) / name)


def show(path: Path) -> None:
    """Show a page in the browser, where there is a display or a browser of the user's choice."""
    shown = sys.platform != "linux" or any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER"))
    if not (shown and webbrowser.open(path.absolute().as_uri())):
        print("no browser was found: open the page by hand")
