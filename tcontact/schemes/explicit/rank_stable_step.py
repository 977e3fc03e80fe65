"""The search for the stable step of bodies that several ranks share: `StableSteps` on the vectors of all ranks.

A vector stands on every rank at its nodes, with equal values at all copies of a node. Scalar products are sums over the
ranks with the mass of each copy; accelerations of copies are means over the ranks, weighted with that mass. The first
vector is that of the whole body, so that the number of ranks changes the result by rounding alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ...device.team import Team
from ...planning.partition.body_part import BodyPart
from ...planning.partition.domain_part import DomainPart
from .damped_step import DampedStep
from .stable_step import DIFFERENCE, StableStep, StableSteps
from .start_vectors import random_rows

if TYPE_CHECKING:
    from .body_view import BodyView
    from .stable_step import ForcePass


class RankSteps(StableSteps):
    """Estimates the stable step of every body of a domain together with the other ranks.

    steps: searches of the whole bodies, on the first rank; part, own_views: of this rank.
    """

    def __init__(
        self,
        force: ForcePass,
        steps: Sequence[StableStep | None],
        part: DomainPart,
        own_views: Sequence[BodyView],
        team: Team,
    ) -> None:
        views: list[BodyView | None] = [None] * len(part.bodies)
        for number, view in zip(part.there, own_views, strict=True):
            views[number] = view
        bodies = [RankStep(*of, team) for of in zip(steps, part.bodies, views, strict=True)]
        self.team, self._halo = team, team.exchange(part.nodes_shared())
        rows = self._halo.rows
        self._share = (part.domain.lumped[rows] / part.mass[rows])[:, None]
        super().__init__(force, bodies)

    def _accelerate(self) -> None:
        """Put -M^-1 f(u) of the displacement in `trial` into `answer`, with the forces of all ranks."""
        super()._accelerate()
        answer = self._raw[1].reshape(-1, 3)
        answer[self._halo.rows] = np.where(self._share > 0.0, answer[self._halo.rows] * self._share, 0.0)
        self._halo.add(answer)

    def _rate(self) -> float:
        """Return the largest rate of bulk viscosity [1/s] in the last pass."""
        return float(self.team.largest(super()._rate()))


class RankStep(StableStep):
    """The search of one body.

    whole: that of the whole body, on the first rank, which then has the contact of a penalty; part: of this rank, with
    its view if it has cells.
    """

    def __init__(self, whole: StableStep | None, part: BodyPart, view: BodyView | None, team: Team) -> None:
        self.team, self.plan = team, part.plan
        self.trial = self.answer = np.zeros(0)
        known: Any = None if whole is None else (whole.size, whole.count, whole.spring_rate, whole.normals)
        self.size, self.count, self.spring_rate, self.normals = team.from_first(known)
        self.pressure = None if whole is None else whole.pressure
        self.added_rate, self._pressed = self.spring_rate, team.from_first(self.pressure is not None)
        self._loaded = None if self.pressure is None else np.searchsorted(part.nodes, self.pressure.rows)
        self.bound, self.elastic, self.damped = None, np.inf, np.inf
        self.mass, self.penalty = part.mass, _penalty(whole, part, team)
        self.start = None
        self._begin = self._random(whole, part)
        self.damping = None
        if part.whole.viscous_cells:
            force = None if view is None else view.viscous_force
            product, small = self.stiffness_product, DIFFERENCE * self.size
            self.damping = RankDamped(part, product, force or _nothing, small, team)

    def press(self, u: np.ndarray) -> None:
        """Take the stiffness of the pressures, whose nodes the first rank has, at displacement u [3n] of its part."""
        if self._pressed:
            found = 0.0 if self.pressure is None else self.pressure.bound(u.reshape(-1, 3)[self._loaded])
            self.added_rate = self.spring_rate + self.team.from_first(found)

    def _random(self, whole: StableStep | None, part: BodyPart) -> np.ndarray:
        """Return the random vector [3n] of the first search, which is that of the whole body."""
        numbers, sizes, masters = part.nodes, None, None
        if whole is not None:
            sizes, images = whole.first_sizes(), whole.plan.images
            if images is not None:  # of a periodic body all images have the values of their master
                masters, sizes = images.master, sizes[images.master]
        if self.team.from_first(masters is not None):
            numbers = self.team.shared_out(masters, part.nodes)
        found = random_rows(numbers)
        found *= self.team.shared_out(sizes, part.nodes)[:, None]
        return found.reshape(-1)

    def _first(self, here: np.ndarray) -> np.ndarray:
        """Return a start vector of length 1; the first one is that of the whole body."""
        if self.start is not None:
            return super()._first(here)
        found, self._begin = self._begin, np.zeros(0)
        return self._unit(found, found)

    def _sum(self, value: float) -> float:
        return self.team.total(value)

    def _most(self, value: float) -> float:
        return float(self.team.largest(value))


def _penalty(whole: StableStep | None, part: BodyPart, team: Team) -> np.ndarray | None:
    """Return the penalty [k] of the contact nodes of a part, from the first rank; None without them."""
    if not team.from_first(whole is not None and whole.penalty is not None):
        return None
    values = None
    if whole is not None and whole.plan.contact is not None:
        values = np.zeros(whole.plan.node_count)
        values[whole.plan.contact.nodes] = whole.penalty
    mine = team.shared_out(values, part.nodes)
    return None if part.plan.contact is None else mine[part.plan.contact.nodes]


def _nothing(_u: np.ndarray, step: np.ndarray) -> np.ndarray:
    """Return the force of no viscous cells."""
    return np.zeros_like(step)


class RankDamped(DampedStep):
    """The search with viscous contact cells; forces and momenta at a copy are the part of its rank."""

    def __init__(self, part: BodyPart, stiffness: object, viscous: object, small: float, team: Team) -> None:
        super().__init__(part.plan, stiffness, viscous, small)  # type: ignore[arg-type]
        self.team, boundary = team, part.plan.boundary
        self.halo = team.exchange(tuple((other, boundary[rows]) for other, rows in part.shared))
        self.count = 3 * part.whole.node_count
        mine = random_rows(part.nodes)
        mine[part.part.owner[part.plan.node_order] != part.part.rank] = 0.0
        self.start = mine.reshape(-1)

    def _moved(self, p: np.ndarray) -> np.ndarray:
        """Return M^-1 p [3n] with the momenta of all ranks."""
        rows = np.array(p).reshape(-1, 3)
        self.halo.add(rows)
        return super()._moved(rows.reshape(-1))

    def _sum(self, value: float) -> float:
        return self.team.total(value)

    def _most(self, value: float) -> float:
        return float(self.team.largest(value))
