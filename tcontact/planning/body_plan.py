"""The plan of one body: its numbering, masses and contact lists, as host data."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..mesh.elements import FORMULATIONS
from ..mesh.late_rows import Rows
from ..scene.body import Body
from ..scene.cell_blocks import BodyBlock
from ..scene.dissipation import BulkViscosity, Damping
from ..scene.friction_models import Coulomb, FrictionLayer, FrictionTable, RegularizedCoulomb
from ..scene.periodic import Images
from .cell_shapes import variant
from .contact_graph import ContactGraph, residual_receivers
from .node_order import inverse
from .probe_places import ProbePlace
from .rigid import RigidPlan

# largest number of cells that one thread does alone; a domain of so few takes many steps per launch (domain.py)
SMALL = {name: formulation.small for name, formulation in FORMULATIONS.items()}


FRICTION_TERMS: dict[type, str] = {
    Coulomb: "coulomb-friction",
    FrictionTable: "coulomb-friction",
    RegularizedCoulomb: "regularized-friction",
    FrictionLayer: "friction-layer",
}


@dataclass(frozen=True)
class ContactPlan:
    """Contact lists of one body, in its internal numbering.

    nodes [k]: numbers of the contact nodes, the first boundary nodes; all_nodes [a]: those of every node of the contact
    set, whose gaps are measured; areas [k] [m^2]: area weights (METHOD 1). Of massless contact only: removal: "normal"
    or "full"; basis [k, 3, 3]: unit columns that span the massless directions of a node, then zero columns; block: the
    largest number of these directions, 1 or 3; graph: the contact nodes that share a cell; viscosity: beta of the
    contact cells, 0 without (METHOD 3).
    """

    nodes: np.ndarray
    all_nodes: np.ndarray
    areas: np.ndarray
    removal: str | None = None
    basis: np.ndarray | None = None
    block: int = 3
    graph: ContactGraph | None = None
    viscosity: float = 0.0


def held_nodes(contact: ContactPlan) -> np.ndarray:
    """Return the nodes of a contact set, ascending, that are no contact nodes, as supports hold them."""
    return np.setdiff1d(contact.all_nodes, contact.nodes)


@dataclass(frozen=True, eq=False)
class PlanBlock:
    """Cells of a body with one element and one material.

    own: the same in the body; first: number of its first cell in the plan; rows [m, corners]: `cells`, for what reads
    some of them at a time; contact [c]: its contact cells among those of the body, numbered as its own cells; variant:
    name of the element in the kernels (cell_shapes.py).
    """

    own: BodyBlock
    first: int
    rows: Rows
    contact: np.ndarray
    variant: str

    @property
    def cells(self) -> np.ndarray:
        """Nodes [m, corners] of its cells."""
        return np.asarray(self.rows)


@dataclass(frozen=True)
class BodyPlan:
    """One body in its internal numbering: node i is node `node_order[i]` of the user, cell e is `cell_order[e]`.

    places [n, 3] [m], rows [m, corners]: `reference` and `cells`, for what reads some of them at a time: a box has
    arrays of all only where these are read; lumped [n] [kg]: ordinary lumped mass;
    boundary [s]: nodes with tensor mass, supports or contact; tensors and
    inverses [s, 3, 3]: their mass and its inverse on the components that move freely; loads [s, 3] [N]: gravity at the
    start; pulled: gravity is a function of time;
    support_rows, support_axes [r]: boundary node and axis of each prescribed component, with its speed [r] [m/s] at t
    = 0; driven [r]: for components that functions of time drive, number of the axis among those of all supports
    `body.driven`, one after the other, else -1;
    images: those of a periodic body, whose masters alone have mass, loads and contact; rigid: its rigid parts, nodes
    numbered as in `boundary`; probes: nodes and cells of the probes, in the numbering of the user.
    """

    label: str
    body: Body
    node_order: np.ndarray
    cell_order: np.ndarray
    places: Rows
    rows: Rows
    lumped: np.ndarray
    gravity: np.ndarray
    boundary: np.ndarray
    tensors: np.ndarray
    inverses: np.ndarray
    loads: np.ndarray
    support_rows: np.ndarray
    support_axes: np.ndarray
    speeds: np.ndarray
    driven: np.ndarray
    contact: ContactPlan | None
    damping: Damping | None = None
    viscosity: BulkViscosity | None = None
    images: Images | None = None
    pulled: bool = False
    rigid: tuple[RigidPlan, ...] = ()
    probes: tuple[ProbePlace, ...] = ()

    @property
    def reference(self) -> np.ndarray:
        """Positions [n, 3] [m] of its nodes before anything moves."""
        return np.asarray(self.places)

    @property
    def cells(self) -> np.ndarray:
        """Nodes [m, corners] of its cells, block after block, rows of one length as `Mesh.cells`."""
        return np.asarray(self.rows)

    @property
    def node_count(self) -> int:
        """The number of its nodes."""
        return len(self.node_order)

    @property
    def viscous_cells(self) -> bool:
        """Return whether its contact cells are viscous."""
        return self.contact is not None and self.contact.viscosity > 0.0

    @property
    def dissipates(self) -> bool:
        """Return whether viscosity dissipates energy in the body."""
        return self.viscosity is not None or self.viscous_cells

    @property
    def mass(self) -> np.ndarray:
        """Mass tensors [n, 3, 3] [kg] of all nodes in the user's numbering, after redistribution."""
        result = self.lumped[:, None, None] * np.eye(3)
        result[self.boundary] = self.tensors
        return self.to_user(result)

    @cached_property
    def place(self) -> np.ndarray:
        """Internal number [n] of every node of the user."""
        return inverse(self.node_order)

    def to_user(self, values: np.ndarray) -> np.ndarray:
        """Return a copy of values [n, ...] of the nodes in the user's numbering."""
        return np.take(values, self.place, axis=0)  # four times as fast as an index in brackets

    def contact_areas(self) -> np.ndarray:
        """Return the area weight [n] [m^2] of every node, in the user's numbering; 0 off the contact set."""
        result = np.zeros(len(self.reference))
        if self.contact is not None:
            result[self.contact.nodes] = self.contact.areas
        return self.to_user(result if self.images is None else self.images.shared(result))

    @property
    def element(self) -> str:
        """Names of the elements in the kernels: the kind of its cells with the formulation, unless that is "full"."""
        return self.body.element

    @cached_property
    def blocks(self) -> tuple[PlanBlock, ...]:
        """Its cells by element and material."""
        found, first = [], 0
        graph = None if self.contact is None else self.contact.graph
        touching = np.zeros(0, dtype=np.int64) if graph is None else graph.cells
        for own in self.body.blocks:
            last = first + own.count
            whole = self.rows.shape == (own.count, own.facts.corners)
            rows = self.rows if whole else self.cells[first:last, : own.facts.corners]
            contact = touching[(touching >= first) & (touching < last)] - first
            found.append(PlanBlock(own, first, rows, contact, variant(own.element, self.places, rows)))
            first = last
        return tuple(found)

    @property
    def contact_blocks(self) -> tuple[PlanBlock, ...]:
        """Its blocks with contact cells."""
        return tuple(block for block in self.blocks if len(block.contact))

    @property
    def variant(self) -> str:
        """Names of the elements of its blocks, see `PlanBlock`."""
        return " + ".join(dict.fromkeys(block.variant for block in self.blocks))

    @property
    def options(self) -> dict[str, Any]:
        """Options of its kernels for damping and bulk viscosity; empty without these."""
        found: dict[str, Any] = {} if self.damping is None else {"damped": self.damping.name}
        return found if self.viscosity is None else {**found, "viscous": True}

    @property
    def residual_receivers(self) -> tuple[np.ndarray, np.ndarray]:
        """Boundary nodes that take the force that the static solve leaves, see `contact_graph.residual_receivers`."""
        assert self.contact is not None
        count = len(self.contact.nodes)
        if self.images is None:
            return residual_receivers(self.cells, self.reference, self.boundary, count)
        rows = np.flatnonzero(self.images.master[self.boundary] == self.boundary)
        start, own = residual_receivers(self.images.master[self.cells], self.reference, self.boundary[rows], count)
        return start, rows[own]

    @property
    def terms(self) -> tuple[str, ...]:
        """Names of the terms of this body."""
        names = ["internal-force"]
        if self.images is not None:
            names.append("periodic")
        if self.gravity.any() or self.pulled:
            names.append("gravity")
        if self.body.loads:
            names.append("loads")
        if len(self.support_rows):
            names.append("supports")
        if self.damping is not None:
            names.append(self.damping.name)
        if self.viscosity is not None:
            names.append("bulk-viscosity")
        return tuple(names)
