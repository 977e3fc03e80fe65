"""The frame of a run that shows its contact best: the one with the largest contact force."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ...results.acting_force import acting_force
from ...results.files.vtkhdf import Frame, ResultData
from .labels import prefix_of


class KeyFrame(NamedTuple):
    """The frame with the largest contact force.

    note: that force, the partner that it belongs to, and the time, in words; push: direction [3] in which obstacles
    push on the bodies, None where that is not known.
    """

    frame: Frame
    note: str
    push: np.ndarray | None


def key_frame(data: ResultData, read: Callable[[int], Frame], alone: bool) -> KeyFrame | None:
    """Return the frame with the largest contact force, None where no frame has one.

    Of several obstacles or pairs it is the force of the one with the largest in the run, out of the history, as their
    forces cancel in the sum over the nodes. Files without a history give the sum of the sizes of the forces of nodes.
    read: reads a frame by its number; alone: the run has one body and one obstacle.
    """
    count, history, times = len(data), data.history, np.asarray(data.times)
    sums = [_sum(read(index)) for index in range(count)]
    sizes = [float(np.nan_to_num(np.linalg.norm(one), posinf=0.0)) for one in sums]
    pushes, partner, known = sums, "", "contact_force" in data.point_fields
    if "contact_force" in history and len(history["time"]):
        acting = acting_force(history)
        if acting.several:
            # between two rows where the history does not keep that of the frame
            forces = np.stack([np.interp(times, history["time"], axis) for axis in acting.force.T], axis=1)
            sizes = np.nan_to_num(np.linalg.norm(forces, axis=1), posinf=0.0).tolist()
            pushes, partner, known = (sums if acting.of_pair else list(forces)), acting.partner, True
    elif known and not alone:
        sizes = [_sum_of_sizes(read(index)) for index in range(count)]
        known = False
    if max(sizes, default=0.0) == 0.0:
        return None
    index = int(np.argmax(sizes))
    force = f": {_shown(sizes[index], 'N', 3)}{partner}" if known else ""
    push = np.asarray(pushes[index]) if np.ndim(pushes[index]) else np.zeros(3)
    length = float(np.linalg.norm(push))
    return KeyFrame(
        read(index),
        f"contact force in this frame{force} at {_shown(float(times[index]), 's', 4)}",
        push / length if 0.0 < length < np.inf else None,
    )


def _sum(frame: Frame) -> np.ndarray:
    """Return the sum [3] of the contact forces of all nodes, or that of the pressures where the frame has no forces."""
    nodal = frame.point_data
    return np.asarray(
        nodal["contact_force"].sum(axis=0) if "contact_force" in nodal else nodal["contact_pressure"].sum()
    )


def _sum_of_sizes(frame: Frame) -> float:
    """Return the sum of the lengths of the contact forces of all nodes."""
    sizes = np.linalg.norm(frame.point_data["contact_force"], axis=1)
    return float(np.sum(sizes, where=np.isfinite(sizes)))


def _shown(value: float, unit: str, digits: int) -> str:
    factor, prefix = prefix_of(value)
    return f"{value / factor:.{digits}g} {prefix}{unit}"
