"""Record the values of a function of time during a run; a resumed run compares those of its function, bit by bit.

The first `MAXIMUM_CALLS` calls are all kept. Then every second one is dropped, and from there on only every second call
is recorded, and so on: of more calls at least half as many are kept, evenly spread over the run. So a different
function is found in runs of up to `MAXIMUM_CALLS` calls (one to four calls a step); in longer ones it is found if it
differs over more than two of the recorded calls.
"""

from __future__ import annotations

import numpy as np

MAXIMUM_CALLS = 2**15


class CallRecord:
    """Times [m] and values [m, size] of the calls of one function."""

    def __init__(self, size: int = 3) -> None:
        self._rows = np.empty((64, 1 + size))
        self._count, self._every, self._calls = 0, 1, 0  # rows kept; calls per row; calls so far

    def add(self, times: np.ndarray, values: np.ndarray) -> None:
        """Record calls at times [m] with values [m, size]."""
        while True:
            chosen = slice(-self._calls % self._every, None, self._every)
            end = self._count + len(times[chosen])
            if end <= len(self._rows):
                break
            if len(self._rows) < MAXIMUM_CALLS:
                self._rows = np.concatenate([self._rows, np.empty_like(self._rows)])
            else:
                kept = self._rows[: self._count : 2].copy()
                self._count, self._every = len(kept), 2 * self._every
                self._rows[: self._count] = kept
        self._rows[self._count : end, 0] = times[chosen]
        self._rows[self._count : end, 1:] = values[chosen]
        self._count, self._calls = end, self._calls + len(times)

    @property
    def times(self) -> np.ndarray:
        """Times [m] [s] of the calls that are kept."""
        return self._rows[: self._count, 0]

    @property
    def values(self) -> np.ndarray:
        """Values [m, size] of the calls that are kept."""
        return self._rows[: self._count, 1:]

    def checkpoint(self) -> dict[str, np.ndarray]:
        """Return the calls and their thinning."""
        counters = np.array([self._every, self._calls])
        return {"calls": self._rows[: self._count].copy(), "counters": counters}

    def restore(self, saved: dict[str, np.ndarray]) -> None:
        """Set the state that `checkpoint` returned."""
        self._every, self._calls = (int(number) for number in saved["counters"])
        self._count = len(saved["calls"])
        size = 64
        while size < self._count:
            size *= 2
        self._rows = np.empty((size, self._rows.shape[1]))
        self._rows[: self._count] = saved["calls"]
