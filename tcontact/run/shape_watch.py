"""Follow the stable step by the shape of the cells between two estimates by Lanczos (METHOD 2).

The estimate of every body goes on as the square root of its largest shape rate (kernels/cells/shape_rate.py): the
stable step falls as cells flatten or shear, also where their volume stays. A look measures the rates, now and with the
motion since the last look continued; the next look comes before half of the room between the step and the stable one
can be used up, and a new estimate once it is.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ..cells.shape_rates import ShapeRates
from ..schemes.explicit.stable_step import StableSteps

APART = 256  # maximum number of rows between looks
APART_WITH_STATE = 8  # the same where points of a law with state can flow
FARTHER = 4  # largest growth of the interval from look to look
TOUCHING = 1.5  # growth of the number of nodes in contact that asks for a look at once


class ShapeWatch:
    """Looks at the shape of the cells of all domains with nonlinear laws, which their `StableSteps` estimate.

    domains: those that are looked at; factor: present stable step over that of the last estimate; due: row after which
    the next look is wanted.
    """

    def __init__(self, domains: Sequence[Any], limits: Sequence[StableSteps]) -> None:
        pairs = [(one, limit) for one, limit in zip(domains, limits, strict=True) if not _linear(one)]
        self.domains, self._limits = [one for one, _ in pairs], [limit for _, limit in pairs]
        self._rates = [  # the trial displacement of an estimate serves between the estimates
            ShapeRates(one.domain, one.internal_force, one.u, limit.trial) for one, limit in pairs
        ]
        # of whole bodies: a rank need not have cells of each
        plastic = any(law.plastic for one, _ in pairs for view in one.views for law in view.plan.body.materials)
        self._apart = APART_WITH_STATE if plastic else APART
        self.factor, self.due, self._seen, self._touching = 1.0, 0, -1, 0.0
        self._start = [np.zeros(len(limit.bodies)) for limit in self._limits]
        self.anchor(-1)

    def anchor(self, number: int) -> None:
        """Start from the shape after row `number`, at which the stable step has just been estimated."""
        self.factor, self._seen = 1.0, number
        for rates in self._rates:
            rates.remember()
        for measured, start in zip(self._measured(0.0), self._start, strict=True):
            start[:] = measured[0]

    def _measured(self, ahead: float) -> list[np.ndarray]:
        """Return the rates [2, bodies] of every domain, see `ShapeRates.measure`."""
        pairs = zip(self.domains, self._rates, strict=True)
        return [domain.over_ranks(rates.measure(ahead)) for domain, rates in pairs]

    def touching_limit(self) -> float:
        """Return the number of nodes in contact above which a look is wanted at once."""
        return TOUCHING * self._touching

    def wanted(self, number: int, touching: float) -> bool:
        """Return whether a look is wanted after a row; touching: nodes in contact then."""
        return number >= self.due or touching > self.touching_limit()

    def look(self, number: int, touching: float, step: float, limit: Callable[[float], float]) -> bool:
        """Look after row `number` and return whether the stable step must be estimated anew.

        touching: nodes in contact; step [s]: the present one; limit(factor): the stable step [s] with that factor.
        """
        past, onset = max(1, number - self._seen), touching > self.touching_limit()
        rows = 1 if onset else min(FARTHER * past, self._apart)
        self.factor, foreseen = self._factors(rows / past)
        for rates in self._rates:
            rates.remember()
        self._seen, self._touching = number, max(touching, 0.5 * self._touching)
        low = float(np.sqrt(limit(1.0) * step))  # half of the room is used up
        used = not limit(self.factor) >= low
        if limit(foreseen) < low and not used:
            share = np.log(limit(self.factor) / low) / np.log(limit(self.factor) / max(limit(foreseen), 1e-3 * low))
            rows = max(1, int(share * rows))
        self.due = number + (1 if used else rows)
        return used

    def _factors(self, ahead: float) -> tuple[float, float]:
        """Return `factor` now and with the motion since the last look continued by `ahead` times itself."""
        found = np.full(2, np.inf)
        for measured, limit, start in zip(self._measured(ahead), self._limits, self._start, strict=True):
            growth = np.maximum(measured, start) / np.where(start > 0.0, start, 1.0)
            steps = np.array([body.elastic for body in limit.bodies]) / np.sqrt(np.maximum(growth, 1.0))
            found = np.minimum(found, steps.min(axis=1))
        before = min(limit.elastic for limit in self._limits)
        return float(found[0] / before), float(found[1] / before)


def _linear(domain: Any) -> bool:
    """Return whether all bodies of a domain's state are linear."""
    return all(view.plan.body.linear for view in domain.views)
