"""A row of figures: the command that makes them, what they are, and where they stand in the report of that command."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

from ...base.errors import InputError

Report = Mapping[str, Any]
Place: TypeAlias = "str | Callable[[Report], Any]"
EXPONENT = re.compile(r"e([-+])0*(\d)")


@dataclass(frozen=True)
class Row:
    """One line of a table of figures.

    command: the words after `tcontact` that leave the report; quantity: what the figures are; form: the text of the
    figures with a format field for each, such as "{:.1e}; {:.3f}"; places: where each figure stands in the report, as
    keys joined by " > " ("checks > energy error" takes the value of that check) or as a function of the report; note:
    text behind the command; short: whether the README shows the row; quick: whether every run of the tests computes
    it.
    """

    command: str
    quantity: str
    form: str
    places: tuple[Place, ...]
    note: str = ""
    short: bool = False
    quick: bool = False

    def figures(self, report: Report) -> str:
        """Return the figures as text. Raises `InputError` where the report does not hold one of them."""
        return short_exponents(self.form.format(*(found(report, place) for place in self.places)))


def found(report: Report, place: Place) -> Any:
    """Return the value at a place of a report; text such as "nan" becomes a number again. Raises `InputError`."""
    if not isinstance(place, str):
        return place(report)
    value: Any = report
    for key in place.split(" > "):
        try:
            if isinstance(value, list):  # checks have names
                value = next(item["value"] for item in value if item["name"] == key)
            else:
                value = value[key]
        except (KeyError, StopIteration, TypeError):
            raise InputError("numbers", place, f"the report has no {key!r}; correct the register") from None
    return value if isinstance(value, (int, float)) else _number(value)


def _number(value: Any) -> Any:
    try:
        return float(value)
    except (TypeError, ValueError):
        return value


def short_exponents(text: str) -> str:
    """Return the text with exponents such as e-03 written as e-3, and without e+00."""
    return EXPONENT.sub(lambda match: f"e{match[1].strip('+')}{match[2]}", text.replace("e+00", ""))
