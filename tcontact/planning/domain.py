"""A domain: bodies that take their steps together, in one numbering of nodes and in flat arrays.

Nodes and contact nodes stand body after body, in the numbering of the plans. The boundary nodes are the contact nodes
of all bodies, then their images in periodic bodies, then the others. Cells stand in blocks of one element and one law.
A domain of one body has the arrays of its plan.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from ..kernels.lanes import DEVICE_ROWS, MAXIMUM_ROWS
from ..mesh.elements import Element
from ..scene.dissipation import BulkViscosity, Damping
from ..scene.materials import Material
from ..scene.pairs import BodyPair
from ..scene.periodic import Images
from ..scene.springs import SceneSpring
from ..scene.supports import Support
from .body_plan import SMALL, BodyPlan, ContactPlan, PlanBlock
from .contact_graph import joined
from .rigid import RigidPlan
from .springs import spring_rates


@dataclass(frozen=True)
class CellBlock:
    """Cells of one element and one law with its constants.

    own: these cells in the plan of their body; first: number of the first node of the body in the domain; contact [c]:
    numbers of its contact cells in those of the domain.
    """

    body: BodyPlan
    own: PlanBlock
    first: int
    contact: np.ndarray

    @property
    def count(self) -> int:
        """Number of its cells."""
        return len(self.own.cells)

    @property
    def order(self) -> np.ndarray:
        """Numbers [m] of its cells in `own`, the contact cells last."""
        ordinary = np.ones(self.count, dtype=bool)
        ordinary[self.own.contact] = False
        return np.concatenate([np.flatnonzero(ordinary), self.own.contact])

    @property
    def cells(self) -> np.ndarray:
        """Nodes [m, corners] of its cells in the domain, the contact cells last; not kept, as large meshes are."""
        cells = self.own.cells.take(self.order, axis=0) if len(self.contact) else self.own.cells
        return cells + np.int32(self.first) if self.first else cells

    @property
    def variant(self) -> str:
        """Name of the element in the kernels."""
        return self.own.variant

    @property
    def material(self) -> Material:
        """The material of its cells."""
        return self.own.own.material

    @property
    def facts(self) -> Element:
        """The record of the kind of its cells."""
        return self.own.own.facts

    @property
    def contact_cells(self) -> np.ndarray:
        """Nodes [c, corners] of its contact cells."""
        return self.own.cells[self.own.contact] + np.int32(self.first)

    @property
    def kind(self) -> tuple[str, str]:
        """Element and law, for which its kernels are compiled."""
        return self.variant, self.material.law


class Domain:
    """Bodies in one numbering; what is None here is that of a part of a rank (partition/domain_part.py).

    numbers: of the bodies in the scene; pairs: its bodies that are in contact with each other; springs: those of its
    bodies; obstacles: rigid bodies of the obstacles, if some move freely; chunks: chunks of its cells (packing.py),
    None = as many as suit the threads; mixed: its ordinary cells compute in float32 (kernels/cells/mixed_cells.py);
    projected: MPRGP, or what solves for pairs, places its massless nodes; records_friction: frames hold slip and
    friction work of its contact nodes; node_start, contact_start [bodies + 1]: first node and contact node of a body;
    boundary_place: for every body, places [s] of its boundary nodes among those of the domain; rigid: rigid bodies that
    move with it. The rest is as in `BodyPlan`, of all bodies.
    """

    shared: Any = None
    settings: np.ndarray | None = None
    surfaces: Any = None
    counted: np.ndarray | None = None
    held: np.ndarray | None = None

    def __init__(
        self,
        bodies: tuple[BodyPlan, ...],
        numbers: tuple[int, ...] = (0,),
        pairs: tuple[BodyPair, ...] = (),
        springs: tuple[SceneSpring, ...] = (),
        obstacles: tuple[RigidPlan, ...] = (),
    ) -> None:
        self.bodies, self.numbers, self.pairs, self.springs = bodies, numbers, pairs, springs
        self.obstacles = obstacles
        self.chunks: int | None = None
        self.mixed = False
        self.projected = False
        self.records_friction = False
        contacts = [body.contact for body in bodies]
        self.node_start = _starts([body.node_count for body in bodies])
        self.contact_start = _starts([0 if contact is None else len(contact.nodes) for contact in contacts])
        self.boundary_place = self._boundary_places()

    def _boundary_places(self) -> list[np.ndarray]:
        classes = []
        for body in self.bodies:
            contact = np.zeros(0, dtype=np.int64) if body.contact is None else body.contact.nodes
            followers = 0 if body.images is None else len(body.images.followers_of(contact))
            rest = len(body.boundary) - len(contact) - followers
            classes.append(np.repeat([0, 1, 2], [len(contact), followers, rest]))
        order = np.argsort(np.concatenate(classes), kind="stable")
        place = np.empty(len(order), dtype=np.int64)
        place[order] = np.arange(len(order))
        return np.split(place, np.cumsum([len(part) for part in classes])[:-1])

    @cached_property
    def rigid(self) -> tuple[RigidPlan, ...]:
        """Rigid bodies of the domain: if some obstacles move freely a record of each, then its rigid parts."""
        parts = zip(self.bodies, self.boundary_place, strict=True)
        return (
            *self.obstacles,
            *(replace(part, nodes=place[part.nodes]) for body, place in parts for part in body.rigid),
        )

    @cached_property
    def spring_rates(self) -> dict[int, float]:
        """Bounds of omega^2 [1/s^2] of masses on springs, by the number of the body (springs.py)."""
        return spring_rates(self)

    @cached_property
    def tied(self) -> np.ndarray:
        """Boundary nodes that move with rigid parts, which have their mass and their loads."""
        return np.concatenate([np.zeros(0, dtype=np.int64), *(body.nodes for body in self.rigid)]).astype(np.int64)

    def _joined(self, name: str) -> np.ndarray:
        """Concatenate an array of the plans of all bodies."""
        parts = [getattr(body, name) for body in self.bodies]
        return parts[0] if len(parts) == 1 else np.concatenate(parts)

    def _of_boundary(self, values: Callable[[BodyPlan, int], np.ndarray]) -> np.ndarray:
        """Collect values of the boundary nodes of all bodies, in the order of the domain."""
        parts = [values(body, int(start)) for body, start in zip(self.bodies, self.node_start, strict=False)]
        if len(parts) == 1:
            return parts[0]
        result = np.empty((sum(map(len, parts)), *parts[0].shape[1:]), dtype=parts[0].dtype)
        for place, part in zip(self.boundary_place, parts, strict=True):
            result[place] = part
        return result

    @cached_property
    def reference(self) -> np.ndarray:
        """Positions [n, 3] [m] of the nodes before anything moves."""
        return self._joined("reference")

    @cached_property
    def lumped(self) -> np.ndarray:
        """Ordinary lumped mass [n] [kg]."""
        return self._joined("lumped")

    @property
    def mass(self) -> float:
        """Mass [kg] of its bodies and of the rigid bodies that move with it."""
        return float(self.lumped.sum()) + sum(body.own_mass for body in self.rigid)

    @cached_property
    def boundary(self) -> np.ndarray:
        """Boundary nodes [s]: those with tensor mass, supports or contact."""
        return self._of_boundary(lambda body, start: body.boundary + start)

    @cached_property
    def tensors(self) -> np.ndarray:
        """Mass tensors [s, 3, 3] [kg] of the boundary nodes."""
        return self._of_boundary(lambda body, _start: body.tensors)

    @cached_property
    def inverses(self) -> np.ndarray:
        """Inverses of `tensors` on the components that move freely [s, 3, 3] [1/kg]."""
        return self._of_boundary(lambda body, _start: body.inverses)

    @cached_property
    def loads(self) -> np.ndarray:
        """Loads [s, 3] [N] of the boundary nodes."""
        return self._of_boundary(lambda body, _start: body.loads)

    @cached_property
    def support_rows(self) -> np.ndarray:
        """Boundary nodes [r] with prescribed components."""
        pairs = zip(self.bodies, self.boundary_place, strict=True)
        return np.concatenate([place[body.support_rows] for body, place in pairs])

    @cached_property
    def support_axes(self) -> np.ndarray:
        """Axes [r] of the prescribed components."""
        return self._joined("support_axes")

    @cached_property
    def speeds(self) -> np.ndarray:
        """Prescribed velocities [r] of these components [m/s]."""
        return self._joined("speeds")

    @cached_property
    def driven(self) -> tuple[Support, ...]:
        """The supports that functions of time drive."""
        return tuple(support for body in self.bodies for support in body.body.driven)

    @cached_property
    def driven_axes(self) -> np.ndarray:
        """For every prescribed component [r] the number of the axis of `driven` that drives it, or -1."""
        parts, first = [], 0
        for body in self.bodies:
            parts.append(np.where(body.driven >= 0, body.driven + first, -1))
            first += sum(len(support.axes) for support in body.body.driven)
        return np.concatenate(parts)

    @property
    def gravity(self) -> np.ndarray:
        """Gravity [3] [m/s^2]."""
        return self.bodies[0].gravity

    @property
    def pulled(self) -> bool:
        """Return whether gravity is a function of time."""
        return self.bodies[0].pulled

    @property
    def loaded(self) -> bool:
        """Return whether it has loads that need data of their own: other ones than constant gravity."""
        return self.pulled or any(body.body.loads for body in self.bodies)

    @property
    def damping(self) -> Damping | None:
        """The damping of the scene."""
        return self.bodies[0].damping

    @property
    def viscosity(self) -> BulkViscosity | None:
        """The bulk viscosity of the scene."""
        return self.bodies[0].viscosity

    @cached_property
    def images(self) -> Images | None:
        """Images of the nodes of all periodic bodies, None without any; several bodies have no common period."""
        own = [body.images for body in self.bodies]
        if len(own) == 1 or all(images is None for images in own):
            return own[0]
        counts = np.diff(self.node_start)
        masters = [
            np.arange(count) if images is None else images.master for images, count in zip(own, counts, strict=True)
        ]
        shifted = [master + start for master, start in zip(masters, self.node_start, strict=False)]
        return Images(np.concatenate(shifted), np.full(3, np.nan))

    @cached_property
    def blocks(self) -> tuple[CellBlock, ...]:
        """The blocks of cells, body after body, and their contact cells in the same order."""
        found, first = [], 0
        for number, body in enumerate(self.bodies):
            for block in body.blocks:
                contact = np.arange(first, first + len(block.contact))
                found.append(CellBlock(body, block, int(self.node_start[number]), contact))
                first += len(contact)
        return tuple(found)

    @cached_property
    def kinds(self) -> tuple[tuple[str, str], ...]:
        """Pairs of an element and a law for which the kernels of the domain are compiled."""
        return tuple(dict.fromkeys(block.kind for block in self.blocks))

    @cached_property
    def contact(self) -> ContactPlan | None:
        """Contact lists of all bodies that can touch, None without any; removal and viscosity are in their plans."""
        plans = [body.contact for body in self.bodies]
        if len(plans) == 1:
            return plans[0]
        there = [(plan, int(start)) for plan, start in zip(plans, self.node_start, strict=False) if plan is not None]
        if not there:
            return None
        bases = [plan.basis for plan, _ in there if plan.basis is not None]
        graphs = [plan.graph for plan, _ in there if plan.graph is not None]
        return ContactPlan(
            nodes=np.concatenate([plan.nodes + start for plan, start in there]),
            all_nodes=np.concatenate([plan.all_nodes + start for plan, start in there]),
            areas=np.concatenate([plan.areas for plan, _ in there]),
            basis=np.concatenate(bases) if bases else None,
            block=max((plan.block for plan, _ in there if plan.graph is not None), default=3),
            graph=joined(graphs, [first for plan, first in there if plan.graph is not None]) if graphs else None,
        )

    @property
    def contact_centre(self) -> np.ndarray:
        """Mean position [3] [m] of the contact nodes, to which positions of contact are relative."""
        return np.asarray(self.reference[self.contact.all_nodes].mean(axis=0))  # type: ignore[union-attr]

    @cached_property
    def residual_receivers(self) -> tuple[np.ndarray, np.ndarray]:
        """Boundary nodes that take the force that the static solve leaves at a contact node: start [k + 1], places."""
        starts, rows, total = [np.zeros(1, dtype=np.int64)], [], 0
        for body, place in zip(self.bodies, self.boundary_place, strict=True):
            if body.contact is not None and len(body.contact.nodes):
                start, own = body.residual_receivers
                starts.append(start[1:] + total)
                rows.append(place[own])
                total += len(own)
        return np.concatenate(starts), np.concatenate(rows)

    @property
    def massless(self) -> np.ndarray | None:
        """Projectors [n, 3, 3] on the components of every node that have no mass; None without any."""
        contact = self.contact
        if contact is None or contact.basis is None:
            return None
        result = np.zeros((len(self.reference), 3, 3))
        result[contact.nodes] = np.einsum("kic,kjc->kij", contact.basis, contact.basis)
        return result if self.images is None else result[self.images.master]

    @cached_property
    def small(self) -> bool:
        """Return whether one thread takes its steps, many in a launch."""
        return self._share([block.count for block in self.blocks]) <= 1.0

    @property
    def table_rows(self) -> int:
        """Return how many rows of a launch, or of a block of steps on a GPU, tables of functions of time have."""
        return MAXIMUM_ROWS if self.small else DEVICE_ROWS

    @property
    def few_contact_cells(self) -> bool:
        """Return whether there are massless contact cells, and so few that one thread does them."""
        counts = [len(block.contact) for block in self.blocks]
        return sum(counts) > 0 and self._share(counts) <= 1.0

    def _share(self, counts: list[int]) -> float:
        """Return the cells over the largest number for one thread, summed over the blocks; infinite where that is 0."""
        elements = [block.own.own.element for block in self.blocks]
        pairs = [(count, SMALL[element]) for count, element in zip(counts, elements, strict=True) if count]
        return sum(count / limit if limit else np.inf for count, limit in pairs)

    @property
    def several(self) -> float:
        """Number of cells over the largest number for one thread."""
        return self._share([block.count for block in self.blocks])

    @property
    def viscous_cells(self) -> bool:
        """Return whether some contact cells are viscous."""
        return any(body.viscous_cells for body in self.bodies)

    @property
    def dissipates(self) -> bool:
        """Return whether viscosity dissipates energy in the domain."""
        return self.viscosity is not None or self.viscous_cells

    @property
    def plastic(self) -> bool:
        """Return whether some of its cells flow plastically."""
        return any(block.material.plastic for block in self.blocks)

    @property
    def options(self) -> dict[str, Any]:
        """Options of its kernels for damping, bulk viscosity and mixed precision; empty without these."""
        return self.bodies[0].options | ({"mixed": True} if self.mixed else {})


def _starts(counts: list[int]) -> np.ndarray:
    return np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
