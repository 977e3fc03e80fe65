"""Tables of figures inside Markdown pages: find them, compare them with new ones, replace them.

A table stands between the lines `<!-- tcontact numbers: NAME -->` and `<!-- end -->`.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from itertools import zip_longest
from pathlib import Path

from ...base.errors import InputError

PAGES = ("README.md", "docs/NUMBERS.md")
TABLE = re.compile(r"<!-- tcontact numbers: ([a-z-]+) -->\n(.*?)<!-- end -->\n", re.DOTALL)
NUMBER = re.compile(r"(?<![\w.^])-?\d+(?:\.\d+)?(?:e-?\d+)?(?![\w^])")
ROUNDING = 1e-11  # figures below it say that something holds to rounding: they only have to stay below it


def tables(root: Path) -> dict[str, list[str]]:
    """Return the lines of every table in the pages below `root`, by name. Raises `InputError` if a page is missing."""
    found: dict[str, list[str]] = {}
    for page in PAGES:
        found |= {name: text.splitlines() for name, text in TABLE.findall(_read(root / page))}
    return found


def replace(root: Path, new: Mapping[str, Sequence[str]]) -> list[Path]:
    """Put the new lines into the tables of their names; return the pages that changed."""
    changed = []
    for page in PAGES:
        path = root / page
        old = _read(path)
        text = TABLE.sub(
            lambda match: (
                f"<!-- tcontact numbers: {match[1]} -->\n"
                + ("".join(f"{line}\n" for line in new[match[1]]) if match[1] in new else match[2])
                + "<!-- end -->\n"
            ),
            old,
        )
        if text != old:
            path.write_text(text, encoding="utf-8")
            changed.append(path)
    return changed


def differs(stated: str, present: str) -> bool:
    """Tell whether a line of a page says something else than the new one.

    The words must be the same. A number may differ by one unit of its last digit, and two below 1e-11 are both
    rounding.
    """
    if NUMBER.sub("#", stated) != NUMBER.sub("#", present):
        return True
    pairs = zip(NUMBER.findall(stated), NUMBER.findall(present), strict=True)
    return any(abs(float(a) - float(b)) > 1.001 * max(_unit(a), _unit(b)) and not _tiny(a, b) for a, b in pairs)


def different(stated: Sequence[str], present: Sequence[str]) -> list[tuple[str, str]]:
    """Return pairs of lines, stated and new, that differ; a line without a partner stands beside an empty one."""
    pairs = zip_longest(stated, present, fillvalue="")
    return [(old, new) for old, new in pairs if differs(old, new)]


def _tiny(first: str, second: str) -> bool:
    return max(abs(float(first)), abs(float(second))) < ROUNDING


def _unit(number: str) -> float:
    """Return one unit of the last digit of a number as it is written."""
    digits, _, exponent = number.partition("e")
    return float(10.0 ** (int(exponent or 0) - len(digits.partition(".")[2])))


def _read(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except OSError as error:
        raise InputError("--docs", str(path), "no such page; name the folder that holds README.md and docs/") from error
