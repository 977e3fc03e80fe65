"""What every contact term shares: the planes, the gaps, the sums of a row."""

from __future__ import annotations

import numpy as np

from .. import arrays
from ..errors import InputError
from ..launch import Prepared
from ..plan import BodyPlan, ContactPlan
from ..scene import Scene
from .boundary_nodes import BoundaryNodes
from .internal_force import InternalForce

MOST_SLOTS = 3  # planes that can hold one node at a time


class ContactTerm:
    """Contact of one body with the planes of the scene; the contact nodes are the first boundary nodes.

    By itself it only checks gaps, which is all there is to do where supports hold every node against the obstacle.

    Subclasses fill in `load`: `contact_force` [k, 3], `totals` (force (3), energy, pressing nodes, static residual).
    """

    name = "contact"

    def __init__(self, scene: Scene, plan: BodyPlan, listed: BoundaryNodes) -> None:
        from ..kernels.planes import nearest_planes, smallest_gap

        assert plan.contact is not None
        contact: ContactPlan = plan.contact
        self.listed = listed
        self.plane_count = len(scene.obstacles)
        self.slots = min(self.plane_count, MOST_SLOTS)
        centre = plan.reference[contact.all_nodes].mean(axis=0)
        self.planes = arrays.put(
            np.array([[*plane.normal, *(plane.project(centre) - centre)] for plane in scene.obstacles])
        )
        self.reference = arrays.put(plan.reference[contact.nodes] - centre)
        self._all_reference = arrays.put(plan.reference[contact.all_nodes] - centre)
        self.nodes = arrays.put(contact.nodes.astype(np.int32))
        self.all_nodes = arrays.put(contact.all_nodes.astype(np.int32))
        self.near = arrays.put(np.tile(np.arange(self.slots, dtype=np.int32), len(contact.nodes)))
        self.contact_force = arrays.zeros(3 * len(contact.nodes))
        self.totals = arrays.zeros(6)
        self._gap = arrays.zeros(1)
        self._nearest = Prepared(nearest_planes)
        self._smallest_gap = Prepared(smallest_gap)

    @property
    def sweeps(self) -> int:
        """Gauss-Seidel sweeps that led to the present state."""
        return 0

    @property
    def trouble(self) -> str | None:
        """What is wrong with the present state, if anything is."""
        return None

    def begin(self, u: arrays.Array, v: arrays.Array, velocity: np.ndarray, dt: float) -> None:
        """Prepare the start; velocity [k, 3] [m/s] of the contact nodes, dt [s] the first step."""

    def velocity(self, u: arrays.Array, dt: float) -> np.ndarray | None:
        """Velocity [k, 3] [m/s] of what has no mass, for output; None if everything has."""
        return None

    def load(self, u: arrays.Array, v: arrays.Array, span: float) -> None:
        """Contact forces at the present u; they leave the force of the boundary nodes. span: time of the kick [s]."""

    def close(self, u: arrays.Array, v: arrays.Array, before: float, after: float) -> None:
        """Place what has no mass after the drift; before, after [s]: the steps before and after level n."""

    def find_planes(self, u: arrays.Array) -> None:
        """Choose the planes that each node is checked against, if there are more than it can touch at once."""
        if self.plane_count > MOST_SLOTS:
            self._nearest(self.nodes, self.planes, self.plane_count, self.reference, u, self.near)

    def gap_min(self, u: arrays.Array) -> float:
        """Smallest gap of the contact set [m]."""
        self._smallest_gap(self.all_nodes, self.planes, self.plane_count, self._all_reference, u, self._gap)
        return float(arrays.get(self._gap)[0])

    def owned(self) -> list[arrays.Array]:
        """Arrays of this term."""
        return [item for item in vars(self).values() if hasattr(item, "shape")]


def make_contact(scene: Scene, plan: BodyPlan, listed: BoundaryNodes, force: InternalForce) -> ContactTerm | None:
    """The contact term of a body, or None if it can touch nothing. The registry of contact terms."""
    from ..contact_models import ImpulseContact, MasslessContact, PenaltyContact

    if plan.contact is None:
        return None
    if len(plan.contact.nodes) == 0:  # supports hold every node of the set along the normals
        return ContactTerm(scene, plan, listed)
    if isinstance(scene.contact, MasslessContact):
        from .massless_contact import MasslessContactTerm

        return MasslessContactTerm(scene, plan, listed, force)
    if isinstance(scene.contact, PenaltyContact):
        from .penalty_contact import PenaltyContactTerm

        return PenaltyContactTerm(scene, plan, listed)
    if isinstance(scene.contact, ImpulseContact):
        from .impulse_contact import ImpulseContactTerm

        return ImpulseContactTerm(scene, plan, listed)
    raise InputError("Scene.contact", scene.contact, "unknown contact model")
