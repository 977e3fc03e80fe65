"""The state of whole bodies on the first rank, at the end of a run on several, from what each has of them.

Frames do not need it where each rank writes its part (part_recorder.py).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from ..device.team import Team
from ..mesh.geometry import joined
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
    team: Team, states: Sequence[Any], parts: Sequence[tuple[int, BodyPart]], own: Snapshot, last: bool = False
) -> WholeSnapshot | None:
    """Return the state of whole bodies on the first rank, None on the others; all ranks call it.

    states: views of all bodies; parts: of the bodies of which this rank has nodes, by their number; own: their
    state; last: it may forget its displacements.
    """
    starts = np.cumsum([0, *(state.plan.node_count for state in states)])
    rows, numbers = _owned(team.rank, starts, parts)
    counts = team.gathered(np.array(len(rows))).astype(np.int64)
    places = team.lead.collected(numbers.__getitem__, counts).astype(np.int32)

    def whole(values: list[np.ndarray]) -> list[np.ndarray]:
        mine = joined(values) if parts else np.zeros((0, 3))
        found = team.lead.collected(lambda some: mine[rows[some]], counts, places.__getitem__)
        return np.split(found, starts[1:-1])

    displacements = whole([*own.last_displacements()] if last else own.displacements)
    velocities = whole([part.values() for part in own.velocity_field().parts])
    return WholeSnapshot(states, displacements, velocities) if team.leads else None


def _owned(rank: int, starts: np.ndarray, parts: Sequence[tuple[int, BodyPart]]) -> tuple[np.ndarray, np.ndarray]:
    """Return the nodes [k] that a rank owns among those of its parts, and their numbers among all nodes [k].

    starts: first node of every body among all.
    """
    none = np.zeros(0, dtype=np.int32)
    firsts = np.cumsum([0, *(len(one.part.nodes) for _, one in parts)])
    mine = [np.flatnonzero(one.part.owner == rank).astype(np.int32) for _, one in parts]
    numbers = [starts[number] + one.part.nodes[own] for (number, one), own in zip(parts, mine, strict=True)]
    rows = [own + np.int32(first) for own, first in zip(mine, firsts, strict=False)]
    return np.concatenate([none, *rows]), np.concatenate([none, *numbers]).astype(np.int32)


def _field(values: Sequence[np.ndarray]) -> LateField:
    return LateField(tuple(Part("as they are", (own,)) for own in values))
