"""The state of one body during a run: its arrays and its terms, in the internal numbering."""

from __future__ import annotations

import numpy as np

from . import arrays
from .history import PLACE, WIDTH
from .plan import BodyPlan
from .scene import Scene
from .terms.boundary_nodes import BoundaryNodes, Supports
from .terms.contact import ContactTerm, make_contact
from .terms.internal_force import InternalForce


class BodyState:
    """Displacement u and velocity v (flat [3n]) of a body, and the terms it has.

    displacement, velocity [n, 3]: where the body starts, in the user's numbering.
    """

    def __init__(self, scene: Scene, plan: BodyPlan, displacement: np.ndarray, velocity: np.ndarray) -> None:
        self.plan = plan
        order = plan.node_order
        self.u = arrays.put(displacement[order])
        self.start_velocity = velocity[order]
        self.internal_force = InternalForce(plan, plan.cells, plan.reference, plan.lumped, plan.boundary)
        self.reference = self.internal_force.reference
        self.listed: BoundaryNodes | None = None
        self.supports: Supports | None = None
        self.contact: ContactTerm | None = None
        if len(plan.boundary):
            self.listed = BoundaryNodes(plan, self.internal_force.special_force)
            self.contact = make_contact(scene, plan, self.listed)
        if self.listed is not None and len(plan.support_rows):
            self.supports = Supports(plan, self.listed)
        self.v = arrays.put(self._massive(self.start_velocity))
        self._support = (np.zeros(3), 0.0)
        self._gap = np.inf

    def _massive(self, velocity: np.ndarray) -> np.ndarray:
        """The velocity without its massless components."""
        result = velocity.copy()
        contact = self.plan.contact
        if contact is not None and contact.basis is not None:
            along = np.einsum("kic,ki->kc", contact.basis, velocity[contact.nodes])
            result[contact.nodes] -= np.einsum("kic,kc->ki", contact.basis, along)
        return result

    def begin_contact(self, dt: float) -> None:
        """Bring massless nodes to equilibrium at the start."""
        if self.contact is not None and self.plan.contact is not None:
            self.contact.begin(self.u, self.start_velocity[self.plan.contact.nodes], dt)

    def measure(self) -> None:
        """What row n needs from before the drift of the boundary nodes."""
        if self.supports is not None:
            self._support = self.supports.react()
        if self.contact is not None:
            self._gap = self.contact.gap_min(self.u)
            self._contact = np.array(arrays.get(self.contact.totals))
            self._sweeps = self.contact.sweeps

    def row(self, time: float) -> np.ndarray:
        """The measured row of the last step (history.MEASURED)."""
        row = np.zeros(WIDTH)
        nodes, elastic, jacobian, hourglass = self.internal_force.sums()
        row[PLACE["time"]] = time
        row[PLACE["elastic"]] = elastic
        row[PLACE["jacobian_min"]] = jacobian
        row[PLACE["hourglass"]] = hourglass
        sums = np.zeros(8)
        if self.listed is not None:
            sums = self.listed.sums()
        row[PLACE["kinetic"]] = nodes[0] + sums[0]
        row[PLACE["momentum"]] = nodes[1:4] + sums[1:4]
        row[PLACE["angular_momentum"]] = nodes[4:7] + sums[4:7]
        row[PLACE["load_work"]] = nodes[7:10] @ self.plan.gravity + sums[7]
        row[PLACE["support_force"]], row[PLACE["support_power"]] = self._support
        row[PLACE["gap_min"]] = self._gap
        if self.contact is not None:
            row[PLACE["contact_force"]] = self._contact[:3]
            row[PLACE["contact"]] = self._contact[3]
            row[PLACE["contact_nodes"]] = self._contact[4]
            row[PLACE["static_residual"]] = self._contact[5]
            row[PLACE["sweeps"]] = self._sweeps
        return row

    def displacement(self) -> np.ndarray:
        """Displacement [n, 3] in the user's numbering."""
        return self._to_user(np.array(arrays.get(self.u)).reshape(-1, 3))

    def half_step_velocity(self) -> np.ndarray:
        """Velocity [n, 3] of the components with mass, internal numbering, as it stands."""
        return np.array(arrays.get(self.v)).reshape(-1, 3)

    def massless_velocity(self, dt: float) -> np.ndarray | None:
        """Position difference over dt of the massless components [k, 3]; None without any."""
        return None if self.contact is None else self.contact.velocity(self.u, dt)

    def velocity(self, massive: np.ndarray, massless: np.ndarray | None) -> np.ndarray:
        """Velocity [n, 3] in the user's numbering from both parts."""
        result = massive.copy()
        if massless is not None and self.plan.contact is not None:
            result[self.plan.contact.nodes] += massless
        return self._to_user(result)

    def contact_force(self) -> np.ndarray:
        """Contact force on every node [n, 3] [N] of the last row, in the user's numbering."""
        result = np.zeros((len(self.plan.reference), 3))
        if self.contact is not None and self.plan.contact is not None:
            nodes = self.plan.contact.nodes
            result[nodes] = arrays.get(self.contact.contact_force)[: 3 * len(nodes)].reshape(-1, 3)
        return self._to_user(result)

    def contact_areas(self) -> np.ndarray:
        """Area weight [n] [m^2] of every node; 0 off the contact set."""
        result = np.zeros(len(self.plan.reference))
        if self.plan.contact is not None:
            result[self.plan.contact.nodes] = self.plan.contact.areas
        return self._to_user(result)

    def _to_user(self, values: np.ndarray) -> np.ndarray:
        result = np.empty_like(values)
        result[self.plan.node_order] = values
        return result

    def memory(self) -> dict[str, int]:
        """Bytes by term."""
        result = {"state": arrays.size_in_bytes([self.u, self.v])}
        for term in (self.internal_force, self.listed, self.supports, self.contact):
            if term is not None:
                result[term.name] = arrays.size_in_bytes(term.owned())
        return result
