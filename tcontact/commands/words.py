"""Readers of the words of the command line; each says what it wants (`argparse.ArgumentTypeError`, exit code 2)."""

from __future__ import annotations

import argparse
import importlib
import math
import re
import runpy
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeVar

from ..device.atomic_file import lost_link

T = TypeVar("T")
NEGATIVE = re.compile(r"-(\d|\.\d|inf|nan)")  # how a number, or a list of them, begins that begins with a minus sign


def joined(words: Sequence[str]) -> list[str]:
    """Return the words of a command line, in which `--range -1,1` has become `--range=-1,1`.

    argparse takes a word that begins with a minus sign for another option, unless it is a plain number.
    """
    found: list[str] = []
    for word in words:
        option = found[-1] if found and "--" not in found else ""
        if NEGATIVE.match(word) and option.startswith("--") and "=" not in option:
            found[-1] = f"{option}={word}"
        else:
            found.append(word)
    return found


def count(text: str) -> int:
    """Read a whole number, 0 or more."""
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"{text!r}: give a whole number, 0 or more")
    return int(text)


def whole(text: str) -> int:
    """Read a whole number, 1 or more."""
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r}: give whole numbers, 1 or more")
    return int(text)


def folder(text: str) -> Path:
    """Read the name of a folder."""
    if not text.strip():
        raise argparse.ArgumentTypeError(f"{text!r}: give the name of a folder, '.' for this one")
    return _reachable(text, Path(text))


def file(text: str) -> Path:
    """Read the name of a file to write."""
    if not text.strip():
        raise argparse.ArgumentTypeError(f"{text!r}: give the name of a file")
    _reachable(text, Path(text).parent)
    return Path(text)


def _reachable(text: str, place: Path) -> Path:
    """Return a place after refusing one where no folder can be made, since a link to nothing stands there."""
    remedy = lost_link(place)
    if remedy is not None:
        raise argparse.ArgumentTypeError(f"{text!r}: {remedy}")
    return place


def number(text: str) -> float:
    """Read a finite number."""
    value = _float(text)
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{text!r}: give a number")
    return value


def positive(text: str) -> float:
    """Read a number above 0."""
    value = _float(text)
    if not 0.0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r}: give numbers above 0")
    return value


def not_negative(text: str) -> float:
    """Read a number, 0 or more."""
    value = _float(text)
    if not 0.0 <= value < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r}: give a number, 0 or more")
    return value


def module(text: str) -> str:
    """Run a Python file, or import a module, and return its name."""
    try:
        if text.endswith(".py"):
            runpy.run_path(text, run_name=Path(text).stem)
        else:
            importlib.import_module(text)
    except Exception as error:
        raise argparse.ArgumentTypeError(f"{text!r} cannot be run: {type(error).__name__}: {error}") from error
    return text


def names(text: str) -> list[str]:
    """Read words between commas, each once."""
    return list(dict.fromkeys(part.strip() for part in text.split(",") if part.strip()))


def several(convert: Callable[[str], T]) -> Callable[[str], list[T]]:
    """Return a function that reads values between commas, each once."""

    def read(text: str) -> list[T]:
        return list(dict.fromkeys(convert(part.strip()) for part in text.split(",")))

    return read


def _float(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan
