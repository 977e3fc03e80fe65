"""Impulse contact on nodes with their ordinary mass, restitution 0 (Moreau-Jean; METHOD 2, end)."""

from __future__ import annotations

from .. import arrays
from ..launch import Prepared
from ..plan import BodyPlan
from ..scene import Scene
from .boundary_nodes import BoundaryNodes
from .contact import ContactTerm


class ImpulseContactTerm(ContactTerm):
    """Closed nodes get the impulse that stops them; the reported force is the impulse over the step."""

    name = "impulse-contact"

    def __init__(self, scene: Scene, plan: BodyPlan, listed: BoundaryNodes) -> None:
        from ..kernels.contact_load import make_impulse_load

        super().__init__(scene, plan, listed)
        self.kernel = Prepared(make_impulse_load(self.slots))

    def load(self, u: arrays.Array, v: arrays.Array, span: float) -> None:
        self.find_planes(u)
        self.kernel(
            self.nodes,
            self.planes,
            self.near,
            self.listed.inverse_mass,
            self.listed.load,
            self.reference,
            u,
            v,
            span,
            self.listed.force,
            self.contact_force,
            self.totals,
        )
