"""Penalty contact on nodes with their ordinary mass: the usual baseline (METHOD 2, end)."""

from __future__ import annotations

from .. import arrays
from ..contact_models import PenaltyContact
from ..launch import Prepared
from ..plan import BodyPlan
from ..scene import Scene
from .boundary_nodes import BoundaryNodes
from .contact import ContactTerm


class PenaltyContactTerm(ContactTerm):
    """lambda_k = kappa A_k max(0, -g_k) from the position of the kick."""

    name = "penalty-contact"

    def __init__(self, scene: Scene, plan: BodyPlan, listed: BoundaryNodes) -> None:
        from ..kernels.contact_load import penalty_load

        super().__init__(scene, plan, listed)
        assert isinstance(scene.contact, PenaltyContact)
        assert plan.contact is not None
        self.stiffness = arrays.put(scene.contact.stiffness * plan.contact.areas)
        self.kernel = Prepared(penalty_load)

    def load(self, u: arrays.Array, v: arrays.Array, span: float) -> None:
        self.kernel(
            self.nodes,
            self.planes,
            self.plane_count,
            self.stiffness,
            self.reference,
            u,
            self.listed.force,
            self.contact_force,
            self.totals,
        )
