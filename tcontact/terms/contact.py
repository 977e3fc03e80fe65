"""What every contact term shares: the contact set, the planes, the contact force."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from .. import arrays
from ..errors import InputError
from ..kernels.lanes import CONTACT_SUMS
from ..plan import BodyPlan, ContactPlan
from ..scene import Scene
from .boundary_nodes import BoundaryNodes
from .internal_force import InternalForce

MOST_SLOTS = 3  # planes that can hold one node at a time


class ContactTerm:
    """Contact of one body with the planes of the scene; the contact nodes are the first boundary nodes.

    By itself it only checks gaps, which is all there is to do where supports hold every node against the obstacle.
    `kernel`: what kernels/serial_step.py calls it.
    """

    name = "contact"
    kernel: ClassVar[str] = "gaps"
    block = 1  # massless components of a node
    plain = False  # every node is massless in all components, along x, y and z
    exact = True  # no penalty

    def __init__(self, scene: Scene, plan: BodyPlan) -> None:
        assert plan.contact is not None
        contact: ContactPlan = plan.contact
        self.plane_count = len(scene.obstacles)
        self.slots = min(self.plane_count, MOST_SLOTS)
        centre = plan.reference[contact.all_nodes].mean(axis=0)
        self.planes = arrays.put(
            np.array([[*plane.normal, *(plane.project(centre) - centre)] for plane in scene.obstacles])
        )
        self.reference = arrays.put(plan.reference[contact.nodes] - centre)
        self.all_reference = arrays.put(plan.reference[contact.all_nodes] - centre)
        self.nodes = arrays.put(contact.nodes.astype(np.int32))
        self.all_nodes = arrays.put(contact.all_nodes.astype(np.int32))
        self.near = arrays.put(np.tile(np.arange(self.slots, dtype=np.int32), len(contact.nodes)))
        self.give = arrays.zeros(1)
        self.contact_force = arrays.zeros(3 * len(contact.nodes))
        self.totals = arrays.zeros(CONTACT_SUMS)

    @property
    def trouble(self) -> str | None:
        """What is wrong with the present state, if anything is."""
        return None

    def start_velocity(self, u: arrays.Array, velocity: np.ndarray, dt: float) -> None:
        """Velocity [k, 3] [m/s] with which the contact nodes start; dt [s] the first step."""

    def velocity(self, u: arrays.Array, dt: float) -> np.ndarray | None:
        """Velocity [k, 3] [m/s] of what has no mass, for output; None if everything has."""
        return None

    def arguments(self) -> tuple[arrays.Array, ...]:
        """As in kernels/bundles.Touching, without the massless nodes' own."""
        first = (self.nodes, self.planes, self.near, self.reference, self.all_nodes, self.all_reference)
        return (*first, self.give, self.contact_force, self.totals)

    def owned(self) -> list[arrays.Array]:
        """Arrays of this term."""
        return [item for item in vars(self).values() if hasattr(item, "shape")]


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
    if len(plan.contact.nodes) == 0:  # supports hold every node of the set along the normals
        return ContactTerm(scene, plan)
    if isinstance(scene.contact, MasslessContact):
        from .massless_contact import MasslessContactTerm

        return MasslessContactTerm(scene, plan, force)
    if isinstance(scene.contact, PenaltyContact):
        return PenaltyContactTerm(scene, plan)
    if isinstance(scene.contact, ImpulseContact):
        return ImpulseContactTerm(scene, plan)
    raise InputError("Scene.contact", scene.contact, "unknown contact model")
