"""Guards, looks and states of a run on several ranks that read whole bodies: the first rank has them, and tells.

The others follow (device/lead.py) and take its decisions.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..device.lead import Lead
from ..results.files.late_fields import Part
from .guards import Guards, Stop
from .snapshot import Snapshot
from .watched import Run
from .watches.looks import Looks


class RankGuards(Guards):
    """Guards, of which the first rank measures whole bodies."""

    def __init__(self, lead: Lead, *given: Any) -> None:
        self.lead = lead
        super().__init__(*given)

    def rounding(self) -> float:
        """Return the energy [J] up to which a change is rounding."""
        return self.lead.decide(super().rounding)

    def worst(self, step: float, failing: bool = False) -> tuple[str, str]:
        """Return law and place of the worst cell, see `Guards.worst`."""
        return self.lead.decide(lambda: super(RankGuards, self).worst(step, failing))


class RankLooks(Looks):
    """The looks of the first rank; on the others there are as many without content."""

    def __init__(self, lead: Lead, run: Run) -> None:
        self.lead = lead
        count = lead.decide(lambda: self._made(run))
        if not lead.leads:
            self.looks = [None] * count  # type: ignore[list-item]

    def _made(self, run: Run) -> int:
        super().__init__(run)
        return len(self.looks)

    def rows(self, number: int) -> int:
        """Return the largest number of rows of a launch, see `Looks.rows`."""
        if not self.looks:
            return super().rows(number)
        return self.lead.decide(lambda: super(RankLooks, self).rows(number))

    def take(self, run: Run, row: int, time: float, step: float) -> Stop | None:
        """Take the looks due after a row, see `Looks.take`."""
        if not self.looks:
            return None
        return self.lead.decide(lambda: super(RankLooks, self).take(run, row, time, step))


class RankSnapshot(Snapshot):
    """The state at a level on the first rank, for which every rank keeps the velocity of its nodes before the kick."""

    states: list[Any]

    def _held(self, values: np.ndarray) -> np.ndarray:
        """Return the values, which are the snapshot's own, as they have been collected."""
        return values

    def _half(self, state: Any) -> np.ndarray:
        """Let all ranks keep the velocity of their nodes; return none of it."""
        state.keep_velocity()
        return np.zeros((0, 3))

    def _velocity(self, state: Any, old: np.ndarray, massless: np.ndarray | None) -> Part:
        """Return v^n of a body, which all ranks compute; old: not here."""
        plan = state.plan
        if plan.images is not None:
            return Part("as they are", (state.velocity(state.level_velocity(self.share), massless),))
        level = state.level_velocity(self.share, True)
        if massless is not None and plan.contact is not None:
            level[plan.node_order[plan.contact.nodes]] += massless
        return Part("as they are", (level,))


class Elsewhere(Snapshot):
    """The state at a level on a rank other than the first: the first one has it."""

    def __init__(self, states: Sequence[Any]) -> None:
        self.states = list(states)
