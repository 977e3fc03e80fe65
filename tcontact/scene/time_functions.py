"""Functions of time that a user gives: constants or callables, whose values are checked and recorded.

A callable is called from t = 0 until up to one step after the duration. The record of its values lets a resumed run
refuse a function that differs from that of the run it goes on with.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.errors import FunctionError, InputError
from .call_record import CallRecord

WORDS = {1: "one finite number", 2: "two finite numbers", 3: "three finite numbers"}


class TimeFunction:
    """A constant or a function of time with `size` values.

    field: its name in messages; value: a number, `size` numbers, None for zero, or a callable(t) that returns these.
    varies: it is a callable; uniform: it may return one number that stands for all; single: it did so last time.
    """

    def __init__(self, field: str, value: Any, size: int = 3, uniform: bool = False) -> None:
        self.field, self.value, self.size, self.uniform = field, value, size, uniform
        self.varies, self.single = callable(value), False
        self.record = CallRecord(size)

    def at(self, times: np.ndarray) -> np.ndarray:
        """Return values [m, size] at times [m] [s]. Raises `FunctionError`."""
        if not self.varies:
            constant = np.zeros(self.size) if self.value is None else np.broadcast_to(self.value, self.size)
            return np.tile(np.asarray(constant, dtype=np.float64), (len(times), 1))
        values = np.array([self._call(float(time)) for time in times]).reshape(len(times), self.size)
        self.record.add(times, self._kept(values))
        return values

    def checkpoint(self) -> dict[str, np.ndarray]:
        """Return the recorded calls."""
        return self.record.checkpoint()

    def restore(self, saved: dict[str, np.ndarray]) -> None:
        """Set the recorded calls. Raises `InputError` if the function now returns other values than in the run."""
        self.record.restore(saved)
        for time, value in zip(self.record.times if self.varies else (), self.record.values, strict=False):
            if not np.array_equal(now := self._kept(self._call(float(time))[None])[0], value):
                remedy = (
                    f"it gives {now.tolist()} at t = {time:.9g} s and gave {value.tolist()} to the run that is to go"
                    " on; resume it as it was, or start a new run elsewhere"
                )
                raise InputError(self.field, self.value, remedy)

    def _kept(self, values: np.ndarray) -> np.ndarray:
        """Return what the record keeps of values [m, size]."""
        return values

    def _given(self, time: float) -> Any:
        """Return what the callable gives at a time [s]."""
        return self.value(time)

    def _call(self, time: float) -> np.ndarray:
        try:
            given = np.array(self._given(time))  # a copy: the callable may return the same array at every call
            result = given if given.dtype.kind not in "iufO" else np.asarray(given, dtype=np.float64)
        except Exception as error:
            raise FunctionError(self.field, self.value, f"the callable failed at t = {time:.9g}: {error}") from error
        self.single = result.shape == ()
        if self.single and (self.size == 1 or self.uniform):
            result = np.full(self.size, result)
        if result.dtype.kind != "f" or result.shape != (self.size,) or not np.isfinite(result).all():
            got = np.array2string(result, threshold=6)
            words = WORDS.get(self.size, f"{self.size} finite numbers")
            words = f"one finite number or {words}" if self.uniform and self.size > 1 else words
            raise FunctionError(self.field, self.value, f"it gave {got} at t = {time:.9g}; return {words}")
        return result
