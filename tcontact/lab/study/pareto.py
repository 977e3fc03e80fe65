"""The cheapest method for each level of error."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

LEVELS = tuple(round(m * 10.0**-k, 12) for k in range(7) for m in (1.0, 0.5, 0.2, 0.1))


KEYS = ("method", "size", "cfl")  # what tells runs of a study apart
IDEALS = {"force_variation": 1.0, "total_variation": 1.0, "touches": 1.0}  # measures that are no errors: exact values


def error_of(name: str, value: float) -> float:
    """Return the error of a number of a study: the number itself, or its distance from the exact value."""
    return abs(value - IDEALS[name]) if name in IDEALS else value


def best(rows: Sequence[Mapping[str, Any]], error: str, keys: Sequence[str] = KEYS) -> list[dict[str, Any]]:
    """Return the cheapest run with an `error` (`error_of`) at or below each level, down to the last level reached.

    A run that failed (stopped, changed its energy by more than a tenth, or is wrong by the whole solution) is no
    candidate, however small its error. keys: what tells runs apart.
    """
    runs = [row for row in rows if row.get("ok") and not row.get("failure") and error in row.get("errors", {})]
    found: list[dict[str, Any]] = []
    for level in sorted(set(LEVELS), reverse=True):
        able = [row for row in runs if error_of(error, row["errors"][error]) <= level]
        if not able:
            break
        row = min(able, key=lambda row: row["wall_s"])
        kept = (*keys, "wall_s", "energy_error")
        found.append({"level": level, "value": row["errors"][error]} | {key: row[key] for key in kept})
    return found


def changes(levels: Sequence[Mapping[str, Any]], keys: Sequence[str] = KEYS) -> list[Mapping[str, Any]]:
    """Return the levels of `best` where the cheapest run changes: of several with the same one, the lowest."""
    return [
        row
        for row, following in zip(levels, [*levels[1:], None], strict=False)
        if following is None or any(row[key] != following[key] for key in keys)
    ]
