"""The state of whole bodies on the first rank, at the end of a run on several, from what each has of them.

Frames do not need it where each rank writes its part (part_recorder.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np

from ..device.team import Team
from ..planning.partition.body_part import BodyPart
from ..results.files.late_fields import LateField, Part
from .snapshot import Snapshot


class WholeSnapshot(Snapshot):
    """The state of whole bodies at a level; displacements, velocities: of all of them, see `Snapshot`."""

    def __init__(self, states: Sequence[Any], displacements: list[np.ndarray], velocities: list[np.ndarray]) -> None:
        self.states = list(states)
        self.displacements, self._velocities = displacements, velocities

    @cached_property
    def moved(self) -> list[np.ndarray]:  # type: ignore[override]
        """Return the displacement [n, 3] [m] of every body in the numbering of its plan."""
        return [moved[state.plan.node_order] for moved, state in zip(self.displacements, self.states, strict=True)]

    def displacement_field(self) -> LateField:
        """Return the displacement [n, 3] [m] of all bodies."""
        return _field(self.displacements)

    def velocities(self) -> list[np.ndarray]:
        """Return v^n [n, 3] of every body in the user's numbering."""
        return self._velocities

    def velocity_field(self) -> LateField:
        """Return v^n [n, 3] of all bodies."""
        return _field(self._velocities)


def whole_snapshot(
    team: Team, states: Sequence[Any], parts: Sequence[tuple[int, BodyPart]], own: Snapshot
) -> WholeSnapshot | None:
    """Return the state of whole bodies on the first rank, None on the others; all ranks call it.

    states: views of all bodies; parts: of the bodies of which this rank has nodes, by their number; own: their state.
    """
    starts = np.cumsum([0, *(state.plan.node_count for state in states)])
    mine = [one.part.owner == team.rank for _, one in parts]
    none = np.zeros(0, dtype=np.int64)
    pairs = zip(parts, mine, strict=True)
    numbers = np.concatenate([none, *(starts[number] + one.part.nodes[owned] for (number, one), owned in pairs)])

    def whole(values: list[np.ndarray]) -> list[np.ndarray] | None:
        rows = np.concatenate([np.zeros((0, 3)), *(part[owned] for part, owned in zip(values, mine, strict=True))])
        found = team.put_together(numbers, rows, int(starts[-1]))
        return None if found is None else np.split(found, starts[1:-1])

    displacements = whole(own.displacements)
    velocities = whole(own.velocities())
    if displacements is None or velocities is None:
        return None
    return WholeSnapshot(states, displacements, velocities)


def _field(values: Sequence[np.ndarray]) -> LateField:
    return LateField(tuple(Part("as they are", (own,)) for own in values))
