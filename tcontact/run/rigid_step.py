"""Follow the stable step of obstacles that move freely: it falls before they touch, and grows when they have left."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..schemes.explicit.stable_step import with_rigid

AHEAD = 4.0  # steps of the free bodies within which a node must be able to touch, to count
CLOSE = 0.95  # a step larger than this share of the stable one is shortened
RESOLVED = 0.15  # largest w dt at cfl 1: a contact that begins within a step changes the energy by up to (w dt)^2/4
LARGER = 1.5  # a step grows where the stable one allows at least this many times as much


class RigidStep:
    """The stable step of the nodes and the free obstacles of a run.

    Every row measures the rate w^2 of the obstacles on the nodes that they press or may soon press
    (kernels/step/rigid_rate.py). The step is stable below 2/(4/dt_nodes^2 + w^2)^1/2, and kept below RESOLVED/w besides
    unless the user has set it: the impact of a light body would last for two or three stable steps.
    """

    def __init__(self, run: Any, domain: Any) -> None:
        self.domain = domain
        self.place = run.history.layout.place["rigid_rate"].start
        self._nodes = 0.0  # stable step of the nodes alone at the last row [s]

    @staticmethod
    def of(run: Any) -> RigidStep | None:
        """Return the watch of a run; None if no obstacle that can touch something moves freely."""
        for domain in run.domains:
            if not run.scheme.implicit and domain.frees:
                return RigidStep(run, domain)
        return None

    def begin(self, run: Any) -> None:
        """Choose the first step: a row at the start, which moves nothing, gives the rate."""
        self._reach(AHEAD * run.dt, run.dt)
        run.scheme.step(self.domain, 0.0, 0.0, 0.0)
        row = self.domain.rows(np.zeros(1))[-1]
        if run.keep_below(self._limit(run, row)):
            self._reach(AHEAD * float(run.scheme.step_size(run.node_limit(row))), run.dt)
            run.scheme.begin(self.domain, run.dt)

    def _reach(self, time: float, step: float) -> None:
        """Set the time [s] within which a node must be able to touch, to count, where the obstacles are."""
        if self.domain.rigid is not None:
            self.domain.rigid.set_reach(time, step)

    def follow(self, run: Any, row: np.ndarray) -> None:
        """Shorten the step where the row asks for it; let it grow where the obstacles have left."""
        limit = self._limit(run, row)
        if run.keep_below(limit) or run.scheme.dt is not None or run.over_limit:
            return
        largest = run.scheme.step_size(limit)
        if largest > LARGER * run.dt:
            run.dt = largest

    def largest_rate(self, run: Any) -> float:
        """Return the rate [1/s^2] above which the present step is too close to the limit."""
        step = run.dt / CLOSE
        stable = max(0.0, 4.0 / step**2 - 4.0 / self._nodes**2)
        if run.scheme.dt is not None:
            return stable
        return min(stable, self._stiffer(run) * (RESOLVED / step) ** 2)

    def _limit(self, run: Any, row: np.ndarray) -> float:
        """Return the limit of the step [s] at a row."""
        rate, self._nodes = float(row[self.place]), run.node_limit(row)
        stable = with_rigid(self._nodes, rate)
        if run.scheme.dt is not None or rate == 0.0:
            return stable
        return min(stable, RESOLVED * float(np.sqrt(self._stiffer(run) / rate)))

    def _stiffer(self, run: Any) -> float:
        """Return how many times stiffer viscous contact cells make the rate than their elastic stiffness would.

        Their viscosity beta h/c acts as a stiffness of beta h/(c dt), and counts twice (kernels/step/rigid_rate.py); it
        damps the impact and needs no resolution.
        """
        contacts = [view.plan.contact for view in self.domain.views]
        beta = max((contact.viscosity for contact in contacts if contact), default=0.0)
        return 1.0 if beta == 0.0 else 2.0 * (1.0 + beta * run.dt_limit / run.dt)
