"""Arrays as text for a page: base64 of little-endian numbers, fields as 16 bits between their ends."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np

STEPS = 65535  # largest number of 16 bits


def text_of(array: np.ndarray, kind: str) -> str:
    """Return the numbers of an array as base64; kind: "f8", "i4" or "u2", little-endian."""
    return base64.b64encode(np.ascontiguousarray(array, dtype="<" + kind).tobytes()).decode("ascii")


def packed(array: np.ndarray, low: float | None = None, high: float | None = None) -> dict[str, Any]:
    """Return values as 16 bits between two ends, None = the smallest and largest finite one; NaN takes the low end."""
    finite = np.isfinite(array)
    low = float(np.min(array, initial=np.inf, where=finite)) if low is None else low
    high = float(np.max(array, initial=-np.inf, where=finite)) if high is None else high
    if not low < high:
        low, high = (low, low + 1.0) if np.isfinite(low) else (0.0, 1.0)
    share = np.clip((np.where(finite, array, low) - low) / (high - low), 0.0, 1.0)
    return {"low": low, "high": high, "data": text_of(np.rint(STEPS * share), "u2")}
