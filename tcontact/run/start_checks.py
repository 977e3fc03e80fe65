"""Checks of a run whose first step is known, before it starts."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ..planning.domain import Domain
from ..planning.springs import rates_at_rigid_parts

LATE = 0.01  # velocity that a dashpot takes from a rigid part in a step, over this velocity, that needs no warning


def late_dashpots(domains: Sequence[Domain], dt: float) -> Iterator[str]:
    """Return warnings about dashpots at rigid parts that are strong for a step dt [s].

    They act on the velocity half a step before the time level, which is of first order, and unstable from c W dt = 2.
    """
    for domain in domains:
        for label, rate in rates_at_rigid_parts(domain).items():
            if rate * dt > LATE:
                text = (
                    f"the dashpot of spring {label} takes {rate * dt:.2g} of the velocity of its rigid part in a step"
                )
                text += ", and follows it half a step late: its work errs by about half of that"
                text += "; from 2 on the run blows up" if rate * dt > 1.0 else ""
                yield f"{text}; use a smaller dt or cfl, or damp nodes that no rigid part carries"
