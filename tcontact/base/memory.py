"""Memory for the arrays of the kernels, and what is free given back to the system."""

from __future__ import annotations

import ctypes
import gc
from typing import Any

import numpy as np

CACHE_LINE = 64  # bytes


def aligned(count: int, dtype: Any = np.float64) -> np.ndarray:
    """Return a flat array without values that starts on a cache line: vectors of lanes then do not cross two of them.

    count: of its numbers.
    """
    size = count * np.dtype(dtype).itemsize
    room = np.empty(size + CACHE_LINE, dtype=np.uint8)
    first = -room.ctypes.data % CACHE_LINE
    return room[first : first + size].view(dtype)


def give_back() -> None:
    """Give what nothing holds any more back to the system; the C library of Linux keeps pieces below 32 MB."""
    gc.collect()  # objects that hold each other
    try:
        ctypes.CDLL(None).malloc_trim(0)
    except (AttributeError, OSError, TypeError):  # another C library
        return
