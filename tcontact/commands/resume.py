"""`tcontact resume DIR`: go on with a run that was interrupted, killed or ran out of disk."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from ..errors import InputError, OutputError
from . import settings, words
from .run import finish
from .run_scene import is_scene, read_scene, without_checks


def add(subparsers: Any) -> None:
    """Declare the command."""
    parser = subparsers.add_parser(
        "resume",
        help="go on with a run that stopped",
        description="Go on with a run that `tcontact run` started and that was interrupted or killed, from its last"
        " checkpoint: the results are those of a run that never stopped, bit for bit.",
    )
    parser.add_argument("folder", metavar="DIR", type=Path, help="the folder of the run")
    parser.add_argument("--arch", choices=("cpu", "cuda"), default="cpu", help="where to compute (default: cpu)")
    parser.add_argument("--threads", metavar="N", type=words.whole, help="CPU threads (default: all cores)")
    parser.add_argument(
        "--checkpoint",
        metavar="SECONDS",
        type=words.not_negative,
        default=60.0,
        help="wall time between further checkpoints, 0 = none (default: 60)",
    )
    parser.add_argument("--quiet", action="store_true", help="no progress bar, no table: only failures are printed")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Go on with the run and return the exit code."""
    import tcontact as tc
    from tcontact import cases

    from ..resume import checked_folder, latest

    folder = checked_folder(arguments.folder)
    stored = latest(folder)
    origin = stored.head["origin"]
    if "case" not in origin:
        remedy = "a program started this run, not the command line: call tcontact.resume(folder, scene) there"
        raise InputError("DIR", str(folder), remedy)
    name, label = origin["case"], origin.get("label", "")
    case: Any
    if is_scene(name):
        scene, scheme, _, given = read_scene(Path(name), origin["set"])
        case, parameters, name = without_checks(), {"scene": origin.get("scene", name)} | given, Path(name).stem
    else:
        case = cases.load(name)
        wanted = settings.read(name, case, origin["set"])
        chosen = case.comparison(**wanted.scene)[label] if label else case.scene(**wanted.scene)
        scene, scheme = chosen if isinstance(chosen, tuple) else (chosen, settings.scheme(wanted.scheme, case))
        parameters = settings.defaults(case) | wanted.scene | wanted.scheme
    arguments.set, arguments.frames = origin["set"], stored.values["course.frames"]
    arguments.fields = stored.head["fields"]

    def go() -> tc.Result:
        return tc.resume(
            folder,
            scene,
            scheme=scheme,
            threads=arguments.threads,
            arch=arguments.arch,
            progress=not arguments.quiet,
            checkpoint=arguments.checkpoint or None,
        )

    try:
        passed, _ = finish(go, f"{name} {label}".strip(), case, parameters, folder, arguments)
    except OutputError:
        raise
    except OSError as error:
        raise InputError("DIR", str(folder), f"cannot be written ({error})") from error
    return 0 if passed else 1
