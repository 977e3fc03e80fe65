"""`tcontact resume DIR`: it continues a run that was interrupted, killed or ran out of disk."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from ..base.errors import InputError, OutputError
from ..device import ranks
from . import options, origins
from .run import finish


def add(subparsers: Any) -> None:
    """Declare the command."""
    parser = subparsers.add_parser(
        "resume",
        help="go on with a run that stopped",
        description="Go on with a run that `tcontact run` started and that was interrupted or killed, from its last"
        " checkpoint: the results are those of a run that never stopped, bit for bit. A run that was killed while its"
        " pictures were drawn gets them.",
    )
    parser.add_argument("folder", metavar="DIR", type=Path, help="the folder of the run")
    options.add(parser, "--arch", help="where to compute (default: where the run did)")
    between = "wall time between further checkpoints, 0 = only when it is stopped again (default: 60)"
    options.add(parser, "--checkpoint", help=between)
    options.add(parser, "--threads", help="CPU threads (default: those of the scene file, else all cores)")
    options.add(parser, "--quiet", "--import")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Continue the run and return the exit code."""
    arguments.quiet = arguments.quiet or not ranks.is_first_rank()
    import tcontact as tc

    from ..run.resumption import checked_folder, latest

    folder = checked_folder(arguments.folder)
    stored = latest(folder)[0]
    origin = origins.checked(stored.head["origin"], folder)
    found = origins.rebuilt(origin, folder)
    arguments.set, arguments.frames = origin["set"], stored.values["course.frames"]
    arguments.fields = stored.head["fields"]

    def go() -> tc.Result:
        return tc.resume(
            folder,
            found.scene,
            scheme=found.scheme,
            threads=found.options.get("threads") if arguments.threads is None else arguments.threads,
            arch=arguments.arch or stored.head.get("arch", "cpu"),
            progress=not arguments.quiet,
            checkpoint=arguments.checkpoint or None,
        )

    try:
        passed, _ = finish(go, found.title, found.case, found.parameters, folder, arguments, origin)
    except OutputError:
        raise
    except OSError as error:
        raise InputError("DIR", str(folder), f"cannot be written ({error})") from error
    return 0 if passed else 1
