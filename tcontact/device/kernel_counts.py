"""How many kernels a run compiles: known from the last run of the same kind, and kept for the next one.

Kernels come into being one by one, as they are first called; how many there will be is not known before. Files: a text
of numbers by kind of run in the user's cache folder; where it cannot be read or written, nothing is known.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from .runtime import user_cache
from .tracing import kernels

FILE = "kernel-counts.json"
MOST = 500  # kinds of runs that are kept


@contextmanager
def counted(about: str) -> Iterator[None]:
    """Look up how many kernels a run compiles, and store how many it compiled inside.

    about: what decides which kernels the run has.
    Only the first run of a process counts: a later one shares kernels with it.
    """
    if kernels.so_far > 0:
        yield
        return
    kind = hashlib.sha256(about.encode()).hexdigest()[:16]
    kernels.expected = _known().get(kind, 0)
    try:
        yield
    finally:
        if kernels.so_far not in (0, kernels.expected):
            _store(kind, kernels.so_far)
        kernels.expected = 0


def _known() -> dict[str, int]:
    """Return the stored numbers; none where the file is missing or is something else."""
    with suppress(OSError, ValueError):
        found = json.loads((user_cache() / FILE).read_text(encoding="utf-8"))
        if isinstance(found, dict):
            return {str(kind): count for kind, count in found.items() if isinstance(count, int)}
    return {}


def _store(kind: str, count: int) -> None:
    """Store a number as the newest one, in a file that takes the place of the old one at once."""
    known = _known()
    known.pop(kind, None)
    known = dict(list(known.items())[-MOST + 1 :]) | {kind: count}
    path = user_cache() / FILE
    beside = path.with_name(f"{FILE}.{os.getpid()}")
    with suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        beside.write_text(json.dumps(known), encoding="utf-8")
        beside.replace(path)
