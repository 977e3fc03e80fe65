"""Docstrings on a page of the site: every parameter begins a line, and formulas stand as they are."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any

import griffe


def plain(text: str) -> str:
    """Return text of a docstring as Markdown: brackets are shapes and units, stars are products, unlike in code."""
    signs = {"<": "&lt;"}
    return re.sub(
        r"`[^`]*`|[\[\]*<]",
        lambda found: found[0] if found[0][0] == "`" else signs.get(found[0], f"\\{found[0]}"),
        text,
    )


def listed(text: str, names: Iterable[str]) -> str:
    """Return text in which the explanations "name: what it is" of some names are the items of a list."""
    known = "|".join(sorted(map(re.escape, names), key=len, reverse=True))
    if not known:
        return plain(text)
    first = rf"(?:^|(?<=[.;]\s)|(?<=\n))((?:{known})(?:,\s(?:{known}))*)((?:\s\[[^\]]*\])?(?:\s[<>]=?\s[^:\s]*)?):\s"
    parts = re.split(first, text)
    found = [plain(parts[0]).rstrip()]
    for label, unit, meaning in zip(parts[1::3], parts[2::3], parts[3::3], strict=True):
        story, gap, rest = meaning.partition("\n\n")
        found.append(f"- **{' '.join(label.split())}**{plain(unit)}: {plain(' '.join(story.split()))}")
        if gap:
            found.append(plain(rest))
    return "\n\n".join(found)


class Readable(griffe.Extension):
    """Changes the docstrings of all functions and classes for the pages of the reference."""

    def on_function(self, *, func: griffe.Function, **_: Any) -> None:
        """Change the docstring of a function. Called by Griffe for every one."""
        if func.docstring is not None:
            func.docstring.value = listed(func.docstring.value, (one.name for one in func.parameters))

    def on_attribute(self, *, attr: griffe.Attribute, **_: Any) -> None:
        """Change the docstring of an attribute or property. Called by Griffe for every one."""
        if attr.docstring is not None:
            attr.docstring.value = plain(attr.docstring.value)

    def on_class_members(self, *, cls: griffe.Class, **_: Any) -> None:
        """Change the docstring of a class whose members are known. Called by Griffe for every one."""
        if cls.docstring is not None:
            cls.docstring.value = listed(cls.docstring.value, cls.attributes)
