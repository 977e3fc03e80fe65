"""Guards and looks of a run on several ranks that read whole bodies: the first rank has them, and tells.

The others follow (device/lead.py) and take its decisions.
"""

from __future__ import annotations

from typing import Any

from ..device.lead import Lead
from .guards import Guards, Stop
from .history import History
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

    def is_fast(self, history: History) -> bool:
        """Return whether bodies may have had a shock, see `Guards.is_fast`."""
        return self.lead.decide(lambda: super(RankGuards, self).is_fast(history))

    def worst(self, step: float, failing: bool = False) -> tuple[str, str]:
        """Return law and place of the worst cell, see `Guards.worst`."""
        return self.lead.decide(lambda: super(RankGuards, self).worst(step, failing))


class RankLooks(Looks):
    """The looks of the first rank; on the others there are as many without content.

    Behind each look the first rank tells when the next ones are due, so that the others need not ask before.
    """

    def __init__(self, lead: Lead, run: Run) -> None:
        self.lead = lead
        self._next_looks: tuple[int, int] | None = None  # row of the next one; rows of a launch from row 0 on
        count = lead.decide(lambda: self._made(run))
        if not lead.leads:
            self.looks = [None] * count  # type: ignore[list-item]

    def _made(self, run: Run) -> int:
        super().__init__(run)
        return len(self.looks)

    def _next(self) -> tuple[int, int]:
        return min(one.due for one in self.looks), super().rows(0)

    def rows(self, number: int) -> int:
        """Return the largest number of rows of a launch, see `Looks.rows`."""
        if not self.looks:
            return super().rows(number)
        if self._next_looks is None:
            self._next_looks = self.lead.decide(self._next)
        return max(1, self._next_looks[1] - number)

    def entered(self) -> str:
        """Return which bodies have met so, see `Looks.entered`."""
        return self.lead.decide(super().entered) if self.looks else ""

    def take(self, run: Run, row: int, time: float, step: float) -> Stop | None:
        """Take the looks due after a row, see `Looks.take`."""
        if not self.looks or (self._next_looks is not None and row < self._next_looks[0] and step != 0.0):
            return None
        take = super().take
        stop, self._next_looks = self.lead.decide(lambda: (take(run, row, time, step), self._next()))
        return stop
