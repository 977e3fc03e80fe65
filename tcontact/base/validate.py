"""Checks of input; each raises `InputError` naming field, value and remedy."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from numbers import Integral, Real
from pathlib import Path
from typing import Any

import numpy as np

from .errors import InputError, hint

MAXIMUM_STEPS = 1e10  # steps of a run, days even for the smallest scene


def number(
    field: str, value: Any, *, low: float | None = None, high: float | None = None, strict: bool = True
) -> float:
    """Return a finite real number, above `low` and below `high` (strictly, or inclusive with strict=False)."""
    if isinstance(value, bool) or not isinstance(value, Real):
        plain = isinstance(value, np.ndarray) and value.shape == ()
        raise InputError(field, value, "give a plain number: float(..) makes one" if plain else "give a finite number")
    try:
        result = float(value)
    except (OverflowError, ValueError, TypeError) as error:
        raise InputError(field, value, "give a finite number") from error
    if not np.isfinite(result):
        raise InputError(field, value, "give a finite number")
    if low is not None and (result <= low if strict else result < low):
        raise InputError(field, value, f"must be {'greater than' if strict else 'at least'} {low:g}")
    if high is not None and (result >= high if strict else result > high):
        raise InputError(field, value, f"must be {'less than' if strict else 'at most'} {high:g}")
    return result


def keep(owner: Any, field: str, **bounds: Any) -> None:
    """Check a number of a frozen dataclass as `number` does, and keep it there as the float that this returns.

    field: the name of the attribute, after the name of the class and a dot or alone. NumPy takes a whole number beyond
    its own for an object, and a number of single precision would make the others of its kind.
    """
    name = field.rpartition(".")[2]
    object.__setattr__(owner, name, number(field, getattr(owner, name), **bounds))


def whole(field: str, value: Any, low: int, high: int = 2**31 - 1) -> int:
    """Return a whole number from `low` to `high`."""
    if isinstance(value, bool) or not isinstance(value, Integral) or int(value) < low:
        raise InputError(field, value, f"give a whole number of at least {low}")
    if int(value) > high:
        raise InputError(field, value, f"give a whole number of at most {high}")
    return int(value)


def working_directory() -> None:
    """Refuse a process whose working directory was removed."""
    try:
        os.getcwd()
    except FileNotFoundError as error:
        remedy = "was removed; change to a folder that exists: cd, or os.chdir in a script"
        raise InputError("working directory", ".", remedy) from error


def step_count(field: str, dt: float, duration: float) -> None:
    """Refuse a step so small that a run would never end."""
    if not duration / dt <= MAXIMUM_STEPS:  # inf too
        raise InputError(
            field, dt, f"takes more than {MAXIMUM_STEPS:.0e} steps for {duration:g} s; give a longer step or less time"
        )


def vector(field: str, value: Any) -> np.ndarray:
    """Return three finite numbers as a read-only float array [3]."""
    return floats(field, value, (3,))


def floats(field: str, value: Any, shape: tuple[int, ...]) -> np.ndarray:
    """Return finite numbers of this shape as a read-only copy."""
    wanted = f"give finite numbers of shape {list(shape)}"
    try:
        if np.ma.is_masked(value):
            raise TypeError("masked values")
        given = np.asarray(value)
        if isinstance(value, (list, tuple)) and any(isinstance(entry, bool) for entry in value):
            raise TypeError(bool)  # NumPy makes numbers of truth values among numbers
        if given.dtype.kind not in "iufO":  # text, truth values, dates and complex numbers would be converted
            raise TypeError(given.dtype)
        result = np.array(given, dtype=np.float64)
    except Exception as error:  # the object's conversion may raise anything
        raise InputError(field, value, wanted) from error
    if result.shape != shape or not np.isfinite(result).all():
        raise InputError(field, value, wanted)
    result.setflags(write=False)
    return result


def shape_of(field: str, value: Any, remedy: str) -> tuple[int, ...]:
    """Return the shape of a value as NumPy sees it."""
    try:
        return np.shape(value)
    except Exception as error:  # ragged lists, objects without conversion
        raise InputError(field, value, remedy) from error


def file_exists(field: str, path: Path, remedy: str) -> None:
    """Refuse the name of a file that does not exist or that no file can have."""
    try:
        if path.is_file():
            return
    except (OSError, ValueError) as error:
        raise InputError(field, str(path), f"{remedy} ({error})") from error
    raise InputError(field, str(path), remedy)


def path(field: str, value: Any, remedy: str) -> Path:
    """Return a valid path of a file or folder."""
    if not isinstance(value, (str, os.PathLike)):
        raise InputError(field, value, remedy)
    try:
        found = Path(value)
    except TypeError as error:  # of bytes
        raise InputError(field, value, remedy) from error
    if "\0" in str(found):
        raise InputError(field, value, f"{remedy} without null characters")
    return found


def flag(field: str, value: Any) -> bool:
    """Return True or False."""
    if not isinstance(value, bool):
        raise InputError(field, value, "use True or False")
    return value


def words(field: str, value: Any, known: Iterable[str]) -> tuple[str, ...]:
    """Return a list of known words."""
    there = tuple(known)
    remedy = f"give a list of names out of {', '.join(there)}"
    if isinstance(value, str) or not isinstance(value, Sequence):
        raise InputError(field, value, remedy)
    for one in value:
        if not isinstance(one, str) or one not in there:
            raise InputError(field, one, hint(one, there) + remedy)
    return tuple(value)


def parts(field: str, given: Any, kind: type) -> tuple[Any, ...]:
    """Return one or several objects of a public class as a tuple. Raises `InputError`."""
    found = (given,) if isinstance(given, kind) else given
    if not isinstance(found, Sequence) or not all(isinstance(part, kind) for part in found):
        raise InputError(field, given, f"give a list of tcontact.{kind.__name__}")
    return tuple(found)


def is_folder(given: Path) -> bool:
    """Return whether a folder of this name exists; False for invalid names."""
    try:
        return given.is_dir()
    except (OSError, ValueError):
        return False


def choice(field: str, value: Any, known: Iterable[str]) -> str:
    """Return one of the known words."""
    words = tuple(known)
    if not isinstance(value, str) or value not in words:
        raise InputError(field, value, hint(value, words) + "use one of " + ", ".join(repr(word) for word in words))
    return value
