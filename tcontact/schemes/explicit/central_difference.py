"""Central difference (leapfrog) where there is mass, static solve where there is none (METHOD 2, paper eqs 14-17).

    v^{n+1/2} = v^{n-1/2} + dt M^-1 r(x^n),     x^{n+1} = x^n + dt v^{n+1/2}       where there is mass,
    f_K(x_J, x_K) - f_ext,K = lambda nu,  g >= 0,  lambda >= 0,  lambda g = 0      where there is none.

The kick starts and ends with half a step: v^n = (v^{n-1/2} + v^{n+1/2})/2 is the velocity of row n.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from ...base import validate
from ...base.errors import InputError
from ...planning.planning import Plan
from ...scene.scene import Scene
from .state import DomainState

if TYPE_CHECKING:
    import numpy as np


DEFAULT_CFL = 0.9


@dataclass(frozen=True)
class CentralDifference:
    """The central difference scheme: explicit, second order; docs/choosing.md ("Step") names what is of first.

    cfl: step over the stable step that the program computes (default 0.9); or dt [s]: the step, taken as given.
    Raises `InputError` if both are given or one is not positive.
    """

    cfl: float | None = None
    dt: float | None = None

    name: ClassVar[str] = "central-difference"
    implicit: ClassVar[bool] = False
    order: ClassVar[int] = 2
    conserves: ClassVar[tuple[str, ...]] = ("linear momentum", "angular momentum")

    def __post_init__(self) -> None:
        if self.cfl is not None:
            validate.keep(self, "cfl", low=0.0)
        if self.dt is not None:
            validate.keep(self, "dt", low=0.0)
            if self.cfl is not None:
                raise InputError("dt", self.dt, f"cfl = {self.cfl:g} is given too; give one of the two")

    def step_size(self, dt_limit: float) -> float:
        """Return the step [s] for a stable step dt_limit [s]."""
        return self.dt if self.dt is not None else (self.cfl or DEFAULT_CFL) * dt_limit

    def check(self, planned: Plan) -> None:
        """Accept the scene: this scheme runs every scene."""

    def states(
        self, scene: Scene, planned: Plan, displacement: list[np.ndarray], velocity: list[np.ndarray]
    ) -> list[DomainState]:
        """Make the state of every domain; displacement, velocity: start of every body [n, 3]."""
        found = []
        for domain in planned.domains:
            u, v = ([values[number] for number in domain.numbers] for values in (displacement, velocity))
            found.append(DomainState(scene, domain, u, v, planned.layout))
        return found

    def begin(self, body: DomainState, dt: float) -> None:
        """Solve for the massless contact nodes at the start; dt [s]: the first step."""
        body.begin_contact(dt)

    def step(self, body: DomainState, time: float, before: float, after: float, rows: int = 1, **stop_at: float) -> int:
        """Step to x^{n+1}: half a kick of the step before, row n, half a kick and the drift of the step after.

        time [s]: of level n; before, after [s]: the steps that end and start there, 0 before the first and after the
        last row. A small domain does up to `rows` such steps at once; stop_at: see `DomainState.advance`.
        Returns the rows done.
        """
        return body.advance(before / 2, after / 2, after, time, (before, after), rows, **stop_at)
