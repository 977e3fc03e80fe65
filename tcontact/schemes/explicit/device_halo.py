"""Forces of shared nodes in the steps of a rank whose part of a domain a GPU steps: staged through the host."""

from __future__ import annotations

import numpy as np

from ...device import arrays
from ...device.exchange import Exchange
from ...device.launch import Prepared


class DeviceHalo:
    """Adds the forces of other ranks between two launches of a step.

    exchange: of the shared nodes one after the other; rows [k]: the boundary nodes that they are; force [s, 3] [N]: of
    the boundary nodes; control: numbers that decide what the device does (kernels/step/device_control.py).
    """

    def __init__(self, exchange: Exchange, rows: np.ndarray, force: arrays.Array, control: arrays.Array) -> None:
        from ...kernels.step.device_control import NOTHING
        from ...kernels.step.device_halo import gather_shared, scatter_shared

        self._turn = NOTHING  # what is next where the device takes a step
        self.exchange, self._force, self._control = exchange, force, control
        with arrays.standing_in(None):
            self._scratch = arrays.zeros(3 * len(rows) + 1)
            self._rows = arrays.put(rows.astype(np.int32))
        self._gather, self._scatter = Prepared(gather_shared), Prepared(scatter_shared)

    def add(self) -> bool:
        """Add the parts of all ranks where the device has taken the step that was offered; return whether it has."""
        self._gather(self._force, self._rows, *arrays.placed(self._control), self._scratch)
        staged = np.array(arrays.get(self._scratch))
        if staged[-1] != self._turn:
            return False
        self.exchange.add(staged[:-1].reshape(-1, 3))
        arrays.set_values(self._scratch, staged)
        self._scatter(self._force, self._rows, self._scratch)
        return True

    def pass_over(self, steps: int) -> None:
        """Take part in the exchanges of steps that this rank cannot take, which the ranks will take again."""
        for _ in range(steps):
            self.exchange.add(np.zeros((len(self.exchange.rows), 3)))

    def owned(self) -> list[arrays.Array]:
        """Return the arrays of the exchange."""
        return [self._scratch, self._rows]
