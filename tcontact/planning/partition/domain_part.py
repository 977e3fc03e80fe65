"""The part of a domain that one rank has: parts of its bodies, in a domain of their own.

The first rank has all cells at nodes on which something acts; the ordinary cells are shared out so that all ranks have
equal work (cut.py). Where it has the whole contact, that needs no message, which costs least up to some thousand
contact nodes. Several ranks share a larger one (shared_contact.py), unless `hindrance` says what keeps it together.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from ...mesh.box_arrays import BoxMesh
from ...mesh.elements import ELEMENTS
from ...mesh.geometry import cells_at, joined
from ...mesh.mesh import Mesh
from ...scene.scene import Scene
from ...scene.springs import SceneSpring
from ..body_plan import BodyPlan, ContactPlan
from ..domain import Domain
from ..node_volumes import averages, held_nodes
from ..springs import spring_nodes
from .body_part import BodyPart, acting_nodes, body_part, no_part
from .box_graph import FINE, BoxGraph
from .cell_graph import CellGraph
from .cut import EXTRA_WORK, contact_ranks, cut_beside, cut_cells
from .parts import part_of_rank
from .shared_contact import (
    BodyShare,
    ContactCut,
    SharedContact,
    check_receivers,
    contact_in_meshes,
    hindrance,
    is_copied,
    mesh_blocks,
    mesh_starts,
    shared_contact,
)

OF_DOMAIN = ("chunks", "mixed", "projected", "records_friction")  # what a part has of the whole domain


class PartDomain(Domain):
    """Parts of bodies in one numbering: as `Domain`, with one step in a launch, between which ranks exchange forces.

    shared: its part of a contact that ranks share, None where the first rank has the whole contact; of such a contact
    also settings [islands, SETTINGS] of its static solve and surfaces of bodies in pairs, which follow from the domain
    of all ranks (contact/shared_facts.py); held [n]: nodes that are no volume nodes (node_volumes.py), where volume
    changes are averaged at nodes, else None; counted [s]: 1.0 for the boundary nodes whose copies of this rank sums
    count, else 0.0; None where the host subtracts what others count.
    """

    shared: SharedContact | None = None
    settings: np.ndarray | None = None
    surfaces: Any = None
    counted: np.ndarray | None = None
    held: np.ndarray | None = None

    @cached_property
    def contact(self) -> ContactPlan | None:
        """Contact lists, see `Domain.contact`; rows of a graph that ranks share are those of the whole domain."""
        found = super().contact
        return found if found is None or self.shared is None else replace(found, graph=self.shared.graph)

    @property
    def contact_centre(self) -> np.ndarray:
        """Return the mean position [3] [m] of the contact nodes, of all ranks that share them."""
        return super().contact_centre if self.shared is None else self.shared.centre

    @property
    def residual_receivers(self) -> tuple[np.ndarray, np.ndarray]:
        """Return start [k + 1] of the receivers of all ranks; of a shared contact `ResidualShares` has the list."""
        if self.shared is None:
            return super().residual_receivers
        return np.concatenate([[0], np.cumsum(self.shared.receiver_counts)]), np.zeros(0, dtype=np.int64)

    @property
    def few_contact_cells(self) -> bool:
        """Return whether the serial kernel measures the contact cells: not if ranks add up the forces."""
        return self.shared is None and super().few_contact_cells

    @property
    def small(self) -> bool:
        """Return False: other ranks add to its forces in every step."""
        return False


@dataclass(frozen=True, eq=False)
class DomainPart:
    """What one rank has of a domain; bodies: its parts of all bodies of `whole`; domain: of those with cells.

    whole: the domain of all ranks, or its outline (outline.py).
    """

    whole: Any
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
        return joined([self.bodies[n].nodes + starts[n] if starts[n] else self.bodies[n].nodes for n in self.there])

    @cached_property
    def mass(self) -> np.ndarray:
        """Mass [n] [kg] of the nodes with that of their copies, images together."""
        return joined([self.bodies[number].mass for number in self.there])

    @cached_property
    def owned(self) -> np.ndarray:
        """Nodes [k] of `domain`, ascending, that no lower rank has."""
        starts, found = self.domain.node_start, []
        for own, number in enumerate(self.there):
            body = self.bodies[number]
            mine = body.part.owner[body.plan.node_order] == body.part.rank
            found.append(np.flatnonzero(mine) + starts[own])
        return np.concatenate(found).astype(np.int32)

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
    return next(domain_parts(domain, cut, [rank]))


def domain_parts(domain: Domain, cut: np.ndarray, ranks: Iterable[int]) -> Iterator[DomainPart]:
    """Yield the parts of some ranks, see `domain_part`."""
    contact = ContactCut(domain, cut) if shares_contact(domain, cut) else None
    for rank in ranks:
        yield _domain_part(domain, cut, rank, contact)


def _domain_part(domain: Domain, cut: np.ndarray, rank: int, contact: ContactCut | None) -> DomainPart:
    """Return the part of a rank; contact: None where the first one has all of it."""
    bodies, counts = [], [plan.body.mesh.cell_count for plan in domain.bodies]
    lists = None if contact is None else contact.part(rank)
    shares: list[BodyShare | None] = [None] * len(domain.bodies)
    for number, (plan, own) in enumerate(zip(domain.bodies, np.split(cut, np.cumsum(counts)[:-1]), strict=True)):
        mesh = plan.body.mesh
        if contact is not None and lists is not None:
            shares[number] = contact.body_share(number, rank, lists)
        common = () if contact is None else (contact.common(number), contact.ranks)
        own_part = part_of_rank(mesh.cell_portions, mesh.node_count, own, rank, *common)
        if not len(own_part.nodes):
            bodies.append(no_part(plan, rank))
            continue
        bodies.append(body_part(plan, own_part, rank == 0, shares[number], contact is not None))
    there = [number for number, body in enumerate(bodies) if len(body.nodes)]
    plans = tuple(bodies[number].plan for number in there)
    numbers = tuple(domain.numbers[number] for number in there)
    pairs = domain.pairs if rank in ((0,) if contact is None else contact.ranks) else ()
    if rank == 0:
        part = PartDomain(plans, numbers, pairs, _springs_of(domain, bodies), domain.obstacles)
    else:
        part = PartDomain(plans, numbers, pairs)
    for name in OF_DOMAIN:
        setattr(part, name, getattr(domain, name))
    if averages(domain):
        part.held = np.concatenate([np.zeros(0, dtype=bool), *(_held(bodies[number]) for number in there)])
    found = DomainPart(domain, tuple(bodies), part)
    if contact is not None and lists is not None:
        everyone = np.concatenate([body.node_order for body in domain.bodies])
        everyone += np.repeat(mesh_starts(domain)[:-1], np.diff(domain.node_start))
        boundary = everyone[found.nodes[part.boundary]]
        part.shared = shared_contact(contact, rank, lists, shares, boundary, found.rows_shared())
        part.counted = np.ones(len(part.boundary))
        part.counted[found.guests()] = 0.0
    return found


def _held(body: BodyPart) -> np.ndarray:
    """Return the nodes [n] of a part that are no volume nodes of the whole body."""
    plan = body.whole
    return np.asarray(held_nodes(plan.body)[plan.node_order[body.nodes]])


def _springs_of(domain: Domain, bodies: list[BodyPart]) -> tuple[SceneSpring, ...]:
    """Return the springs of a domain with the numbers that their nodes have in the parts of its bodies."""
    found = []
    for spring in domain.springs:
        ends = [
            end
            if end.body is None
            else end._replace(nodes=np.searchsorted(bodies[domain.numbers.index(end.body)].part.nodes, end.nodes))
            for end in spring.ends
        ]
        found.append(spring._replace(ends=(ends[0], ends[1])))
    return tuple(found)


def shares_contact(domain: Domain, cut: np.ndarray) -> bool:
    """Return whether several ranks have contact cells; cut: what `cut_domain` returns."""
    if domain.contact is None:
        return False
    return bool(cut[_cells_at(domain, [contact_in_meshes(domain)])].any())


def kept_by(domain: Domain, scene: Scene) -> str:
    """Return what keeps on one rank a contact that `cut_domain` has not shared, in words."""
    found = hindrance(scene, domain)
    if found:
        return found
    touching = _cells_at(domain, [contact_in_meshes(domain)])
    if np.isin(touching, _acting_cells(domain, scene, False)).all():
        return "what else acts on its contact nodes (springs, loads, point masses, supports)"
    return "contact cells that are too few or share no node with mass"


def cut_domain(domain: Domain, scene: Scene, ranks: int, contact: int | None = None) -> np.ndarray:
    """Return the rank [m] (int32) of every cell of the bodies of a domain, one body after the other.

    contact: number of ranks that share its contact, None: those with the shortest step (`cut.contact_ranks`); 1 where
    something keeps it together (`shared_contact.hindrance`).
    Raises `InputError` if it has too few cells.
    """
    meshes = [plan.body.mesh for plan in domain.bodies]
    cells = sum(mesh.cell_count for mesh in meshes)
    together = _acting_cells(domain, scene, True)
    work = _contact_work(domain)
    if ranks > 1 and domain.contact is not None and not hindrance(scene, domain):
        nodes = contact_in_meshes(domain)
        touching = _cells_at(domain, [nodes])
        removal = "full" if domain.contact.block > 1 else "normal"
        removal = "none" if domain.contact.graph is None else removal
        if contact is None and is_copied(domain) and cells - len(together) >= ranks - 1:
            contact = 1  # every rank does the whole solve: only what does not fit on one is shared
        if contact is None:
            contact = contact_ranks(cells, len(touching), len(nodes), ranks, removal, cells - len(together))
        contact = min(contact, ranks, len(touching))
        if contact > 1 and check_receivers(domain):
            others = _acting_cells(domain, scene, False)
            blocks, count = mesh_blocks(domain), int(mesh_starts(domain)[-1])
            found = cut_cells(blocks, count, ranks, nodes, work / len(touching), contact, others)
            return found.astype(np.int32)
    for mesh in meshes:
        mesh.release()
    several = _kept_together(meshes)
    found = cut_beside(
        lambda: _graph_of(meshes, several), cells // several, ranks, np.unique(together // several), work / several
    )
    return np.repeat(found.astype(np.int32), several)


def _kept_together(meshes: list[Mesh]) -> int:
    """Return how many cells one after the other a rank has or has not: those of a hexahedron in large boxes, else 1."""
    kinds = {mesh.kind if isinstance(mesh, BoxMesh) else None for mesh in meshes}
    several = {1 if kind is None else len(ELEMENTS[kind].in_box) for kind in kinds}
    large = sum(mesh.cell_count for mesh in meshes) > FINE
    return several.pop() if large and len(kinds) == 1 else 1


def _graph_of(meshes: list[Mesh], several: int) -> CellGraph | BoxGraph:
    """Return the graph of the cells of some meshes, numbered one after the other; several: see `_kept_together`."""
    boxes = [mesh.counts for mesh in meshes if isinstance(mesh, BoxMesh)]
    hexahedra = several > 1 or all(mesh.kind == "hex8" for mesh in meshes)
    return BoxGraph(boxes) if hexahedra and len(boxes) == len(meshes) else CellGraph.of_meshes(meshes)


def _acting_cells(domain: Domain, scene: Scene, touching: bool) -> np.ndarray:
    """Return the cells that the first rank must have, ascending; touching: with those of the contact."""
    pairs = zip(domain.numbers, domain.bodies, mesh_starts(domain), strict=False)
    acting = [acting_nodes(plan, spring_nodes(scene, number), touching) + first for number, plan, first in pairs]
    return _cells_at(domain, acting)


def _cells_at(domain: Domain, nodes: list[np.ndarray]) -> np.ndarray:
    """Return the cells with some of these nodes, ascending; nodes and cells of all bodies one after the other."""
    starts = mesh_starts(domain)
    marked = np.zeros(int(starts[-1]), dtype=bool)
    marked[np.concatenate(nodes)] = True
    found, first = [np.zeros(0, dtype=np.int64)], 0
    for plan, start in zip(domain.bodies, starts, strict=False):
        own = marked[start : start + plan.body.mesh.node_count]
        for rows in plan.body.mesh.portions("cells"):
            found.append(cells_at(own, rows) + first)
            first += len(rows)
    return np.concatenate(found)


def _contact_work(domain: Domain) -> float:
    """Return the work of the static solve of all bodies, in passes of a cell."""
    return sum(_body_work(plan) for plan in domain.bodies)


def _body_work(plan: BodyPlan) -> float:
    if plan.contact is None or plan.contact.graph is None or plan.contact.removal is None:
        return 0.0
    return EXTRA_WORK[plan.contact.removal] * len(plan.contact.graph.cells)
