"""Aligned columns of text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

WORDS = ("kind", "law", "contact", "method")


def columns(rows: Sequence[Mapping[str, str]]) -> list[str]:
    """Return rows of named texts as aligned columns, words to the left, figures to the right."""
    if not rows:
        return []
    names = list(dict.fromkeys(name for row in rows for name in row))
    widths = [max(len(name), *(len(row.get(name, "")) for row in rows)) for name in names]
    table = [dict(zip(names, names, strict=True)), *rows]
    return [
        "  ".join(
            f"{row.get(name, ''):<{width}}" if name in WORDS else f"{row.get(name, ''):>{width}}"
            for name, width in zip(names, widths, strict=True)
        ).rstrip()
        for row in table
    ]
