"""Checks shared by everything a user hands in; each raises `InputError` naming field, value and remedy."""

from __future__ import annotations

from collections.abc import Iterable
from numbers import Integral, Real
from typing import Any

import numpy as np

from .errors import InputError


def number(
    field: str, value: Any, *, low: float | None = None, high: float | None = None, strict: bool = True
) -> float:
    """A finite real number, above `low` and below `high` (strictly, or inclusive with strict=False)."""
    if isinstance(value, bool) or not isinstance(value, Real) or not np.isfinite(float(value)):
        raise InputError(field, value, "give a finite number")
    result = float(value)
    if low is not None and (result <= low if strict else result < low):
        raise InputError(field, value, f"must be {'greater than' if strict else 'at least'} {low:g}")
    if high is not None and (result >= high if strict else result > high):
        raise InputError(field, value, f"must be {'less than' if strict else 'at most'} {high:g}")
    return result


def whole(field: str, value: Any, low: int) -> int:
    """A whole number of at least `low`."""
    if isinstance(value, bool) or not isinstance(value, Integral) or int(value) < low:
        raise InputError(field, value, f"give a whole number of at least {low}")
    return int(value)


def vector(field: str, value: Any) -> np.ndarray:
    """Three finite numbers, as a read-only float array [3]."""
    return floats(field, value, (3,))


def floats(field: str, value: Any, shape: tuple[int, ...]) -> np.ndarray:
    """Finite numbers of the given shape, as a read-only copy."""
    wanted = f"give finite numbers of shape {list(shape)}"
    try:
        result = np.array(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(field, value, wanted) from error
    if result.shape != shape or not np.isfinite(result).all():
        raise InputError(field, value, wanted)
    result.setflags(write=False)
    return result


def choice(field: str, value: Any, known: Iterable[str]) -> str:
    """One of the known words."""
    words = tuple(known)
    if not isinstance(value, str) or value not in words:
        raise InputError(field, value, "use one of " + ", ".join(repr(word) for word in words))
    return value
