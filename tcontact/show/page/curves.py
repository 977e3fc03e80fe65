"""Curves of a run for its page."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ...base.errors import InputError
from ...kernels.columns import COLUMNS
from ...results.stored import StoredResult
from ...results.tables import flat_columns
from .. import plots, views
from .packed import text_of

PIECES = 750  # of a long history; first, smallest, largest and last value of each are drawn


def groups_of(result: StoredResult) -> list[dict[str, Any]]:
    """Return the figures of a page: {"title", "unit", "lines": [{"name", "x", "y", "dashed"}]}, times in seconds."""
    history = result.history
    time = history["time"]
    found = []
    if np.isfinite(history["gap_min"]).any():
        found.append(_group("Contact force", "N", _forces(result), _known(result)))
    parts = {column.name: column for column in COLUMNS if column.energy and np.any(history.get(column.name, 0.0))}
    energies = {
        ("− " if column.energy == "supplied" else "") + name.replace("_", " "): (
            time,
            -history[name] if column.energy == "supplied" else history[name],
        )
        for name, column in parts.items()
    }
    found.append(_group("Energies", "J", energies | {"sum": (time, history["energy"])}))
    found.append(_group("Energy error", "", {"energy error": (time, history["energy_error"])}))
    if np.isfinite(history["gap_min"]).any():
        rounding = plots.GAP_ROUNDING * views.length_of(result.frames.points)
        gap = np.where(np.isinf(history["gap_min"]), np.nan, history["gap_min"])
        gap = np.where(np.abs(gap) <= rounding, 0.0, gap)
        found.append(_group("Smallest gap", "m", {"smallest gap": (time, gap)}))
    return found


def columns_of(result: StoredResult) -> list[dict[str, Any]]:
    """Return every column of the history as a figure of its own, a vector as its components."""
    found = []
    for name, array in result.history.items():
        if name != "time" and np.isfinite(array).any():
            lines = {part: (result.history["time"], values) for part, values in flat_columns({name: array}).items()}
            unit = views.unit_of(name)
            found.append(_group(name.replace("_", " "), "" if unit == "1" else unit, lines))
    return found


def thinned(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the rows of a curve that show on a screen: first, smallest, largest and last of every piece."""
    if len(time) <= 4 * PIECES:
        return time, values
    kept = []
    for rows in np.array_split(np.arange(len(time)), PIECES):
        piece = np.nan_to_num(values[rows], nan=0.0)
        kept += [rows[0], rows[np.argmin(piece)], rows[np.argmax(piece)], rows[-1]]
    chosen = np.unique(kept)
    return time[chosen], values[chosen]


def _forces(result: StoredResult) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    history = result.history
    parts = plots.part_forces(history)
    if parts:
        return {name: (history["time"], np.linalg.norm(force, axis=1)) for name, force in parts.items()}
    normals = views.normals_of(result.frames.attributes)
    return {"computed": (history["time"], plots.force_component(history, normals))}


def _known(result: StoredResult) -> Mapping[str, tuple[np.ndarray, np.ndarray]]:
    """Return the forces that the case of the run knows from elsewhere, such as an exact solution."""
    try:
        case = result.case
        return dict(case.curves(result)) if hasattr(case, "curves") else {}
    except InputError:  # the case or its settings are no longer there
        return {}


def _group(
    title: str,
    unit: str,
    lines: Mapping[str, tuple[np.ndarray, np.ndarray]],
    dashed: Mapping[str, tuple[np.ndarray, np.ndarray]] | None = None,
) -> dict[str, Any]:
    drawn = []
    for known, curves in ((False, lines), (True, dashed or {})):
        for name, (times, values) in curves.items():
            x, y = thinned(np.asarray(times, float), np.asarray(values, float))
            drawn.append({"name": name, "x": text_of(x, "f8"), "y": text_of(y, "f8"), "dashed": known})
    return {"title": title, "unit": unit, "lines": drawn}
