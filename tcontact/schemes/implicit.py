"""What the implicit schemes share: the equations of METHOD 4, of which each scheme says how its parts are formed.

    R(x1) = M (c d - b) + f* - fc* - f_ext = 0,   d = x1 - x0,   c = 2/dt^2, b = 2 v0/dt,   v1 = 2 d/dt - v0

f*, fc*: internal and contact force of the step. The mid-step fc* is the contact force of the step in the history.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from .. import validate
from ..contact_models import ImpulseContact
from ..errors import InputError

if TYPE_CHECKING:
    from ..plan import Plan
    from ..scene import Scene


@dataclass(frozen=True)
class ImplicitScheme:
    """An implicit scheme; one of `dt` and `cfl` must be given, its step is not bound by the stable one.

    dt [s]: the step; cfl: the step over the stable step of the explicit scheme; rtol: largest residual of Newton's
    method over the size of the forces; iterations: most of them with full steps, before a line search and then smaller
    steps; mass: "lumped", or "consistent" (with redistribution: paper eq. 13); reproject: bring massless contact nodes
    to equilibrium after every step (None: where the scheme balances them elsewhere than at its end); solver: "direct",
    "krylov" or "auto"; verbose: print every residual.
    Raises `InputError`.
    """

    dt: float | None = None
    cfl: float | None = None
    rtol: float = 1e-12
    iterations: int = 15
    mass: str = "lumped"
    reproject: bool | None = None
    solver: str = "auto"
    verbose: bool = False

    name: ClassVar[str] = ""
    order: ClassVar[int] = 2
    conserves: ClassVar[tuple[str, ...]] = ("linear momentum", "angular momentum")
    implicit: ClassVar[bool] = True
    stress: ClassVar[str] = "end"  # rule of kernels/implicit_rules.py
    level: ClassVar[float] = 1.0  # where between x0 and x1 an "end" rule is taken
    conserving: ClassVar[bool] = False  # contact by difference quotients of its potential
    dissipates: ClassVar[bool] = False  # by design
    chi: ClassVar[float] = 0.0  # dissipation

    def __post_init__(self) -> None:
        if self.dt is None and self.cfl is None:
            raise InputError(
                "dt",
                None,
                f"{type(self).__name__} is not bound by the stable step: give dt [s], or cfl as its multiple",
            )
        for field in ("dt", "cfl", "rtol"):
            if getattr(self, field) is not None:
                validate.number(field, getattr(self, field), low=0.0, high=1e-2 if field == "rtol" else None)
        if self.dt is not None and self.cfl is not None:
            raise InputError("dt", self.dt, f"cfl = {self.cfl:g} is given too; give one of the two")
        validate.whole("iterations", self.iterations, 1)
        validate.choice("mass", self.mass, ("lumped", "consistent"))
        validate.choice("solver", self.solver, ("auto", "direct", "krylov"))
        validate.flag("verbose", self.verbose)
        if self.reproject is not None:
            validate.flag("reproject", self.reproject)

    def step_size(self, dt_limit: float) -> float:
        """The step [s] for a stable step dt_limit [s]."""
        return self.dt if self.dt is not None else float(self.cfl or 1.0) * dt_limit

    @property
    def present(self) -> float:
        """Weight of the force by `stress`."""
        return 1.0

    @property
    def past(self) -> float:
        """Weight of the force of the level before."""
        return 0.0

    @property
    def hourglass_level(self) -> float:
        """Where between its levels the hourglass stiffness is taken."""
        return 1.0 if self.stress == "end" else 0.5

    @property
    def balances_the_end(self) -> bool:
        """Whether what has no mass is in equilibrium at x1 already."""
        return self.stress == "end" and self.level == 1.0 and self.past == 0.0

    def inertia(self, dt: float, v0: np.ndarray, a0: np.ndarray) -> tuple[float, np.ndarray]:
        """c [1/s^2] and b [n, 3] [m/s^2]."""
        return 2.0 / dt**2, 2.0 / dt * v0

    def motion(self, dt: float, d: np.ndarray, v0: np.ndarray, a0: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Velocity and acceleration after the step, [n, 3]."""
        return 2.0 / dt * d - v0, a0

    @property
    def blend(self) -> float:
        """Share of the force of the step in the impulse of the step; the rest is that of the step before."""
        return 1.0

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

    def states(
        self, scene: Scene, planned: Plan, displacement: list[np.ndarray], velocity: list[np.ndarray]
    ) -> list[Any]:
        """The state of every body, which starts there [n, 3]: each has its own equations."""
        from ..implicit.state import ImplicitState

        starts = zip(planned.bodies, displacement, velocity, strict=True)
        return [ImplicitState(scene, body, u, v, planned.layout, self) for body, u, v in starts]

    def begin(self, body: Any, dt: float) -> None:
        """Equilibrium of what has no mass at the start."""
        body.begin_contact(dt)

    def step(self, body: Any, time: float, before: float, after: float, rows: int = 1, **stop_at: float) -> int:
        """Row n, then the step to level n + 1 of length `after` [s], 0 = none. Returns 1."""
        return body.advance(after)
