"""`tcontact run scene.toml`: it runs a scene from a file and leaves the files of a case, without its checks."""

from __future__ import annotations

import argparse
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from ..base.errors import InputError
from ..run.history import MOST_ROWS
from ..run.scene_files import load_scene
from ..schemes import scheme_of
from . import folder, settings
from .together import on_first_rank


def is_scene(name: str) -> bool:
    """Tell whether the word names a scene file rather than a case."""
    return name.lower().endswith(".toml")


def read_scene(file: Path, pairs: list[str]) -> tuple[Any, Any, dict[str, Any], dict[str, Any]]:
    """Return scene and scheme of a file under KEY=VALUE pairs, its other options, and what the pairs gave.

    Raises `InputError`.
    """
    scene, options = load_scene(file)
    given: dict[str, Any] = {}
    for pair in pairs:
        key, equals, text = pair.partition("=")
        if not equals or key.strip() not in settings.SCHEME_KEYS:
            remedy = "a scene file takes KEY=VALUE of " + ", ".join(settings.SCHEME_KEYS) + "; edit the file for others"
            raise InputError("--set", pair, remedy)
        given[key.strip()] = settings.value(key, text, settings.SCHEME_KEYS[key.strip()])
    scheme = scheme_of(options.get("scheme", "central-difference"))
    if given:
        scheme = settings.changed(settings.options_of(scheme), given)
    return scene, scheme, options, given


def without_checks() -> SimpleNamespace:
    """Return a stand-in for the case of a scene file."""
    return SimpleNamespace(checks=lambda result: [])


def run_scene(arguments: argparse.Namespace, start: Any, finish: Any) -> int:
    """Run it and return the exit code; options of the command line go before those of the file.

    start: gives what runs one scene; finish: runs it and writes all about it.
    """
    file = Path(arguments.case)
    scene, scheme, options, given = read_scene(file, arguments.set)
    # `tcontact resume` reads it again, from anywhere, and writes what was written here
    arguments.case, arguments.scene = str(file.resolve()), str(file)
    defaults: dict[str, Any] = {"frames": 60, "threads": None, "history_every": 1, "history_rows": MOST_ROWS}
    defaults |= {"arch": "cpu", "precision": "f64"}
    for key, default in defaults.items():
        if getattr(arguments, key, None) is None:
            setattr(arguments, key, options.get(key, default))
    out = arguments.out
    case = without_checks()
    with on_first_rank(lambda: folder.replacing(out, arguments.force)):
        go, origin = start(arguments, scene, scheme, out, "")
        passed, _ = finish(go, file.stem, case, {"scene": str(file)} | given, out, arguments, origin)
    return 0 if passed else 1
