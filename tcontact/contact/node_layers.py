"""The friction layers of the contact nodes of a domain: one for every metal that a node may slide on.

A node uses the layer of the partner that it is pressed on hardest; its other layers rest, open, and keep their heat.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..device import arrays, runtime
from ..friction_layer import Layer
from ..scene.friction_models import FrictionLayer
from ..scene.layer_metals import LayerKind

TOTALS = ("WORK", "PLASTIC_WORK")  # numbers of a cell that count over all layers of a node


class NodeLayers:
    """Batches of layers of contact nodes [k].

    kinds: of each batch; nodes: its contact nodes, ascending; used [k]: the batch that a node uses.
    """

    def __init__(self, model: FrictionLayer, kinds: Sequence[LayerKind], nodes: Sequence[np.ndarray], count: int):
        self.kinds, self.nodes = tuple(kinds), list(nodes)
        with arrays.standing_in(None):  # batches of one kind share a kernel
            self.batches = [
                Layer(
                    kind.metals,
                    len(mine),
                    points=model.points,
                    grading=model.grading,
                    thickness=model.thickness,
                    heat_share=model.heat_share,
                    plastic_heat=model.plastic_heat,
                    initial_temperature=model.initial_temperature,
                    method=model.method,
                    reload=model.reload,
                    open_ends=kind.open_ends,
                    start_temperatures=kind.temperatures,
                    arch=runtime.arch(),
                )
                for kind, mine in zip(kinds, nodes, strict=True)
            ]
        self.used = np.zeros(count, dtype=np.int64)
        for number, mine in reversed(list(enumerate(nodes))):
            self.used[mine] = number
        self._speeds, self._pressures = ([arrays.zeros(one.padded) for one in self.batches] for _ in range(2))

    @property
    def plain(self) -> bool:
        """Return whether there is one batch, of layers with one side."""
        return len(self.kinds) == 1 and self.kinds[0].partner is None

    def batches_of(self, part: slice) -> list[int]:
        """Return the batches that the contact nodes of a body have; part: their slice of all."""
        return [number for number, nodes in enumerate(self.nodes) if part.start in nodes]

    def places(self, number: int, part: slice) -> slice:
        """Return where the contact nodes of a body stand in a batch."""
        return slice(*np.searchsorted(self.nodes[number], (part.start, part.stop)))

    def advance(self, speed: np.ndarray, pressure: np.ndarray, cap: np.ndarray, drag: np.ndarray, dt: float) -> None:
        """Advance all layers by a step [s]; arrays [k] as in `Layer.advance` and `Layer.limit_traction`."""
        for number, (batch, nodes) in enumerate(zip(self.batches, self.nodes, strict=True)):
            mine = self.used[nodes] == number
            batch.limit_traction(cap[nodes], drag[nodes])
            arrays.set_values(self._speeds[number], np.where(mine, speed[nodes], 0.0))
            arrays.set_values(self._pressures[number], np.where(mine, pressure[nodes], 0.0))
            batch.advance(self._speeds[number], self._pressures[number], dt)

    def cell(self, name: str) -> np.ndarray:
        """Return a number [k] of the layers that are used by its name in kernels/layer/layer1d_step; totals of all."""
        found = [batch.cell(name) for batch in self.batches]
        if name not in TOTALS:
            return self.of_used(found)
        total = np.zeros(len(self.used))
        for nodes, values in zip(self.nodes, found, strict=True):
            total[nodes] += values
        return total

    def of_used(self, values: Sequence[np.ndarray]) -> np.ndarray:
        """Return the values [k, ...] of the layers that are used out of those of each batch."""
        result = np.zeros((len(self.used), *values[0].shape[1:]))
        for number, (nodes, own) in enumerate(zip(self.nodes, values, strict=True)):
            mine = self.used[nodes] == number
            result[nodes[mine]] = own[mine]
        return result

    def surface_temperature(self) -> np.ndarray:
        """Return the absolute temperature [k] [K] of the surfaces of the bodies."""
        return self.of_used([batch.surface_temperature() for batch in self.batches])

    def melting_rise(self) -> float:
        """Return the rise of temperature [K] that melts the metal that melts first."""
        lowest = min(metal.melting_temperature for batch in self.batches for metal in batch.metals)
        return float(max(lowest - self.batches[0].initial_temperature, 1.0))

    def softness(self) -> float:
        """Return the most that heat [J/m^2] of a time [s] warms a surface, times the root of this time over the heat.

        A half space that takes it at a constant rate; two sides share it by conduction.
        """
        shares = [batch.heat_share if len(batch.metals) == 1 else 1.0 for batch in self.batches]
        sums = [sum(metal.effusivity for metal in batch.metals) for batch in self.batches]
        return float(max(2.0 / np.sqrt(np.pi) * share / total for share, total in zip(shares, sums, strict=True)))

    def limit_stress(self, pressure: np.ndarray) -> np.ndarray:
        """Return tau [k] [Pa] of layers whose contact closes now; pressure [k] [Pa]."""
        return self.of_used(
            [b.limit_stress(pressure[nodes]) for b, nodes in zip(self.batches, self.nodes, strict=True)]
        )

    def to_obstacles(self) -> np.ndarray:
        """Return the heat [k] [J/m^2] of the layer steps that went to the side of obstacles so far."""
        total = np.zeros(len(self.used))
        for kind, batch, nodes in zip(self.kinds, self.batches, self.nodes, strict=True):
            if kind.partner is None:
                total[nodes] += (1.0 - batch.heat_share) * batch.cell("WORK")
            elif not kind.bodies:
                total[nodes] += batch.cell("OTHER")
        return total

    def profiles(self, name: str, side: int = 0) -> np.ndarray:
        """Return `Layer.temperature` or `Layer.plastic_strain` [k, points] of a side; NaN where there is none."""
        empty = [np.full((len(nodes), self.batches[0].points), np.nan) for nodes in self.nodes]
        found = [
            getattr(batch, name)(side) if side < len(batch.metals) else nothing
            for batch, nothing in zip(self.batches, empty, strict=True)
        ]
        return self.of_used(found)

    def owned(self) -> list[Any]:
        """Return the arrays of the layers."""
        parts = [part for batch in self.batches for part in batch.owned()]
        return [*parts, *self._speeds, *self._pressures]
