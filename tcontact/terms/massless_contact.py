"""Contact nodes without mass, placed by a projected static solve every step (METHOD 2, paper 4.3)."""

from __future__ import annotations

import numpy as np

from .. import arrays
from ..contact_models import MasslessContact
from ..launch import Prepared
from ..plan import BodyPlan
from ..scene import Scene
from .boundary_nodes import BoundaryNodes
from .contact import ContactTerm
from .internal_force import InternalForce
from .static_solve import StaticSolve


class MasslessContactTerm(ContactTerm):
    """f_K - f_ext,K = lambda nu, g >= 0, lambda >= 0, lambda g = 0 in the massless components of the contact nodes."""

    name = "massless-contact"

    def __init__(self, scene: Scene, plan: BodyPlan, listed: BoundaryNodes, force: InternalForce) -> None:
        from ..kernels.massless_contact import make_contact_load, make_predict

        super().__init__(scene, plan, listed)
        model, contact = scene.contact, plan.contact
        assert isinstance(model, MasslessContact)
        assert contact is not None
        assert contact.basis is not None
        block = contact.block
        stiffness = np.inf if model.penalty is None else model.penalty * contact.areas
        self.exact = 1 if model.penalty is None else 0
        self.gravity = plan.gravity
        self.massless = contact.basis[:, :, :block]
        self.basis = arrays.put(self.massless)
        self.compliance = arrays.put(np.broadcast_to(1.0 / stiffness, (len(contact.nodes),)))
        self.last = arrays.zeros(len(contact.nodes) * block)
        self.static_solve = StaticSolve(plan, model, self, force, self.basis, self.compliance)
        self._predict = Prepared(make_predict(block, self.slots))
        self._load = Prepared(make_contact_load(block, self.slots))

    @property
    def sweeps(self) -> int:
        """Gauss-Seidel sweeps that led to the present state."""
        return self.static_solve.sweeps

    @property
    def trouble(self) -> str | None:
        """What is wrong with the present state, if anything is."""
        return None if self.static_solve.converged else self.static_solve.message

    def begin(self, u: arrays.Array, v: arrays.Array, velocity: np.ndarray, dt: float) -> None:
        """Static solve at the start; the first prediction then goes on with the given velocity [k, 3] of K."""
        self.find_planes(u)
        self._project(u, 0.0, 0.0)
        self.static_solve.equilibrate(u, v)
        now = self.displacement(u)
        arrays.set_values(self.last, now - dt * np.einsum("kic,ki->kc", self.massless, velocity))

    def displacement(self, u: arrays.Array) -> np.ndarray:
        """Massless components [k, block] of the displacement."""
        moved = arrays.get(u).reshape(-1, 3)[arrays.get(self.nodes)]
        return np.einsum("kic,ki->kc", self.massless, moved)

    def velocity(self, u: arrays.Array, dt: float) -> np.ndarray:
        """Position difference over the last step, massless components only [k, 3] [m/s]."""
        now = self.displacement(u)
        return np.einsum("kic,kc->ki", self.massless, (now - arrays.get(self.last).reshape(now.shape)) / dt)

    def load(self, u: arrays.Array, v: arrays.Array, span: float) -> None:
        self._load(
            self.nodes,
            self.basis,
            self.planes,
            self.near,
            self.reference,
            u,
            self.listed.load,
            self.compliance,
            self.static_solve.active,
            self.listed.force,
            self.static_solve.stats,
            self.contact_force,
            self.totals,
        )

    def close(self, u: arrays.Array, v: arrays.Array, before: float, after: float) -> None:
        """x_K^{n+1}: predicted by extrapolation, then brought to equilibrium with x_J^{n+1}."""
        self.find_planes(u)
        self._project(u, after / before if before > 0.0 else 1.0, after * (before + after) / 2)
        self.static_solve.equilibrate(u, v)

    def _project(self, u: arrays.Array, ratio: float, fall_time: float) -> None:
        """Extrapolate; fall_time [s^2] times gravity is what free flight adds."""
        fall = fall_time * self.gravity
        self._predict(
            self.nodes, self.basis, self.planes, self.near, self.reference, ratio, *fall, self.exact, u, self.last
        )

    def owned(self) -> list[arrays.Array]:
        return [*super().owned(), *self.static_solve.owned()]
