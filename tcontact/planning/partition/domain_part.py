"""The part of a domain that one rank has: parts of its bodies, in a domain of their own.

The first rank has all cells at nodes on which something acts, and so the whole contact; the ordinary cells are shared
out so that all ranks have equal work (cut.py). Contact then needs no message: that costs least up to some thousand
contact nodes, beyond which the first rank has more work than the others.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...mesh.geometry import Blocks, cells_at
from ...scene.scene import Scene
from ..body_plan import BodyPlan
from ..domain import Domain
from ..springs import spring_nodes
from .body_part import BodyPart, acting_nodes, body_part, no_part
from .cut import EXTRA_WORK, cut_beside
from .parts import part_of_rank


class PartDomain(Domain):
    """Parts of bodies in one numbering: as `Domain`, with one step in a launch, between which ranks exchange forces."""

    @property
    def small(self) -> bool:
        """Return False: other ranks add to its forces in every step."""
        return False


@dataclass(frozen=True, eq=False)
class DomainPart:
    """What one rank has of a domain; bodies: its parts of all bodies of `whole`; domain: of those with cells."""

    whole: Domain
    bodies: tuple[BodyPart, ...]
    domain: PartDomain

    @cached_property
    def there(self) -> tuple[int, ...]:
        """Numbers in `whole` of the bodies in `domain`, ascending."""
        return tuple(number for number, body in enumerate(self.bodies) if len(body.nodes))

    @cached_property
    def nodes(self) -> np.ndarray:
        """Numbers [n] of the nodes of `domain` in `whole`."""
        starts = self.whole.node_start
        return np.concatenate([self.bodies[number].nodes + starts[number] for number in self.there])

    @cached_property
    def mass(self) -> np.ndarray:
        """Mass [n] [kg] of the nodes with that of their copies, images together."""
        return np.concatenate([self.bodies[number].mass for number in self.there])

    @cached_property
    def owned(self) -> np.ndarray:
        """Nodes [k] of `domain`, ascending, that no lower rank has."""
        starts, found = self.domain.node_start, []
        for own, number in enumerate(self.there):
            body = self.bodies[number]
            mine = body.part.owner[body.plan.node_order] == body.part.rank
            found.append(np.flatnonzero(mine) + starts[own])
        return np.concatenate(found)

    def guests(self) -> np.ndarray:
        """Return the boundary nodes [k] of `domain` that lower ranks count."""
        mine = np.zeros(len(self.domain.reference), dtype=bool)
        mine[self.owned] = True
        return np.flatnonzero(~mine[self.domain.boundary])

    def rows_shared(self) -> tuple[tuple[int, np.ndarray], ...]:
        """Return for every other rank the boundary nodes [k] of `domain` that it shares, in the order of both."""
        found: dict[int, list[np.ndarray]] = {}
        for own, number in enumerate(self.there):
            for other, rows in self.bodies[number].shared:
                found.setdefault(other, []).append(self.domain.boundary_place[own][rows])
        return tuple((other, np.concatenate(found[other])) for other in sorted(found))

    def nodes_shared(self) -> tuple[tuple[int, np.ndarray], ...]:
        """Return the same as nodes [k] of `domain`."""
        return tuple((other, self.domain.boundary[rows]) for other, rows in self.rows_shared())


def domain_part(domain: Domain, cut: np.ndarray, rank: int) -> DomainPart:
    """Return the part of a domain that one rank has; cut: what `cut_domain` returns."""
    bodies, counts = [], [plan.body.mesh.cell_count for plan in domain.bodies]
    for plan, own in zip(domain.bodies, np.split(cut, np.cumsum(counts)[:-1]), strict=True):
        mesh = plan.body.mesh
        if (own == rank).any():
            own_part = part_of_rank(mesh.blocks, mesh.node_count, own, rank)
            bodies.append(body_part(plan, own_part, acts=rank == 0))
        else:
            bodies.append(no_part(plan, rank))
    there = [number for number, body in enumerate(bodies) if len(body.nodes)]
    plans = tuple(bodies[number].plan for number in there)
    numbers = tuple(domain.numbers[number] for number in there)
    if rank == 0:
        part = PartDomain(plans, numbers, domain.pairs, domain.springs, domain.obstacles)
    else:
        part = PartDomain(plans, numbers)
    part.chunks, part.mixed, part.records_friction = domain.chunks, domain.mixed, domain.records_friction
    return DomainPart(domain, tuple(bodies), part)


def cut_domain(domain: Domain, scene: Scene, ranks: int) -> np.ndarray:
    """Return the rank [m] (int32) of every cell of the bodies of a domain, one body after the other.

    Raises `InputError` if it has too few cells.
    """
    blocks: list[tuple[str, np.ndarray]] = []
    acting, first = [], 0
    for number, plan in zip(domain.numbers, domain.bodies, strict=True):
        mesh = plan.body.mesh
        blocks += [(kind, rows + first) for kind, rows in mesh.blocks]
        acting.append(acting_nodes(plan, spring_nodes(scene, number)) + first)
        first += mesh.node_count
    marked = np.zeros(first, dtype=bool)
    marked[np.concatenate(acting)] = True
    return cut_beside(blocks, first, ranks, _cells_at(blocks, marked), _contact_work(domain)).astype(np.int32)


def _cells_at(blocks: Blocks, marked: np.ndarray) -> np.ndarray:
    """Return the cells with marked nodes, ascending."""
    found, first = [], 0
    for _, rows in blocks:
        found.append(cells_at(marked, rows) + first)
        first += len(rows)
    return np.concatenate(found)


def _contact_work(domain: Domain) -> float:
    """Return the work of the static solve of all bodies, in passes of a cell."""
    return sum(_body_work(plan) for plan in domain.bodies)


def _body_work(plan: BodyPlan) -> float:
    if plan.contact is None or plan.contact.graph is None or plan.contact.removal is None:
        return 0.0
    return EXTRA_WORK[plan.contact.removal] * len(plan.contact.graph.cells)
