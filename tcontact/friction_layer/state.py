"""The state of the friction layers at the end of a run, from which another run can start."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .metals import Metal


@dataclass(frozen=True, eq=False)
class LayerState:
    """The friction layers of a body at the end of a run.

    nodes [k]: contact nodes in the user's numbering, of the body alone; depth [points] [m], 0 at the surface;
    temperature [K] and plastic_strain [-] [k, points]; shear_stress [k] [Pa], 0 where the contact is open; material:
    the metal of the body; partners: for every layer that a node has the metal of its second side, None without one, and
    whether that is another body; the values are those of the layer that the node used last. partner_temperature,
    partner_plastic_strain: of its second side, NaN where it has none, None if no layer has one. kinds: the whole kinds
    of these layers (`LayerKind`), in the order of `partners`, whose entries may be equal; () in states of earlier
    versions. `internal` holds the rest of the state.
    """

    nodes: np.ndarray
    depth: np.ndarray
    temperature: np.ndarray
    plastic_strain: np.ndarray
    shear_stress: np.ndarray
    material: Metal
    partners: tuple[tuple[Metal | None, bool], ...] = ((None, False),)
    partner_temperature: np.ndarray | None = None
    partner_plastic_strain: np.ndarray | None = None
    internal: dict[str, np.ndarray] = field(default_factory=dict, repr=False)
    kinds: tuple[Any, ...] = field(default=(), repr=False)

    def fits(self, material: Metal, depth: np.ndarray) -> bool:
        """Return whether layers of this metal and these depths [m] can start from this state."""
        return material == self.material and np.array_equal(depth, self.depth)
