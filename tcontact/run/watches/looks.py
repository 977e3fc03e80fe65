"""Looks: checks of a run between launches, besides the guards of every row, one object for each."""

from __future__ import annotations

from typing import Protocol

from ...base.errors import FunctionError
from ..guards import Stop
from ..watched import Run
from .body_meeting import BodyMeeting
from .far_watch import FarWatch
from .linear_watch import LinearWatch
from .normal_watch import NormalWatch
from .pair_overlap import PairOverlap
from .path_watch import PathWatch

FOREVER = 2**62


class Look(Protocol):
    """A check of a run between launches.

    due: the row after which the next look is wanted; ends_launches: whether a launch of several rows has to end there.
    """

    due: int
    ends_launches: bool

    def look(self, run: Run, row: int, time: float, step: float) -> Stop | None:
        """Check the bodies after that row; step [s]: the step since, which led to their present positions."""
        ...


class Looks:
    """The looks that a scene needs, none for most scenes."""

    def __init__(self, run: Run) -> None:
        bodies: list[Look | None] = [BodyMeeting.of(run), PairOverlap.of(run)]
        found = [*bodies, PathWatch.of(run), FarWatch.of(run), NormalWatch.of(run), LinearWatch.of(run)]
        self.looks = [one for one in found if one is not None]

    def rows(self, number: int) -> int:
        """Return the largest number of rows of a launch that starts at that row, up to the next look."""
        return max(1, min((one.due for one in self.looks if one.ends_launches), default=FOREVER) - number + 1)

    def entered(self) -> str:
        """Return which bodies of pairs met with faces that contact does not hold, with the remedy; "" for none."""
        return "".join(one.entered.found for one in self.looks if isinstance(one, PairOverlap))

    def take(self, run: Run, row: int, time: float, step: float) -> Stop | None:
        """Take the looks due after a row, all of them after the last (step = 0). Returns a stop or None."""
        for one in self.looks:
            if row >= one.due or step == 0.0:
                try:
                    stop = one.look(run, row, time, step)
                except FunctionError as error:
                    kept = f"stopped at t = {time:.6g} s; everything up to then is kept"
                    stop = Stop("function-failed", f"{error}; {kept}")
                if stop is not None:
                    return stop
        return None
