"""Describe obstacles in plain numbers, for result files and pictures."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from .base import Obstacle
from .isosurface import isosurface
from .motion import Motion

STEPS = 1000  # times of the motion per frame


def describe(obstacles: Iterable[Obstacle], times: Sequence[float] = ()) -> list[dict[str, Any]]:
    """Return a dictionary for each obstacle; moving ones with their poses at `times` [s].

    kind; point [3] and frame [3, 3] at t = 0, parameters as in `Obstacle`; normal [3] of a plane; points [k, 3] (local)
    and triangles [m, 3] of a sampled one; motion: time [m], point [m, 3], frame [m, 3, 3].
    """
    return [_described(obstacle, np.asarray(times, dtype=np.float64)) for obstacle in obstacles]


def _described(obstacle: Obstacle, times: np.ndarray) -> dict[str, Any]:
    result: dict[str, Any] = {"kind": obstacle.shape, "point": obstacle.reference.tolist()}
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
    if obstacle.moves and len(times):
        longest = max(float(np.abs(times).max()), 1e-300) / STEPS
        points, frames, _, _ = Motion(obstacle, step=longest).poses(times)
        result["motion"] = {"time": times.tolist(), "point": points.tolist(), "frame": frames.tolist()}
    return result
