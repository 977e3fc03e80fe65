"""Contact force and pressure of the nodes, for frames: only contact nodes have any."""

from __future__ import annotations

import numpy as np

from ..results.files.late_fields import LateField, Part
from ..schemes.explicit.body_view import BodyView


class ContactFields:
    """Hands over contact force [N] and pressure [Pa] of all bodies as they are at their contact nodes.

    paired: bodies touch each other, so that the areas change.
    """

    def __init__(self, states: list[BodyView], paired: bool) -> None:
        self._states, self._paired = states, paired
        self._nodes, self._areas, self._where = [], [], []
        for state in states:
            nodes, area = self._contact_nodes(state), state.plan.contact_areas()
            self._nodes.append(nodes)
            self._areas.append(area[nodes])
            self._where.append(np.flatnonzero(area[nodes] > 0.0))

    def fields(self) -> tuple[LateField, LateField]:
        """Return force [n, 3] and pressure [n] of the last row."""
        both = [self._of(number) for number in range(len(self._states))]
        return LateField(tuple(force for force, _ in both)), LateField(tuple(pressure for _, pressure in both))

    def _contact_nodes(self, state: BodyView) -> np.ndarray:
        """Return the nodes of the user to which `_values` belong; all of a body with periodic images."""
        plan = state.plan
        if plan.images is not None:
            return np.arange(len(plan.reference))
        if plan.contact is None:
            return np.empty(0, np.int64)
        nodes = plan.node_order[plan.contact.nodes]
        return np.concatenate([nodes, state.held_masters()[0]]) if self._paired else nodes

    def _values(self, state: BodyView) -> np.ndarray:
        """Return the contact force [k, 3] of the nodes."""
        if state.plan.images is not None:
            return state.contact_force()
        if state.plan.contact is None:
            return np.zeros((0, 3))
        force = state.contact_node_force()
        return np.concatenate([force, state.held_masters()[1]]) if self._paired else force

    def _of(self, number: int) -> tuple[Part, Part]:
        """Return force and pressure of a body."""
        state, nodes, where = self._states[number], self._nodes[number], self._where[number]
        force, area = self._values(state), self._areas[number]
        if self._paired:
            area = state.contact_areas()[nodes]
            where = np.flatnonzero(area > 0.0)
        pressure = np.zeros(len(force))
        pressure[where] = np.linalg.norm(force[where], axis=1) / area[where]
        count = (float(len(state.plan.reference)),)
        return Part("spread", (force,), (nodes,), count), Part("spread", (pressure,), (nodes,), count)
