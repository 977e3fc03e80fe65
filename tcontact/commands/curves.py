"""Curves of a run: contact force, gap, energies, those of its case; drawn as it ends, or again from its files."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..base import stages
from ..base.errors import InputError
from ..results.files.vtkhdf import ResultData
from ..results.stored import StoredResult, read_summary
from ..show import plots, views
from ..show.texts import plain
from . import origins
from .quick_import import load_matplotlib
from .run_scene import is_scene


def draw(out: Path, result: Any, case: Any, normals: list[Any], caption: str, size: float) -> None:
    """Draw the curves of a run into a folder.

    result: a `Result`, or what stands for one; case: its module, or None; normals: of its obstacles, if each has one;
    size: of the box around all bodies [m], corner to corner.
    """
    stages.say("drawing curves")
    load_matplotlib()
    known = case.curves(result) if hasattr(case, "curves") else None
    if np.isfinite(result.history["gap_min"]).any():
        plots.contact_force(out / "contact-force.png", result.history, normals, known, caption, size)
        plots.gap(out / "gap.png", result.history, caption, size)
    plots.energy(out / "energy.png", result.history, caption)
    if hasattr(case, "draw"):
        case.draw(result, out, caption)


def caption_of(title: str, pairs: list[str]) -> str:
    """Return the line above the curves: the run and what was set."""
    return ", ".join([title, *(pair for pair in pairs if not pair.startswith("compare"))])


def size_of(scene: Any) -> float:
    """Return the length [m] of the box around all bodies of a scene, corner to corner."""
    return views.length_of(np.concatenate([body.mesh.nodes for body in scene.bodies]))


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
    if "runs" in summary:
        names = [name for name in summary["runs"] if isinstance(name, str) and name == Path(name).name]
        if not names:
            raise InputError("file", str(folder), "its summary.json names no runs; run the comparison again")
        parts = [(folder / name, out / name) for name in names]
        results = {}
        for label, (place, target) in zip(summary.get("labels", names), parts, strict=False):
            results[str(label)] = _draw_stored(place / file.name, read_summary(place), target)
        data = ResultData.open(parts[0][0] / file.name)
        draw_comparison(out / "comparison.png", origins.case_of(summary), results, views.normals_of(data.attributes))
        return [*(target for _, target in parts), out]
    _draw_stored(file, summary, out)
    return [out]


def draw_comparison(path: Path, case: Any, results: Mapping[str, Any], normals: list[Any]) -> None:
    """Draw runs side by side: what their case compares, if it says so.

    results: the `Result` of each run by its label, or what stands for it.
    """
    histories = {label: result.history for label, result in results.items()}
    if hasattr(case, "draw_comparison"):
        case.draw_comparison(path, histories)
    elif hasattr(case, "compared"):
        found = {label: case.compared(result) for label, result in results.items()}
        quantities = next(iter(found.values()))
        plots.panels(path, {name: {plain(label): one[name] for label, one in found.items()} for name in quantities})
    else:
        plots.comparison(path, histories, normals)


def _draw_stored(file: Path, summary: Mapping[str, Any], out: Path) -> Any:
    """Draw one stored run; return what stands for its `Result`."""
    result = StoredResult(ResultData.open(file), summary)
    origin = origins.of(summary)
    # a scene file has no curves of its own
    case = result.case if origin is not None and not is_scene(origin["case"]) and result.history else None
    title = str(summary.get("case", file.absolute().parent.name))
    out.mkdir(parents=True, exist_ok=True)
    caption = caption_of(title, origin["set"] if origin else [])
    frames = result.frames
    draw(out, result, case, views.normals_of(frames.attributes), caption, views.length_of(frames.points))
    return result
