"""The state at a level of time, for frames and for the result."""

from __future__ import annotations

import numpy as np

from ..schemes.explicit.body_view import BodyView


class Snapshot:
    """The state at level n: taken before the step that starts there, complete once the step is done.

    v^n is the mean of v^{n-1/2} before and v^{n+1/2} after the kick. before, after [s]: the steps that end and start
    here; dt [s]: the step of a run, where none has ended; whole: the velocity is that of the level.
    """

    def __init__(self, states: list[BodyView], before: float, after: float, dt: float, whole: bool = False) -> None:
        self.states = states
        # an implicit scheme has the velocity at the level
        self.share = before / (before + after) if before + after > 0.0 and not whole else 0.0
        self.displacements = [state.displacement() for state in states]
        self._halves = [state.half_step_velocity() for state in states]
        self._massless = [state.massless_velocity(before or dt) for state in states]

    def velocities(self) -> list[np.ndarray]:
        """Return v^n [n, 3] of every body in the user's numbering."""
        parts = zip(self.states, self._halves, self._massless, strict=True)
        return [
            state.velocity(old + self.share * (state.half_step_velocity() - old), massless)
            for state, old, massless in parts
        ]
