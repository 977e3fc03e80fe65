"""Put back what a block of steps has changed in a domain, where ranks find behind it that it ends earlier.

Kept are the arrays of the nodes, and what the terms at boundary nodes hold (device/leaves.py): not what stands in cells
whose law keeps a state, pairs of bodies, functions of time, sensors and layers, with which blocks have one row.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ...device import arrays
from ...device.leaves import Leaf, Saved, leaves
from .state import DomainState


class Rewind:
    """What a block of steps of a domain can change: 48 bytes a node and a copy of the terms at boundary nodes."""

    def __init__(self, state: DomainState) -> None:
        force, serial = state.internal_force, state.serial
        parts = {
            "fields": [state.u, state.v, force.special_force, force.node_sums, force.cell_sums],
            "sums": [] if serial is None else [serial.sums],
            "terms": [state.boundary_nodes, state.supports, state.contact, state.rigid],
        }
        found: dict[int, Leaf] = {}
        for number, leaf in enumerate(leaves(parts)):
            if not isinstance(leaf.value, Saved):  # functions of time, which blocks of several rows do not have
                found.setdefault(id(leaf.value) if leaf.is_array else -number, leaf)
        self._leaves = list(found.values())
        self._values: list[Any] = [None] * len(self._leaves)

    def keep(self) -> None:
        """Copy what is there now."""
        for number, leaf in enumerate(self._leaves):
            present, kept = leaf.present, self._values[number]
            if not leaf.is_array:
                self._values[number] = list(present) if isinstance(present, list) else present
            elif isinstance(kept, np.ndarray) and kept.shape == present.shape:
                np.copyto(kept, arrays.get(present))
            else:
                self._values[number] = np.array(arrays.get(present))

    def put_back(self) -> None:
        """Set everything to what `keep` has copied."""
        for leaf, kept in zip(self._leaves, self._values, strict=True):
            leaf.value = leaf.present
            leaf.put(list(kept) if isinstance(kept, list) else kept)
