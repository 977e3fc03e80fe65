"""Warn of bodies of the linear law that have turned: it holds for small rotations only.

Its strain of a rotation by an angle a is cos a - 1 across the axis, so that a body that turns freely bears stresses of
its own, which hold it back: it does not spin as a rigid body does.
"""

from __future__ import annotations

import numpy as np

from ...base.warning_kinds import RotationWarning
from ...planning.rotation import angle, rotation, turns_freely
from ...scene.body import Body
from ..guards import Stop
from ..watched import Run

TURNED = 0.2  # [rad]: a strain of 2 %
SAMPLES = 512  # largest number of nodes for the rotation of a body
NEVER = 2**62
REMEDY = (
    "LinearElastic holds for small rotations only, its stresses there are not those of a deformation;"
    " use StVenantKirchhoff or NeoHookean, which agree with it at small strains"
)


class LinearWatch:
    """Looks once, at the end of the run, at bodies with cells of the linear law that may turn."""

    due, ends_launches = NEVER, False

    def __init__(self, run: Run, numbers: list[int]) -> None:
        self._bodies = []
        for number in numbers:
            state = run.states[number]
            picked = np.arange(0, state.plan.node_count, -(-state.plan.node_count // SAMPLES))
            chosen = state.chosen(picked)
            reference = state.start_of(chosen)
            start = reference + state.latest_of(chosen)
            self._bodies.append((number, chosen, reference, start))

    @staticmethod
    def of(run: Run) -> LinearWatch | None:
        """Make the watch of a run; None if no body has the linear law, or supports keep these from turning."""
        numbers = [i for i, body in enumerate(run.scene.bodies) if _is_linear(body) and turns_freely(body)]
        return LinearWatch(run, numbers) if numbers else None

    def look(self, run: Run, row: int, time: float, step: float) -> Stop | None:
        """Warn of the bodies that have turned, after the last row."""
        if step > 0.0:
            return None
        for number, chosen, reference, start in self._bodies:
            state = run.states[number]
            now = reference + state.latest_of(chosen)
            far = angle(rotation(start, now, np.ones(len(now)))) if np.isfinite(now).all() else 0.0
            if far > TURNED:
                text = f"{state.plan.label} ends turned by {np.degrees(far):.2g} degrees"
                run.warn(f"{text}; {REMEDY}", RotationWarning)
        return None


def _is_linear(body: Body) -> bool:
    return any(getattr(material, "linear", False) for material in body.materials)
