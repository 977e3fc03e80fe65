"""The state of whole bodies on the first rank, at the end of a run on several, from what each has of them.

Frames do not need it where each rank writes its part (part_recorder.py).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
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

    def last_displacements(self) -> Iterator[np.ndarray]:
        """Yield the displacement [n, 3] [m] of every body, which the snapshot then forgets."""
        while self.displacements:
            yield self.displacements.pop(0)

    def displacement_field(self) -> LateField:
        """Return the displacement [n, 3] [m] of all bodies."""
        return _field(self.displacements)

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
    mine = [np.flatnonzero(one.part.owner == team.rank) for _, one in parts]
    none = np.zeros(0, dtype=np.int64)
    pairs = zip(parts, mine, strict=True)
    numbers = np.concatenate([none, *(starts[number] + one.part.nodes[owned] for (number, one), owned in pairs)])
    counts = team.gathered(np.array(len(numbers))).astype(np.int64)
    everyone = team.lead.collected(numbers.__getitem__, counts).astype(np.int32)

    def whole(values: list[np.ndarray]) -> list[np.ndarray]:
        rows = np.concatenate([np.zeros((0, 3)), *(part[owned] for part, owned in zip(values, mine, strict=True))])
        found = team.lead.collected(rows.__getitem__, counts, everyone.__getitem__)
        return np.split(found, starts[1:-1])

    displacements = whole(own.displacements)
    velocities = whole([part.values() for part in own.velocity_field().parts])
    return WholeSnapshot(states, displacements, velocities) if team.leads else None


def _field(values: Sequence[np.ndarray]) -> LateField:
    return LateField(tuple(Part("as they are", (own,)) for own in values))
