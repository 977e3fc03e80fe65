"""Describe obstacles in plain numbers, for result files and pictures."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from .base import Obstacle
from .isosurface import isosurface
from .motion import Motion, rotations

STEPS = 1000  # times of the motion per frame


def describe(
    obstacles: Iterable[Obstacle], times: Sequence[float] = (), history: Mapping[str, np.ndarray] | None = None
) -> list[dict[str, Any]]:
    """Return a dictionary for each obstacle; moving ones with their poses at `times` [s].

    history: of the run, in which the poses of obstacles that move freely stand.

    kind; name, None without one; point [3] and frame [3, 3] at t = 0, parameters as in `Obstacle`; normal [3] of a
    plane; points [k, 3] (local) and triangles [m, 3] of a sampled one; motion: time [m], point [m, 3], frame [m, 3, 3].
    """
    found = []
    for number, obstacle in enumerate(obstacles):
        label = obstacle.name or f"obstacle-{number}"
        found.append(_described(obstacle, np.asarray(times, dtype=np.float64), label, history or {}))
    return found


def _described(obstacle: Obstacle, times: np.ndarray, label: str, history: Mapping[str, np.ndarray]) -> dict[str, Any]:
    result: dict[str, Any] = {"kind": obstacle.shape, "name": obstacle.name, "point": obstacle.reference.tolist()}
    if obstacle.shape == "plane":
        result["normal"] = obstacle.frame[2].tolist()
    result |= {"frame": obstacle.frame.tolist(), "parameters": list(obstacle.parameters)}
    if obstacle.grid is not None:
        surface = getattr(obstacle, "surface", None)
        start, spacing = np.array(obstacle.parameters[:3]), obstacle.parameters[3]
        if surface is None:
            points, triangles = isosurface(obstacle.grid[..., 0], start, spacing)
        else:
            points, triangles = np.asarray(surface[0]) - obstacle.reference, np.asarray(surface[1])
        result |= {"points": points.tolist(), "triangles": triangles.tolist()}
    found = poses(obstacle, times, label, history)
    if found is not None:
        points, frames = found
        result["motion"] = {"time": times.tolist(), "point": points.tolist(), "frame": frames.tolist()}
    return result


def poses(
    obstacle: Obstacle, times: np.ndarray, label: str, history: Mapping[str, np.ndarray]
) -> tuple[np.ndarray, np.ndarray] | None:
    """Return reference points [m, 3] [m] and frames [m, 3, 3] of an obstacle at times [m] [s].

    label: its name in the history of the run, where the poses of one that moves freely stand. None where it does not
    move, where these are missing, or without times.
    """
    if obstacle.free and len(times) and f"obstacle_position:{label}" in history:
        between = 0.5 * (history["time"][1:] + history["time"][:-1])
        rows = np.searchsorted(between, times)  # frames are rows, unless these were thinned
        turns = rotations(history[f"obstacle_rotation:{label}"][rows])
        return history[f"obstacle_position:{label}"][rows], obstacle.frame @ np.swapaxes(turns, 1, 2)
    if obstacle.moves and not obstacle.free and len(times):
        longest = max(float(np.abs(times).max()), 1e-300) / STEPS
        points, frames, _, _ = Motion(obstacle, step=longest).poses(times)
        return points, frames
    return None
