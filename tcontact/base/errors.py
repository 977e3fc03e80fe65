"""Errors a user can act on."""

from __future__ import annotations

import os
import pickle
import re
from collections.abc import Iterable
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Any

LONGEST_PATH = 1024
NUMPY = re.compile(r"\bnp\.(?:\w+\(([^()]*)\)|(True|False)_)")  # prefix of NumPy's numbers in text: np.float64(0.5)


class InputError(ValueError):
    """Bad input, found before anything is allocated or written.

    Names the field, the value it had and what to do instead; `str(error)` is "field = value: remedy".
    """

    def __init__(self, field: str, value: Any, remedy: str) -> None:
        self.field = field
        self.value = value
        self.remedy = remedy
        super().__init__(f"{field} = {_short(value)}: {remedy}")

    def __reduce__(self) -> tuple[Any, ...]:
        """Return what another process makes the error from; a value that cannot go there becomes its text."""
        value = self.value
        try:
            pickle.dumps(value)
        except Exception:  # a lambda, an open file
            value = Shown(_short(value))
        return type(self), (self.field, value, self.remedy)


@dataclass(frozen=True)
class Shown:
    """A text in place of the value of an error: of one that came from another process, or of large arrays."""

    text: str

    def __repr__(self) -> str:
        """Return the text."""
        return self.text


class FunctionError(InputError):
    """A function of the user failed, or returned anything but numbers of the right shape.

    The run stops before the step that called it, with the reason "function-failed".
    """


class OutputError(OSError):
    """A run could not write its output; the text says what, why, what is kept and how to go on.

    result: the `Result` of the run up to its stop, or None.
    """

    result: Any = None


def hint(value: Any, known: Iterable[str]) -> str:
    """Return "did you mean 'cube-impact'? " for a word that is nearly one of those known, else ""."""
    words = {word.lower().replace("_", "-"): word for word in known}
    plain = str(value).lower().replace("_", "-")
    close = [plain] if plain in words else get_close_matches(plain, words, 1)
    return f"did you mean {words[close[0]]!r}? " if isinstance(value, str) and close else ""


def _short(value: Any, limit: int = 80) -> str:
    """Return the value as text in one line, cut if it is long and not a path."""
    try:
        text = repr(value)
    except Exception:  # repr of the object fails, or a number has too many digits
        text = f"<{type(value).__name__}>"
    text = NUMPY.sub(lambda found: found[1] or found[2] or "", text)
    if "\n" in text:  # the rows of an array
        text = " ".join(text.split())
    if len(text) <= limit:
        return text
    path = isinstance(value, (str, Path)) and os.sep in str(value) and str(value).isprintable()
    return text if path and len(text) <= LONGEST_PATH else text[: limit - 3] + "..."
