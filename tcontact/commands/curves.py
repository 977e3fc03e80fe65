"""Curves of a run: contact force, gap, energies, those of its case; drawn as it ends, or again from its files."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.errors import InputError
from ..show import plots
from . import origins
from .run_scene import is_scene

if TYPE_CHECKING:
    from ..results.files.vtkhdf import ResultData

NUMBERS = ("ok", "reason", "steps", "time", "dt", "dt_limit")  # numbers of a stored run that its case may ask for


def draw(out: Path, result: Any, case: Any, normals: list[Any], caption: str) -> None:
    """Draw the curves of a run into a folder.

    result: a `Result`, or what stands for one; case: its module, or None; normals: of its obstacles, if each has one.
    """
    known = case.curves(result) if hasattr(case, "curves") else None
    if np.isfinite(result.history["gap_min"]).any():
        plots.contact_force(out / "contact-force.png", result.history, normals, known, caption)
        plots.gap(out / "gap.png", result.history, caption)
    plots.energy(out / "energy.png", result.history, caption)
    if hasattr(case, "draw"):
        case.draw(result, out, caption)


def caption_of(title: str, pairs: list[str]) -> str:
    """Return the line above the curves: the run and what was set."""
    return ", ".join([title, *(pair for pair in pairs if not pair.startswith("compare"))])


def normals_of(scene: Any) -> list[Any]:
    """Return the normals of the obstacles of a scene if each has a single one, else none."""
    flat = all(obstacle.shape == "plane" and not obstacle.moves for obstacle in scene.obstacles)
    return [obstacle.normal for obstacle in scene.obstacles] if flat else []


def draw_again(file: Path, summary: Mapping[str, Any], out: Path) -> list[Path]:
    """Draw the curves of a stored run, or of all runs of a comparison, into `out`; return the folders drawn into.

    file: its result file; summary: what the summary.json beside it holds, {} without one. Raises `InputError` if there
    is no history.
    """
    folder = file.parent
    from ..results.files.vtkhdf import ResultData

    if "runs" in summary:
        names = [name for name in summary["runs"] if isinstance(name, str) and name == Path(name).name]
        if not names:
            raise InputError("file", str(folder), "its summary.json names no runs; run the comparison again")
        parts = [(folder / name, out / name) for name in names]
        histories = {}
        for label, (place, target) in zip(summary.get("labels", names), parts, strict=False):
            histories[str(label)] = _draw_stored(place / file.name, origins.summary(place / "summary.json"), target)
        data = ResultData.open(parts[0][0] / file.name)
        draw_comparison(out / "comparison.png", origins.case_of(summary), histories, _stored_normals(data))
        return [*(target for _, target in parts), out]
    _draw_stored(file, summary, out)
    return [out]


def draw_comparison(path: Path, case: Any, histories: dict[str, Any], normals: list[Any]) -> None:
    """Draw runs side by side."""
    if hasattr(case, "draw_comparison"):
        case.draw_comparison(path, histories)
    else:
        plots.comparison(path, histories, normals)


def _draw_stored(file: Path, summary: Mapping[str, Any], out: Path) -> dict[str, np.ndarray]:
    """Draw one stored run; return its history."""
    from ..results.files.vtkhdf import ResultData

    data = ResultData.open(file)
    history = data.history
    if not history or not len(history["time"]):
        remedy = f"it holds no history: the run has not ended; `tcontact resume {file.parent}` goes on with it"
        raise InputError("file", str(file), remedy)
    origin = origins.of(summary)
    found = None
    if origin is not None and not is_scene(origin["case"]):  # a scene file has no curves of its own
        found = origins.rebuilt(origin, file.parent)
    numbers = {name: (summary if name in summary else data.attributes).get(name) for name in NUMBERS}
    case = scene = scheme = None
    if found is not None:
        case, scene, scheme = found.case, found.scene, found.scheme
    result = SimpleNamespace(history=history, scene=scene, scheme=scheme, **numbers)
    title = str(summary.get("case", file.absolute().parent.name))
    out.mkdir(parents=True, exist_ok=True)
    draw(out, result, case, _stored_normals(data), caption_of(title, origin["set"] if origin else []))
    return history


def _stored_normals(data: ResultData) -> list[Any]:
    """Return the normals of the obstacles if each has a single one, else none."""
    described = data.attributes.get("obstacles", ())
    flat = all(one.get("kind") == "plane" and "motion" not in one for one in described)
    return [np.asarray(one["normal"]) for one in described] if flat else []
