"""What every contact term shares: the contact set, the obstacles, the contact force, friction."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from .. import arrays
from ..errors import InputError
from ..kernels.lanes import MOST_SLOTS
from ..plan import BodyPlan, ContactPlan
from ..scene import Scene
from .boundary_nodes import BoundaryNodes
from .friction import Friction
from .friction_layer import LayeredFriction, make_friction
from .internal_force import InternalForce
from .obstacles import Obstacles

if TYPE_CHECKING:
    from ..kernels.bundles import Kinds

MOST_ROWS = 256  # in one launch of a small body


class ContactTerm:
    """Contact of one body with the obstacles of the scene; the contact nodes are the first boundary nodes.

    By itself it only checks gaps, which is all there is to do where supports hold every node against the obstacle.
    `kernel`: what kernels/serial_step.py calls it.
    """

    name = "contact"
    kernel: ClassVar[str] = "gaps"
    block = 1  # massless components of a node
    plain = False  # every node is massless in all components, along x, y and z
    exact = True  # no penalty
    kicked = True  # some components of contact nodes have mass
    viscous = False  # the contact cells are

    def __init__(self, scene: Scene, plan: BodyPlan) -> None:
        assert plan.contact is not None
        contact: ContactPlan = plan.contact
        self.slots = min(len(scene.obstacles), MOST_SLOTS)
        centre = plan.reference[contact.all_nodes].mean(axis=0)
        self.obstacles = Obstacles(scene, centre, MOST_ROWS if plan.small else 1)
        self.reference = arrays.put(plan.reference[contact.nodes] - centre)
        self.all_reference = arrays.put(plan.reference[contact.all_nodes] - centre)
        self.nodes = arrays.put(contact.nodes.astype(np.int32))
        self.all_nodes = arrays.put(contact.all_nodes.astype(np.int32))
        self.near = arrays.put(np.tile(np.arange(self.slots, dtype=np.int32), len(contact.nodes)))
        self.give = arrays.zeros(1)
        self.contact_force = arrays.zeros(3 * len(contact.nodes))
        self.friction: Friction | None = None

    def rub(self, scene: Scene, plan: BodyPlan) -> None:
        """Take the friction of the scene, if there is any."""
        if scene.friction is not None and plan.contact is not None and len(plan.contact.nodes):
            stays = self.kernel == "massless" and self.block > 1
            self.friction = make_friction(scene, plan.contact, self.slots, stays)

    @property
    def kinds(self) -> Kinds:
        """What its kernels are made for."""
        from ..kernels.bundles import Kinds

        obstacles, friction = self.obstacles, self.friction
        return Kinds(
            self.block,
            self.slots,
            obstacles.shapes,
            obstacles.moving,
            obstacles.tracked and self.kernel != "gaps",
            "" if friction is None else friction.law,
            isinstance(friction, LayeredFriction),
            friction is not None and self.kicked,
            self.viscous,
        )

    @property
    def trouble(self) -> str | None:
        """What is wrong with the present state, if anything is."""
        return None

    def start_velocity(self, u: arrays.Array, velocity: np.ndarray, dt: float) -> None:
        """Velocity [k, 3] [m/s] with which the contact nodes start; dt [s] the first step."""

    def velocity(self, u: arrays.Array, dt: float) -> np.ndarray | None:
        """Velocity [k, 3] [m/s] of what has no mass, for output; None if everything has."""
        return None

    def arguments(self) -> dict[str, arrays.Array]:
        """Arrays by the names of kernels/bundles.Touching; what it does not have is left out."""
        obstacles, friction = self.obstacles, self.friction
        arguments = {
            "nodes": self.nodes,
            "obstacles": obstacles.records,
            "motion": obstacles.motion,
            "near": self.near,
            "reference": self.reference,
            "all_nodes": self.all_nodes,
            "all_reference": self.all_reference,
            "give": self.give,
            "force": self.contact_force,
        }
        if friction is not None:
            arguments |= {"friction": friction.data, "traces": friction.traces}
        return arguments

    def owned(self) -> list[arrays.Array]:
        """Arrays of this term."""
        return [*self.obstacles.owned(), *(item for item in vars(self).values() if hasattr(item, "shape"))]


class PenaltyContactTerm(ContactTerm):
    """lambda_k = kappa A_k max(0, -g_k) on nodes with their ordinary mass, from the position of the kick (METHOD 2)."""

    name = "penalty-contact"
    kernel = "penalty"

    def __init__(self, scene: Scene, plan: BodyPlan) -> None:
        from ..contact_models import PenaltyContact

        super().__init__(scene, plan)
        assert isinstance(scene.contact, PenaltyContact)
        assert plan.contact is not None
        self.give = arrays.put(scene.contact.stiffness * plan.contact.areas)


class ImpulseContactTerm(ContactTerm):
    """Closed nodes of ordinary mass get the impulse that stops them (Moreau-Jean, restitution 0; METHOD 2)."""

    name = "impulse-contact"
    kernel = "impulse"


def make_contact(
    scene: Scene, plan: BodyPlan, listed: BoundaryNodes | None, force: InternalForce
) -> ContactTerm | None:
    """The contact term of a body, or None if it can touch nothing. The registry of contact terms."""
    from ..contact_models import ImpulseContact, MasslessContact, PenaltyContact

    if plan.contact is None:
        return None
    term: ContactTerm
    if len(plan.contact.nodes) == 0:  # supports hold every node of the set along the normals
        term = ContactTerm(scene, plan)
    elif isinstance(scene.contact, MasslessContact):
        from .massless_contact import MasslessContactTerm

        term = MasslessContactTerm(scene, plan, force)
    elif isinstance(scene.contact, PenaltyContact):
        term = PenaltyContactTerm(scene, plan)
    elif isinstance(scene.contact, ImpulseContact):
        term = ImpulseContactTerm(scene, plan)
    else:
        raise InputError("Scene.contact", scene.contact, "unknown contact model")
    term.rub(scene, plan)
    return term
