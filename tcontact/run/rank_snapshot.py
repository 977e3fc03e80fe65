"""The state of whole bodies on the first rank of a run on several, from what each has of them.

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


class WholeBodies:
    """Puts values of the nodes of all ranks together on the first one; all ranks make it and call it.

    sizes: number of nodes of every body; parts: of the bodies of which this rank has nodes, by their number.
    """

    def __init__(self, team: Team, sizes: Sequence[int], parts: Sequence[tuple[int, BodyPart]]) -> None:
        self.team, self.starts, self.there = team, np.cumsum([0, *sizes]), bool(parts)
        self.rows, numbers = _owned(team.rank, self.starts, parts)
        self.counts = team.gathered(np.array(len(self.rows))).astype(np.int64)
        self.places = team.lead.collected(numbers.__getitem__, self.counts).astype(np.int32)

    def of(self, values: list[np.ndarray]) -> list[np.ndarray]:
        """Return the values [n, 3] of every body on the first rank; values: of the parts of this rank, in order."""
        mine = joined(values) if self.there else np.zeros((0, 3))
        read, placed = (lambda some: mine[self.rows[some]]), self.places.__getitem__
        return np.split(self.team.lead.collected(read, self.counts, placed), self.starts[1:-1])


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
