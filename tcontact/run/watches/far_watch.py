"""Stop a run in which a body comes to an obstacle that was out of reach at the start (`reach.within_reach`).

With normal removal its contact nodes keep their mass along the normal of such an obstacle, which could not stop them.
The next look comes before half of the remaining distance can be covered.
"""

from __future__ import annotations

import numpy as np

from ...scene.contact_models import MasslessContact
from ...scene.reach import within_reach
from ..guards import Stop
from ..watched import Run
from .pace import NodePace
from .path_watch import RARELY, Crossing, times_to_come


class FarWatch:
    """Looks for contact nodes that have come to an obstacle out of reach.

    far: pairs of the number of a body and of an obstacle.
    """

    ends_launches = True

    def __init__(self, run: Run, far: list[tuple[int, int]]) -> None:
        self.due, self._seen = 0, -1
        self._pace = NodePace(run, RARELY)
        obstacles = run.scene.obstacles
        self._far = [(body, number, Crossing(run.states[body], obstacles[number], 1.0, run.dt)) for body, number in far]

    @staticmethod
    def of(run: Run) -> FarWatch | None:
        """Make the looks of a run; None if all obstacles are within reach or the contact nodes have no mass."""
        far, scene = [], run.scene
        if isinstance(scene.contact, MasslessContact):
            for index, state in enumerate(run.states):
                contact = state.plan.contact
                if contact is not None and contact.removal == "normal" and len(contact.nodes):
                    reached = within_reach(
                        scene.starting(index), scene.obstacles, scene.duration, scene.largest_gravity
                    )
                    far += [(index, number) for number in range(len(scene.obstacles)) if number not in reached]
        return FarWatch(run, far) if far else None

    def look(self, run: Run, row: int, time: float, step: float) -> Stop | None:
        """Stop where a contact node has come to such an obstacle."""
        rows, largest = max(1, row - self._seen), 0.0
        ahead: list[tuple[float, float]] = []
        for index, number, crossing in self._far:
            state = run.states[index]
            now = crossing.positions(state, time + step)
            if not np.isfinite(now).all():
                return None  # the guards stop at the next row
            gap = float(crossing.obstacle.local(now)[0].min())
            if gap <= 0.0:
                name = run.scene.obstacle_label(number)
                where = f"{state.plan.label} comes to obstacle {name} at t = {time + step:.6g} s"
                return Stop(
                    "missed-contact",
                    f"{where}, which was out of its reach at the start, and removal='normal' kept the mass of its nodes"
                    " along that normal: use MasslessContact(removal='full')",
                )
            largest = max(largest, float(np.linalg.norm(now - crossing.before, axis=1).max()))
            crossing.before = now
            ahead.append((0.5 * gap, crossing.speed_to_come(times_to_come(run, time, step))))
        self._pace.follow(largest, time + step, step)
        wait = min(self._pace.rows(room, step, faster) for room, faster in ahead)
        self.due, self._seen = row + max(1, int(min(wait, self._pace.most(rows, RARELY)))), row
        return None
