"""Terms whose numbers depend on time, which the host computes before anything moves in the rows of a launch."""

from __future__ import annotations

from typing import Protocol


class Timed(Protocol):
    """A term of a domain that functions of time drive.

    Its arrays hold a row for every time level of a launch: row 0 is the present level n, row `number` the level n +
    number. `FunctionError` of `prepare` stops the run at the present level.
    """

    def rows_at_once(self, small: bool) -> int:
        """Return the largest number of rows; small: a launch, or a block of them on a GPU, takes many steps."""
        ...

    def prepare(self, time: float, before: float, after: float, rows: int) -> None:
        """Compute the numbers of levels time, time + after, ... [s]; before [s]: the step that ended at `time`.

        after [s]: step between the levels; 0 after the last row, where only the present level is needed.
        """
        ...
