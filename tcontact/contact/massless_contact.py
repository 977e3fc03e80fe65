"""Contact nodes without mass, placed by a projected static solve every step (METHOD 2, paper 4.3)."""

from __future__ import annotations

import numpy as np

from ..cells.cell_viscosity import CellViscosity
from ..cells.device_force import DeviceForce
from ..cells.device_viscosity import DeviceCellViscosity
from ..cells.internal_force import InternalForce
from ..device import arrays
from ..planning.body_plan import BodyPlan
from ..planning.domain import Domain
from ..planning.islands import island_starts
from ..planning.sweep_order import sweep_order
from ..scene.contact_models import MasslessContact
from ..scene.scene import Scene
from .pairs.pair_contact import PairContact
from .static_solve import StaticSolve
from .term import ContactTerm


class MasslessContactTerm(ContactTerm):
    """Exact contact, or a penalty, in the massless components of the contact nodes.

    f_K - f_ext,K = lambda nu,  g >= 0,  lambda >= 0,  lambda g = 0
    """

    name = "massless-contact"
    kernel = "massless"

    def __init__(self, scene: Scene, domain: Domain, force: InternalForce) -> None:
        super().__init__(scene, domain)
        model, contact = scene.contact, domain.contact
        assert isinstance(model, MasslessContact)
        assert contact is not None
        assert contact.basis is not None
        assert contact.graph is not None
        self.block = contact.block
        self.plain = bool(self.block == 3 and (contact.basis == np.eye(3)).all())
        self.exact = model.penalty is None
        self.kicked = bool(domain.inverses[: len(contact.nodes)].any())
        stiffness = np.inf if model.penalty is None else model.penalty * contact.areas
        self.massless = contact.basis[:, :, : self.block]
        self.basis = arrays.put(self.massless)
        self.compliance = arrays.put(np.broadcast_to(1.0 / stiffness, (len(contact.nodes),)))
        self.active = arrays.put(np.zeros(len(contact.nodes), dtype=np.int32))
        self.displacement_before = arrays.zeros(len(contact.nodes) * self.block)
        start, rows = domain.residual_receivers
        self.residual_receivers = arrays.put(np.concatenate([start + len(start), rows]))
        order = sweep_order(contact.graph, self.block)
        self.starts = arrays.put(island_starts(self.islands, self.others, order))
        self.pairs = PairContact(domain, model.tolerance) if domain.pairs else None
        self.labels = [scene.obstacle_label(number) for number in range(len(scene.obstacles))]
        self.order = order
        self.residual_shares: arrays.Array | None = None
        ghosts = 0
        if domain.shared is not None:
            self.shared, ghosts = True, len(domain.shared.ghosts)
            self.residual_shares = arrays.zeros(3 * len(contact.nodes))
        self.static_solve = StaticSolve(scene, domain, force, order, self.islands, self.slots, ghosts)
        self.projected = self.static_solve.projected
        self.viscous = domain.viscous_cells
        made = DeviceCellViscosity if isinstance(force, DeviceForce) else CellViscosity
        self.cell_viscosity = made(domain, force) if self.viscous else None

    @property
    def trouble(self) -> tuple[BodyPlan, str] | None:
        """The first body whose last static solve did not converge, and the reason; or None."""
        found = self.static_solve.trouble
        if found is not None or self.pairs is None or self.slots == 1:
            return found
        obstacles = [self.labels[number % len(self.labels)] for number in arrays.get(self.candidates)]
        return self.pairs.squeezed(self.slots, obstacles)

    def start_velocity(self, u: arrays.Array, velocity: np.ndarray, dt: float) -> None:
        """Set the velocity [k, 3] [m/s] of the contact nodes for the first prediction; dt [s]: first step."""
        now = self.displacement(u)
        arrays.set_values(self.displacement_before, now - dt * np.einsum("kic,ki->kc", self.massless, velocity))

    def displacement(self, u: arrays.Array) -> np.ndarray:
        """Return the massless components [k, block] of the displacement."""
        moved = arrays.get(u).reshape(-1, 3)[arrays.get(self.nodes)[: len(self.massless)]]
        return np.einsum("kic,ki->kc", self.massless, moved)

    def velocity(self, u: arrays.Array, dt: float) -> np.ndarray:
        """Return the position difference over the last step [k, 3] [m/s], massless components only."""
        now = self.displacement(u)
        return np.einsum(
            "kic,kc->ki", self.massless, (now - arrays.get(self.displacement_before).reshape(now.shape)) / dt
        )

    def arguments(self) -> dict[str, arrays.Array]:
        """Return the arrays by the names of kernels/language/bundles.Contact."""
        shares = {} if self.residual_shares is None else {"residual_shares": self.residual_shares}
        return super().arguments() | {
            "basis": self.basis,
            "compliance": self.compliance,
            "active": self.active,
            "displacement_before": self.displacement_before,
            "residual_receivers": self.residual_receivers,
            **shares,
        }

    def owned(self) -> list[arrays.Array]:
        return [*super().owned(), *self.static_solve.owned()]
