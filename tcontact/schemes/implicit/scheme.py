"""The base class of the implicit schemes: the equations of METHOD 4, whose parts each scheme defines.

    R(x1) = M (c d - b) + f* - fc* - f_ext = 0,   d = x1 - x0,   c = 2/dt^2, b = 2 v0/dt,   v1 = 2 d/dt - v0

f*, fc*: internal and contact force of the step. The mid-step fc* is the contact force of the step in the history.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...base.errors import InputError
from ...planning.planning import Plan
from ...scene.cell_blocks import AVERAGED
from ...scene.contact_models import ImpulseContact
from ...scene.friction_models import NoFriction
from ...scene.scene import Scene
from .solution.describe import describe
from .solution.rule import ImplicitRule
from .solution.state import ImplicitState


@dataclass(frozen=True)
class ImplicitScheme(ImplicitRule):
    """An implicit scheme, whose step is not bounded by the stable step; `dt` or `cfl` is required.

    dt [s]: the step; cfl: the step over the stable step that the explicit scheme has without a contact penalty; rtol:
    largest residual of Newton's method over the size of the forces; iterations: maximum number with full steps,
    before a line search and then smaller steps; mass: "lumped", or "consistent" (with redistribution: paper eq. 13);
    reproject: bring massless contact nodes to equilibrium after every step (None: if the scheme does not balance them
    at its end); solver: "direct", "krylov" or "auto"; verbose: report every residual (logger "tcontact" at INFO, else
    printed). Raises `InputError`.
    """

    def check(self, planned: Plan) -> None:
        """Refuse terms that implicit steps do not have. Raises `InputError`."""
        scene = planned.scene
        for number, obstacle in enumerate(scene.obstacles):
            if not isinstance(obstacle.friction, NoFriction | None):
                remedy = f"{self.name} takes none; leave it at None or use scheme='central-difference'"
                raise InputError(f"Scene.obstacles[{number}].friction", obstacle.friction, remedy)
        for field in ("friction", "damping", "viscosity"):
            if getattr(scene, field) is not None:
                remedy = f"{self.name} takes none; leave it at None or use scheme='central-difference'"
                raise InputError(f"Scene.{field}", getattr(scene, field), remedy)
        if isinstance(scene.contact, ImpulseContact):
            remedy = f"{self.name} needs a force at every gap: use MasslessContact or PenaltyContact"
            raise InputError("Scene.contact", scene.contact, remedy)
        if self.mass == "consistent" and getattr(scene.contact, "depth", 1) > 1:
            remedy = "the consistent mass is redistributed within cells only: use depth=1 or mass='lumped'"
            raise InputError("MasslessContact.depth", getattr(scene.contact, "depth", 1), remedy)
        for one in planned.bodies if self.mass == "consistent" else ():
            if len(one.body.blocks) > 1:
                remedy = f"{one.label} has several kinds of cells or materials; use mass='lumped'"
                raise InputError("mass", self.mass, remedy)
            contact = one.contact
            if contact is not None and contact.basis is not None and np.isin(one.cells, contact.nodes).all(1).any():
                remedy = "a cell has contact nodes only, and none to take their mass; use mass='lumped'"
                raise InputError("mass", self.mass, remedy)
        for index, body in enumerate(scene.bodies):
            field = f"Scene.bodies[{index}]"
            if body.driven:
                remedy = f"{self.name} takes no functions of time; give a constant or use scheme='central-difference'"
                raise InputError(f"{field}.supports", body.driven[0], remedy)
            if body.springs:
                remedy = f"{self.name} has no springs; use scheme='central-difference'"
                raise InputError(f"{field}.springs", body.springs[0], remedy)
            if body.point_masses and self.mass == "consistent":
                remedy = "the consistent mass has no point masses; use mass='lumped'"
                raise InputError(f"{field}.point_masses", body.point_masses[0], remedy)
        if scene.body_pairs:
            remedy = f"{self.name} has no contact between bodies; leave it at 'auto' or use scheme='central-difference'"
            raise InputError("Scene.pairs", scene.body_pairs[0].name, remedy)
        if callable(scene.gravity):
            remedy = f"{self.name} takes constant gravity; give a vector or use scheme='central-difference'"
            raise InputError("Scene.gravity", scene.gravity, remedy)
        for index, body in enumerate(scene.bodies):
            for load in body.loads:
                if load.varies or load.kind == "pressure":
                    remedy = f"{self.name} takes constant tractions and forces; use scheme='central-difference'"
                    raise InputError(f"Scene.bodies[{index}].loads: {load.kind}", load.value, remedy)
            if body.rigid_parts:
                remedy = f"{self.name} has no rigid parts; use scheme='central-difference'"
                raise InputError(f"Scene.bodies[{index}].rigid_parts", body.rigid_parts[0].set, remedy)
            if body.periodic is not None:
                remedy = f"{self.name} knows no periodic bodies; use scheme='central-difference'"
                raise InputError(f"Scene.bodies[{index}].periodic", body.periodic, remedy)
            if any(block.formulation == AVERAGED for block in body.blocks):
                remedy = f"{self.name} averages no volume changes at nodes; give formulation='full', mesh the body with"
                remedy += " hex8 and formulation='mean-dilatation', or use scheme='central-difference'"
                raise InputError(f"Scene.bodies[{index}].formulation", AVERAGED, remedy)
        for number, obstacle in enumerate(scene.obstacles):
            if getattr(obstacle, "moves", False):
                remedy = f"{self.name} takes obstacles at rest; use scheme='central-difference'"
                raise InputError(f"Scene.obstacles[{number}]", obstacle.name or type(obstacle).__name__, remedy)

    def describe(self, planned: Plan) -> str:
        """Describe equations, sizes and linear solver of a plan in words."""
        return describe(planned, self)

    def states(
        self, scene: Scene, planned: Plan, displacement: list[np.ndarray], velocity: list[np.ndarray]
    ) -> list[Any]:
        """Make the state of every body with its own equations; displacement, velocity: its start [n, 3]."""
        starts = zip(planned.bodies, displacement, velocity, strict=True)
        return [ImplicitState(scene, body, u, v, planned.layout, self) for body, u, v in starts]

    def begin(self, body: Any, dt: float) -> None:
        """Bring massless nodes to equilibrium at the start."""
        body.begin_contact(dt)

    def step(self, body: Any, time: float, before: float, after: float, rows: int = 1, **stop_at: float) -> int:
        """Do row n, then the step to level n + 1 of length `after` [s], 0 = none. Returns 1."""
        return body.advance(after)
