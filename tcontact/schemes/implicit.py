"""What the implicit schemes share: the equations of METHOD 4, of which each scheme says how its parts are formed.

    R(x1) = M (c d - b) + f* - fc* - f_ext = 0,   d = x1 - x0,   c = 2/dt^2, b = 2 v0/dt,   v1 = 2 d/dt - v0

f*, fc*: internal and contact force of the step. The mid-step fc* is the contact force of the step in the history.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..contact_models import ImpulseContact
from ..errors import InputError
from ..implicit.describe import describe
from ..implicit.rule import ImplicitRule
from ..implicit.state import ImplicitState
from ..plan import Plan
from ..scene import Scene


@dataclass(frozen=True)
class ImplicitScheme(ImplicitRule):
    """An implicit scheme; one of `dt` and `cfl` must be given, its step is not bound by the stable one.

    dt [s]: the step; cfl: the step over the stable step of the explicit scheme; rtol: largest residual of Newton's
    method over the size of the forces; iterations: most of them with full steps, before a line search and then smaller
    steps; mass: "lumped", or "consistent" (with redistribution: paper eq. 13); reproject: bring massless contact nodes
    to equilibrium after every step (None: where the scheme balances them elsewhere than at its end); solver: "direct",
    "krylov" or "auto"; verbose: print every residual.
    Raises `InputError`.
    """

    def check(self, planned: Plan) -> None:
        """Refuse what implicit steps do not have. Raises `InputError`."""
        scene = planned.scene
        for field in ("friction", "damping", "viscosity"):
            if getattr(scene, field) is not None:
                remedy = f"{self.name} takes none; leave it at None or use scheme='central-difference'"
                raise InputError(f"Scene.{field}", getattr(scene, field), remedy)
        if isinstance(scene.contact, ImpulseContact):
            remedy = f"{self.name} needs a force at every gap: use MasslessContact or PenaltyContact"
            raise InputError("Scene.contact", scene.contact, remedy)
        if self.mass == "consistent" and getattr(scene.contact, "depth", 1) > 1:
            remedy = "the consistent mass is handed over inside the cells alone: use depth=1 or mass='lumped'"
            raise InputError("MasslessContact.depth", getattr(scene.contact, "depth", 1), remedy)
        for one in planned.bodies if self.mass == "consistent" else ():
            contact = one.contact
            if contact is not None and contact.basis is not None and np.isin(one.cells, contact.nodes).all(1).any():
                remedy = "a cell has contact nodes alone and no node to hand their mass to; use mass='lumped'"
                raise InputError("mass", self.mass, remedy)
        for index, body in enumerate(scene.bodies):
            if body.periodic is not None:
                remedy = f"{self.name} knows no periodic bodies; use scheme='central-difference'"
                raise InputError(f"Scene.bodies[{index}].periodic", body.periodic, remedy)
        for number, obstacle in enumerate(scene.obstacles):
            if getattr(obstacle, "moves", False):
                remedy = f"{self.name} takes obstacles at rest; use scheme='central-difference'"
                raise InputError(f"Scene.obstacles[{number}]", obstacle.name or type(obstacle).__name__, remedy)

    def describe(self, planned: Plan) -> str:
        """Equations, sizes and linear solver of a plan in words."""
        return describe(planned, self)

    def states(
        self, scene: Scene, planned: Plan, displacement: list[np.ndarray], velocity: list[np.ndarray]
    ) -> list[Any]:
        """The state of every body, which starts there [n, 3]: each has its own equations."""
        starts = zip(planned.bodies, displacement, velocity, strict=True)
        return [ImplicitState(scene, body, u, v, planned.layout, self) for body, u, v in starts]

    def begin(self, body: Any, dt: float) -> None:
        """Equilibrium of what has no mass at the start."""
        body.begin_contact(dt)

    def step(self, body: Any, time: float, before: float, after: float, rows: int = 1, **stop_at: float) -> int:
        """Row n, then the step to level n + 1 of length `after` [s], 0 = none. Returns 1."""
        return body.advance(after)
