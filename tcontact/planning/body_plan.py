"""What is planned for one body: its numbering, masses and contact lists. Host data only."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ..mesh.elements import FORMULATIONS
from ..mesh.geometry import parallelepipeds
from ..scene.body import Body
from ..scene.dissipation import BulkViscosity, Damping
from ..scene.friction_models import Coulomb, FrictionLayer, RegularizedCoulomb
from ..scene.periodic import Images
from .contact_graph import ContactGraph, heirs

if TYPE_CHECKING:
    pass

# up to so many cells one thread does the work, for a body many steps per launch
SMALL = {name: formulation.small for name, formulation in FORMULATIONS.items()}


FRICTION_TERMS: dict[type, str] = {
    Coulomb: "coulomb-friction",
    RegularizedCoulomb: "regularized-friction",
    FrictionLayer: "friction-layer",
}


@dataclass(frozen=True)
class ContactPlan:
    """Contact lists of one body, in its internal numbering.

    nodes [k]: contact nodes, the first rows of the boundary list; all_nodes: every node of the contact set (gaps);
    areas [k] [m^2]; for massless contact also basis [k, 3, 3], block (1 or 3 massless components a node), the graph and
    viscosity: beta of the contact cells, 0 without (METHOD 3).
    """

    nodes: np.ndarray
    all_nodes: np.ndarray
    areas: np.ndarray
    removal: str | None = None
    basis: np.ndarray | None = None
    block: int = 3
    graph: ContactGraph | None = None
    viscosity: float = 0.0


@dataclass(frozen=True)
class BodyPlan:
    """One body in its internal numbering: node i is node `node_order[i]` of the user, cell e is `cell_order[e]`.

    lumped [n] [kg]: ordinary lumped mass; boundary [s]: nodes with tensor mass, supports or contact; tensors and
    inverses [s, 3, 3]: their mass and its inverse on the components that move freely; loads [s, 3] [N]: gravity;
    support_rows, support_axes [r]: prescribed components; speeds [r] [m/s]; images: of a periodic body, whose masters
    alone have mass, loads and contact.
    """

    label: str
    body: Body
    node_order: np.ndarray
    cell_order: np.ndarray
    reference: np.ndarray
    cells: np.ndarray
    lumped: np.ndarray
    gravity: np.ndarray
    boundary: np.ndarray
    tensors: np.ndarray
    inverses: np.ndarray
    loads: np.ndarray
    support_rows: np.ndarray
    support_axes: np.ndarray
    speeds: np.ndarray
    contact: ContactPlan | None
    damping: Damping | None = None
    viscosity: BulkViscosity | None = None
    images: Images | None = None

    @property
    def small(self) -> bool:
        """Whether the body takes many steps per launch."""
        return len(self.cells) <= SMALL[self.element]

    @property
    def few_contact_cells(self) -> bool:
        """Whether there are massless contact cells, and so few that one thread does them."""
        graph = None if self.contact is None else self.contact.graph
        return graph is not None and len(graph.cells) <= SMALL[self.element]

    @property
    def viscous_cells(self) -> bool:
        """Whether its contact cells are viscous."""
        return self.contact is not None and self.contact.viscosity > 0.0

    @property
    def dissipates(self) -> bool:
        """Whether its rows have a viscous power."""
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
        return np.argsort(self.node_order)

    def to_user(self, values: np.ndarray) -> np.ndarray:
        """Values [n, ...] of the nodes as the user numbers them, in an array of their own."""
        return np.take(values, self.place, axis=0)  # four times as fast as an index in brackets

    @property
    def element(self) -> str:
        """Name of the element its kernels are made for: the kind of its cells and, but for "full", the formulation."""
        return self.body.element

    @cached_property
    def variant(self) -> str:
        """The element with what its kernels may use: "-affine" where it helps that all cells are parallelepipeds."""
        differ = FORMULATIONS[self.element].affine is not None
        return self.element + "-affine" if differ and parallelepipeds(self.reference, self.cells) else self.element

    @property
    def options(self) -> dict[str, Any]:
        """What its kernels are made with besides the ordinary step; empty without."""
        found: dict[str, Any] = {} if self.damping is None else {"damped": self.damping.name}
        return found if self.viscosity is None else {**found, "viscous": True}

    @property
    def heirs(self) -> tuple[np.ndarray, np.ndarray]:
        """Who takes what the static solve leaves unbalanced, as `contact_graph.heirs`."""
        assert self.contact is not None
        count = len(self.contact.nodes)
        if self.images is None:
            return heirs(self.cells, self.reference, self.boundary, count)
        rows = np.flatnonzero(self.images.master[self.boundary] == self.boundary)
        start, own = heirs(self.images.master[self.cells], self.reference, self.boundary[rows], count)
        return start, rows[own]

    @property
    def terms(self) -> tuple[str, ...]:
        """Names of the physics this body has."""
        names = ["internal-force"]
        if self.images is not None:
            names.append("periodic")
        if self.gravity.any():
            names.append("gravity")
        if len(self.support_rows):
            names.append("supports")
        if self.damping is not None:
            names.append(self.damping.name)
        if self.viscosity is not None:
            names.append("bulk-viscosity")
        return tuple(names)
