"""Nodes of a body that watches read again and again."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True, eq=False)
class Chosen:
    """Nodes of a body, see `ChosenNodes.chosen`.

    nodes [k]: their internal numbers; number: how the ranks of a run name them.
    """

    nodes: np.ndarray
    number: int = 0


class ChosenNodes:
    """What every view of a body has of chosen nodes; on several ranks they alone come from other ranks (RankView)."""

    plan: Any

    def latest(self) -> np.ndarray:
        """Return the present displacement [n, 3] [m], internal numbering: after a step that at its end."""
        raise NotImplementedError

    def chosen(self, nodes: np.ndarray) -> Chosen:
        """Return what `start_of` and `latest_of` take for some nodes [k], each once, internal numbering."""
        return Chosen(nodes)

    def start_of(self, chosen: Chosen) -> np.ndarray:
        """Return the positions [k, 3] [m] of chosen nodes before anything moves."""
        return np.asarray(self.plan.reference[chosen.nodes])

    def latest_of(self, chosen: Chosen) -> np.ndarray:
        """Return the present displacement [k, 3] [m] of chosen nodes, see `latest`."""
        return self.latest()[chosen.nodes]
