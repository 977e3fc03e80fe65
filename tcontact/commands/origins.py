"""Origin of a run of the command line: {"case": name or scene file, "set": [KEY=VALUE], "label": name or ""}.

The label is that of a run of a comparison; "scene" is the scene file as the user named it, "case" its full path,
"relative" its path from the folder of the run, by which it is found where both were moved. All this stands in
checkpoints and in summary.json, and is enough to make the scene again.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tcontact import cases

from ..base.errors import InputError
from ..results.files import checkpoint_heads
from . import same_scene, settings
from .run_scene import is_scene, read_scene, without_checks

REMEDY = "it names no case, settings and label as `tcontact run` writes them; call tcontact.resume(folder, scene) there"


@dataclass(frozen=True)
class Rebuilt:
    """What `tcontact run` ran, made again: title of the run, its case, its parameters, scene and scheme.

    options: the other ones of `simulate` that a scene file gives; a case gives none.
    """

    title: str
    case: Any
    parameters: dict[str, Any]
    scene: Any
    scheme: Any
    source: str  # case or scene file
    options: Mapping[str, Any] = field(default_factory=dict)

    def check_same(self, summary: Mapping[str, Any], data: Any) -> None:
        """Raise `NotStored` if the case or scene file makes another scene by now than the run of this result had."""
        same_scene.check_same(self.scene, self.scheme, self.source, summary, data)


def checked(origin: Any, folder: Path) -> dict[str, Any]:
    """Return the origin with all its parts. Raises `InputError` if it is not one of the command line."""
    if isinstance(origin, Mapping) and "case" not in origin:
        remedy = "a program started this run, not the command line: call tcontact.resume(folder, scene) there"
        raise InputError("DIR", str(folder), remedy)
    parts = dict(origin) if isinstance(origin, Mapping) else {}
    name, pairs, label = parts.get("case"), parts.get("set", []), parts.get("label", "")
    places = {key: parts[key] for key in ("scene", "relative") if key in parts}
    well = all(isinstance(text, str) for text in (name, label, *places.values())) and isinstance(pairs, list)
    if not well or not all(isinstance(pair, str) for pair in pairs):
        raise InputError("origin", origin, f"in the checkpoints of {folder}: {REMEDY}")
    return {"case": name, "set": pairs, "label": label} | places


def relative(file: str, folder: Path) -> dict[str, str]:
    """Return the part of an origin that says where the scene file lies as seen from the folder of the run.

    file: its full path. There is no such part where the two are on different drives.
    """
    try:
        return {"relative": os.path.relpath(file, folder.resolve())}
    except ValueError:
        return {}


def of(summary: Mapping[str, Any]) -> dict[str, Any] | None:
    """Return the origin that a summary holds; None if it holds none, as the summary of a program."""
    try:
        return checked(summary.get("origin"), Path("."))
    except InputError:
        return None


def rebuilt(origin: Mapping[str, Any], folder: Path) -> Rebuilt:
    """Make the scene again. Raises `InputError` if its case, scene file or settings are no longer there."""
    name, label = origin["case"], origin["label"]
    if is_scene(name):
        file, named = _scene_file(origin, folder), origin.get("scene", name)
        scene, scheme, options, given = read_scene(file, origin["set"])
        parameters = {"scene": named} | given
        source = named if file == Path(name) else str(file)
        return Rebuilt(Path(name).stem, without_checks(), parameters, scene, scheme, source, options)
    case = cases.load(name)
    wanted = settings.read(name, case, origin["set"])
    if label:
        known = settings.built(case.comparison, wanted.scene) if hasattr(case, "comparison") else {}
        if label not in known:
            raise InputError("origin.label", label, f"{name} compares {', '.join(known) or 'nothing'}; run again")
        chosen = known[label]
    elif not hasattr(case, "scene"):
        raise InputError("origin.case", name, f"has no mechanical scene, so that {folder} cannot be its run; run again")
    else:
        chosen = settings.built(case.scene, wanted.scene)
    scene, scheme = chosen if isinstance(chosen, tuple) else (chosen, settings.scheme(wanted.scheme, case))
    parameters = settings.defaults(case) | wanted.scene | wanted.scheme
    return Rebuilt(f"{name} {label}".strip(), case, parameters, scene, scheme, name)


def _scene_file(origin: Mapping[str, Any], folder: Path) -> Path:
    """Return the scene file where it was, or where it lies as seen from the folder if both were moved.

    Raises `InputError` if it is at neither place.
    """
    places = [origin["case"]]
    if "relative" in origin:
        places.append(os.path.normpath(folder.resolve() / origin["relative"]))
    for place in places:
        if os.path.isfile(place):
            return Path(place)
    nor = "".join(f", nor is {place}" for place in places[1:] if place != places[0])
    remedy = f"the scene file of this run is not there{nor}; put it back, or read it with tcontact.load_scene(FILE) and"
    remedy += " call tcontact.resume(folder, scene) or open_result(folder, scene=...)"
    raise InputError("scene", places[0], remedy)


def case_of(summary: Mapping[str, Any]) -> Any:
    """Return the module of the case that a summary names; None if it names none that exists."""
    name = summary.get("case")
    return cases.load(name) if isinstance(name, str) and name in cases.names() else None


def made_again(summary: Mapping[str, Any], folder: Path) -> Rebuilt | None:
    """Return what `tcontact run` ran, made again; None where neither summary nor checkpoint is of the command line.

    A run that was killed has left no summary. Raises `InputError` if its case, scene file or settings are no longer
    there.
    """
    origin = of(summary) or of(checkpoint_heads.head(folder))
    return None if origin is None else rebuilt(origin, folder)
