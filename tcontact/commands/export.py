"""`tcontact export FILE`: it writes the frames of a stored run for programs that read no VTKHDF."""

from __future__ import annotations

import argparse
from typing import Any

from ..base.errors import InputError
from ..device.atomic_file import refuse_link
from . import options, words
from .folder import result_file


def add(subparsers: Any) -> None:
    """Declare the command."""
    parser = subparsers.add_parser(
        "export",
        help="write a stored run as .vtu or .xdmf",
        description="Write the frames of a stored run as .vtu files with a .pvd index, or as .xdmf with .h5.",
    )
    options.add(parser, "FILE")
    parser.add_argument("--to", choices=("vtu", "xdmf"), default="vtu", help="format (default: vtu)")
    parser.add_argument(
        "--fields", metavar="A,B", type=words.names, help="only these fields (tcontact info lists them; default: all)"
    )
    parser.add_argument("--every", metavar="N", type=words.whole, default=1, help="take every N-th frame (default: 1)")
    options.add(parser, "--out", help="folder to write into (default: export, beside FILE)")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Write the series and name the file to open."""
    from ..results.exporting import export
    from ..results.files.vtkhdf import ResultData

    path = result_file(arguments.file)
    out = arguments.out or path.parent / "export"
    if arguments.out is None:
        refuse_link(out)
    if arguments.fields is not None and not arguments.fields:
        raise InputError("--fields", "", "name at least one field, or leave it out for all of them")
    written = export(ResultData.open(path), out, arguments.to, arguments.fields, arguments.every)
    size = sum(file.stat().st_size for file in written)
    print(f"{written[-1]} ({len(written)} files, {size / 1e6:.3g} MB)")
    return 0
