"""Errors a user can act on."""

from __future__ import annotations

from typing import Any


class InputError(ValueError):
    """Bad input, found before anything is allocated or written.

    Names the field, the value it had and what to do instead; `str(error)` is "field = value: remedy".
    """

    def __init__(self, field: str, value: Any, remedy: str) -> None:
        self.field = field
        self.value = value
        self.remedy = remedy
        super().__init__(f"{field} = {_short(value)}: {remedy}")


class OutputError(OSError):
    """A run could not write its output: what it could not write, why, what is kept and how to go on."""


def _short(value: Any, limit: int = 80) -> str:
    text = repr(value)
    return text if len(text) <= limit else text[: limit - 3] + "..."
