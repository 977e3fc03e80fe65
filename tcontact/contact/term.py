"""The contact terms and what they share: contact nodes, obstacles, contact force, constraint rows, friction."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ..cells.internal_force import InternalForce
from ..device import arrays
from ..kernels.lanes import MAXIMUM_SLOTS
from ..planning.body_plan import BodyPlan, ContactPlan, held_nodes
from ..planning.domain import Domain
from ..planning.islands import island_starts, islands_of, nodes_without_rows
from ..scene.contact_models import PenaltyContact
from ..scene.friction_laws import row_coefficients
from ..scene.scene import Scene
from .constraint_rows import ConstraintRows
from .friction import Friction
from .layered_friction import LayeredFriction, make_friction
from .obstacles import Obstacles
from .pairs.pair_contact import PairContact

if TYPE_CHECKING:
    from ..kernels.language.bundles import ContactOptions


class ContactTerm:
    """Contact of the bodies of a domain with the obstacles; the contact nodes are the first boundary nodes.

    The base class only measures gaps: it serves where supports hold every contact node along the normals.
    `kernel`: its name in kernels/step/serial_step.py. nodes [k + m]: the contact nodes, then the `others` of every
    island, those without rows; reference [k + m, 3] [m]: their positions at rest, relative to the mean of those of the
    domain; starts [islands + 1, ISLAND]: where the parts of every island begin (kernels/contact/islands.py); candidates
    [k, slots]: obstacle of each row; contact_force [k, 3] [N], with held masters of pairs [s, 3] of all boundary nodes.
    """

    name = "contact"
    kernel: ClassVar[str] = "gaps"
    block = 1  # massless components of a node
    plain = False  # every node is massless in all components, along x, y and z
    exact = True  # no penalty
    kicked = True  # some components of contact nodes have mass
    viscous = False  # the contact cells have viscosity
    projected = False  # MPRGP replaces the sweeps
    shared = False  # several ranks share it
    pairs: PairContact | None = None  # rows of pairs of bodies

    def __init__(self, scene: Scene, domain: Domain) -> None:
        assert domain.contact is not None
        contact: ContactPlan = domain.contact
        count = len(contact.nodes)
        self.slots = max(1, min(len(scene.obstacles), MAXIMUM_SLOTS) + bool(domain.pairs))
        centre = domain.contact_centre
        self.obstacles = Obstacles(scene, centre, domain.table_rows)
        self.islands = islands_of(domain)
        self.others = nodes_without_rows(domain, self.islands, len(scene.obstacles))
        nodes = np.concatenate([contact.nodes, *self.others])
        self.nodes = arrays.put(nodes.astype(np.int32))
        self.reference = arrays.put(domain.reference[nodes] - centre)
        self.starts = arrays.put(island_starts(self.islands, self.others, None))
        self.candidates = arrays.put(np.tile(np.arange(self.slots, dtype=np.int32), count))
        # masters that supports hold are no contact nodes, and stand behind them among the boundary nodes
        held = domain.pairs and any(len(held_nodes(body.contact)) for body in domain.bodies if body.contact)
        self.contact_force = arrays.zeros(3 * (len(domain.boundary) if held else count))
        self.friction: Friction | None = None
        self.rows: ConstraintRows | None = None

    def finish(self, scene: Scene, domain: Domain, force: InternalForce) -> None:
        """Make the friction of the scene, if there is any, and the constraint rows."""
        if domain.contact is None or not len(domain.contact.nodes):
            return
        static_friction = self.kernel == "massless" and self.block > 1
        if scene.friction is not None:
            self.friction = make_friction(scene, domain, static_friction)
        coefficients = row_coefficients(scene, self.slots)
        self.rows = ConstraintRows(len(domain.contact.nodes), self.options.row_places, coefficients)
        if self.friction is not None:
            self.friction.rows = self.rows
            if isinstance(self.friction, LayeredFriction):
                self.friction.find_partners(scene, domain, self.candidates, self.pairs, force)
            if self.pairs is not None:
                self.pairs.set_friction(self.rows)

    @property
    def options(self) -> ContactOptions:
        """Options for which its kernels are compiled."""
        from ..kernels.language.bundles import ContactOptions

        obstacles, friction = self.obstacles, self.friction
        return ContactOptions(
            self.kernel,
            self.block,
            self.slots,
            obstacles.shapes,
            obstacles.moving,
            obstacles.tracked and self.kernel != "gaps",
            "" if friction is None else friction.law,
            isinstance(friction, LayeredFriction),
            friction is not None and self.kicked,
            self.viscous,
            self.projected,
            self.pairs is not None,
            self.plain,
            friction is not None and friction.varied,
            friction is not None and friction.recorded,
            obstacles.free and self.kernel != "gaps",
            obstacles.posed,
            shared=self.shared,
        )

    @property
    def trouble(self) -> tuple[BodyPlan, str] | None:
        """The body whose last step failed, and the reason; or None."""
        return None

    def start_velocity(self, u: arrays.Array, velocity: np.ndarray, dt: float) -> None:
        """Set the start velocity [k, 3] [m/s] of the contact nodes; dt [s]: the first step."""

    def velocity(self, u: arrays.Array, dt: float) -> np.ndarray | None:
        """Return the velocity [k, 3] [m/s] of the massless components for output; None without any."""
        return None

    def contact_node_forces(self) -> np.ndarray:
        """Return the contact force [k, 3] [N] on all contact nodes."""
        return arrays.get(self.contact_force)[: 3 * len(arrays.get(self.candidates)) // self.slots].reshape(-1, 3)

    def arguments(self) -> dict[str, arrays.Array]:
        """Return the arrays of the term by the names of kernels/language/bundles.Contact."""
        friction = self.friction
        arguments = {
            "nodes": self.nodes,
            "islands": self.starts,
            "reference": self.reference,
            "force": self.contact_force,
        }
        if friction is not None:
            arguments |= {"friction": friction.data}
        return arguments

    def obstacle_arguments(self) -> dict[str, arrays.Array]:
        """Return the arrays by the names of kernels/language/bundles.Obstacles."""
        obstacles = self.obstacles
        return {"records": obstacles.records, "motion": obstacles.motion, "candidates": self.candidates}

    def row_arguments(self) -> dict[str, arrays.Array]:
        """Return the arrays by the names of kernels/language/bundles.Rows."""
        return {} if self.rows is None else {"values": self.rows.values}

    def owned(self) -> list[arrays.Array]:
        """Return the arrays of this term."""
        own = (item for item in vars(self).values() if hasattr(item, "shape"))
        parts = [] if self.rows is None else [self.rows.values]
        parts += [] if self.pairs is None else self.pairs.owned()
        return [*self.obstacles.owned(), *own, *parts]


class PenaltyContactTerm(ContactTerm):
    """Penalty contact on nodes with mass: lambda_k = kappa A_k max(0, -g_k) at the position of the kick (METHOD 2)."""

    name = "penalty-contact"
    kernel = "penalty"

    def __init__(self, scene: Scene, domain: Domain) -> None:
        super().__init__(scene, domain)
        assert isinstance(scene.contact, PenaltyContact)
        assert domain.contact is not None
        self.penalty_stiffness = arrays.put(scene.contact.stiffness * domain.contact.areas)
        self.pairs = PairContact(domain) if domain.pairs else None

    def arguments(self) -> dict[str, arrays.Array]:
        """Return the arrays by the names of kernels/language/bundles.Contact."""
        return super().arguments() | {"penalty_stiffness": self.penalty_stiffness}


class ImpulseContactTerm(ContactTerm):
    """Impulse contact: an impulse stops closed nodes, which have mass (Moreau-Jean, restitution 0; METHOD 2)."""

    name = "impulse-contact"
    kernel = "impulse"
