"""The state at a level of time, for frames and for the result."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property

import numpy as np

from ..results.files.late_fields import LateField, Part
from ..schemes.explicit.body_view import BodyView


class Snapshot:
    """The state at level n: taken before the step that starts there, complete once the step is done.

    v^n is the mean of v^{n-1/2} before and v^{n+1/2} after the kick. before, after [s]: the steps that end and start
    here; dt [s]: the step of a run, where none has ended; whole: the velocity is that of the level. moved: displacement
    [n, 3] [m] of every body in the numbering of its plan.
    """

    def __init__(self, states: list[BodyView], before: float, after: float, dt: float, whole: bool = False) -> None:
        self.states = states
        # an implicit scheme has the velocity at the level
        self.share = before / (before + after) if before + after > 0.0 and not whole else 0.0
        self.moved = [np.array(state.latest()) for state in states]
        self._halves = [np.array(state.half_step_velocity()) for state in states]
        self._massless = [state.massless_velocity(before or dt) for state in states]

    @cached_property
    def displacements(self) -> list[np.ndarray]:
        """Return the displacement [n, 3] [m] of every body in the user's numbering."""
        return [part.values() for part in self.displacement_field().parts]

    def displacement_field(self) -> LateField:
        """Return the displacement [n, 3] [m] of all bodies."""
        parts = zip(self.moved, self.states, strict=True)
        return LateField(tuple(Part("renumbered", (moved,), (state.plan.place,)) for moved, state in parts))

    def last_displacements(self) -> Iterator[np.ndarray]:
        """Yield the displacement [n, 3] [m] of every body in the user's numbering, which the snapshot then forgets."""
        self.__dict__.pop("displacements", None)
        for number, state in enumerate(self.states):
            values = state.plan.to_user(self.moved[number])
            self.moved[number] = values[:0]
            yield values

    def last_values(self) -> tuple[list[np.ndarray], list[np.ndarray]]:
        """Return displacement and v^n [n, 3] of every body in the user's numbering; the snapshot forgets all it has."""
        found = [*self.last_displacements()], [part.values() for part in self.velocity_field().parts]
        self.states, self._halves, self._massless = [], [], []
        return found

    def velocity_field(self) -> LateField:
        """Return v^n [n, 3] of all bodies; its arrays change with the next step."""
        parts = zip(self.states, self._halves, self._massless, strict=True)
        return LateField(tuple(self._velocity(*part) for part in parts))

    def _velocity(self, state: BodyView, old: np.ndarray, massless: np.ndarray | None) -> Part:
        """Return v^n of a body; old: its velocity before the kick."""
        plan, new = state.plan, state.half_step_velocity()
        if plan.images is not None:
            return Part("as they are", (state.velocity(old + self.share * (new - old), massless),))
        if massless is None or plan.contact is None:
            return Part("velocity", (old, new), (plan.place,), (self.share,))
        return Part("velocity", (old, new, massless), (plan.place, plan.node_order[plan.contact.nodes]), (self.share,))
