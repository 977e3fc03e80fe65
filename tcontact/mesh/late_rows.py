"""Rows of an array that are made where they are read: those of some numbers at a time, or all, which are then kept.

They stand where the nodes or cells of a mesh would, for what reads them a portion at a time or only a few of them: a
mesh that follows from something smaller, as that of a box does, then never has arrays of all of them.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import DTypeLike, NDArray

AT_ONCE = 4096  # rows in a portion


class LateRows:
    """Rows [n, k]; made: returns those of numbers [m], an array [m, k]; shape: n, k; dtype: of their values."""

    ndim = 2

    def __init__(
        self, made: Callable[[NDArray[np.integer]], NDArray[Any]], shape: tuple[int, int], dtype: DTypeLike
    ) -> None:
        self.shape, self.dtype = shape, np.dtype(dtype)
        self._made: Callable[[NDArray[np.integer]], NDArray[Any]] | None = made
        self._whole: NDArray[Any] = np.empty((0, shape[1]), dtype)

    @property
    def whole(self) -> NDArray[Any]:
        """All rows; they are kept, and what they were made of is not."""
        made = self._made
        if made is not None:
            result = np.empty(self.shape, self.dtype)
            for first in range(0, len(self), AT_ONCE):
                last = min(first + AT_ONCE, len(self))
                result[first:last] = made(np.arange(first, last))
            self._whole = result
            self._made = None
        return self._whole

    @property
    def late(self) -> bool:
        """Return whether there is no array of all rows."""
        return self._made is not None

    def __len__(self) -> int:
        """Return the number of rows."""
        return self.shape[0]

    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> NDArray[Any]:
        """Return all rows as an array."""
        return np.array(self.whole, dtype=dtype) if copy else np.asarray(self.whole, dtype=dtype)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle all rows, as an array."""
        return np.asarray, (self.whole,)

    def __getitem__(self, chosen: Any) -> NDArray[Any]:
        """Return rows [.., k] by a slice, by numbers [..] or by a mask [n]; or columns of these, by a pair."""
        if self._made is None:
            return np.asarray(self._whole[chosen])
        rows, columns = chosen if isinstance(chosen, tuple) else (chosen, slice(None))
        rows = np.arange(*rows.indices(len(self))) if isinstance(rows, slice) else np.asarray(rows)
        if rows.dtype == bool:
            rows = np.flatnonzero(rows)
        return self.take(rows % len(self) if (rows < 0).any() else rows)[..., columns]

    def take(self, numbers: NDArray[np.integer], axis: int = 0) -> NDArray[Any]:
        """Return the rows of numbers [..], from 0 on: an array [.., k]."""
        assert axis == 0
        made = self._made
        if made is None:
            return self._whole.take(numbers, axis=0)
        numbers = np.asarray(numbers)
        return made(numbers.reshape(-1)).reshape(*numbers.shape, self.shape[1])


Rows: TypeAlias = NDArray[Any] | LateRows


def rows_of(rows: Rows, order: NDArray[np.integer]) -> Rows:
    """Return rows in another order [n]; late ones stay late."""
    if isinstance(rows, LateRows):
        return LateRows(lambda numbers: rows.take(order[numbers]), (len(order), rows.shape[1]), rows.dtype)
    return rows[order]
