"""The extent of a motion: what a picture must hold of bodies that move, stretch, fly apart or blow up.

Of a run that ended well every frame counts, however far bodies have gone. Of any other run a frame counts while no body
is more than `GROWN` times as large as at the start; where bodies are does not matter. Without such a frame it is what
lies around the middle of each body.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

GROWN = 3.0  # times its size at the start, above which a body has blown up
SOUND = ("finished", "interrupted", "function-failed")  # reasons of an end that leave bodies in their shapes


def most_sizes(start: np.ndarray, bodies: Sequence[np.ndarray], reason: str | None, scale: float) -> list[float]:
    """Return the size [m] above which each body counts as blown up; infinity after a run that ended well.

    start [s,3]: points at the start; bodies: the points of each; scale: factor on deformations.
    """
    if reason in SOUND:
        return [np.inf] * len(bodies)
    return [GROWN * max(1.0, abs(scale)) * _size(start[nodes]) for nodes in bodies]


def extent(states: Iterable[np.ndarray], bodies: Sequence[np.ndarray], most: Sequence[float]) -> np.ndarray:
    """Return points [k,3] whose hull holds the bodies in these states [s,3], but for states of a body blown up.

    most: the size of each body above which it has blown up. Without a finite point there are none.
    """
    rng = np.random.default_rng(0)
    ways = np.concatenate([np.eye(3), rng.normal(size=(29, 3))])
    whole, near = [], [np.empty((0, 3))]
    for x in states:
        pairs = [(x[nodes], size) for nodes, size in zip(bodies, most, strict=True)]
        if all(np.isfinite(points).all() and _size(points) <= size for points, size in pairs):
            whole.append(_corners(x, ways))
        elif not whole:
            near += [_corners(_near_middle(points, size), ways) for points, size in pairs]
    return np.concatenate(whole or near)


def _size(points: np.ndarray) -> float:
    """Return the length [m] of the box around points, corner to corner."""
    with np.errstate(all="ignore"):
        return float(np.linalg.norm(np.ptp(points, axis=0)))


def _corners(points: np.ndarray, ways: np.ndarray) -> np.ndarray:
    """Return those of the points that lie farthest in each way and against it."""
    if len(points) == 0:
        return points
    along = points @ ways.T
    return points[np.concatenate([along.argmin(axis=0), along.argmax(axis=0)])]


def _near_middle(points: np.ndarray, reach: float) -> np.ndarray:
    """Return the finite points within a reach [m] of the middle of most of them, or all that are finite if none is."""
    finite = points[np.isfinite(points).all(axis=1)]
    if len(finite) == 0:
        return finite
    with np.errstate(all="ignore"):
        near = finite[np.linalg.norm(finite - np.median(finite, axis=0), axis=1) <= reach]
    return near if len(near) else finite
