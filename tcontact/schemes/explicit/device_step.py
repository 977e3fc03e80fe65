"""Blocks of steps of a domain on a GPU: within a block the host only launches, it reads and copies nothing."""

from __future__ import annotations

import numpy as np

from ...cells.device_force import DeviceForce
from ...device import arrays, runtime
from ...kernels.columns import raw_places
from ...kernels.lanes import DEVICE_ROWS
from ...planning.device_path import hindrances
from ...planning.domain import Domain
from ...scene.scene import Scene
from .row_limits import NO_LIMITS, RowLimits


def steps_on_device(scene: Scene, domain: Domain, arch: str | None = None) -> bool:
    """Return whether threads of a GPU step a domain, see `hindrances`.

    If not, the kernels of the CPU step it, which run on a GPU too, slowly. arch: the backend, None = the one in use.
    """
    return (arch or runtime.arch()) == "cuda" and not hindrances(scene, domain)


class DeviceSteps:
    """Steps of a domain in blocks of up to DEVICE_ROWS rows, whose sums the device keeps until their end.

    A block cannot stop at a row that the host must check. Instead the state at its start is kept on the device: if
    such a row is found at the end, the block is taken again up to this row, with the same bits.
    viscous: its rows have the numbers of viscous cells.
    """

    name = "device-steps"
    rows_at_once = DEVICE_ROWS

    def __init__(self, force: DeviceForce, u: arrays.Array, v: arrays.Array, viscous: bool = False) -> None:
        self.force = force
        self._state: list[arrays.Array] = []
        self._kept: list[arrays.Array] = []
        self._keep([part for part in (u, v, force.memory) if part is not None])
        self._places = raw_places(viscous, force.plastic)
        self._rate_place: int | None = None  # of the rate of free obstacles in a row, if there are any

    def _keep(self, parts: list[arrays.Array]) -> None:
        """Let a block start from these arrays too, of which it needs a copy."""
        with arrays.standing_in(None):
            for part in parts:
                make = arrays.whole_numbers if "i32" in str(part.dtype) else arrays.zeros
                self._state.append(part)
                self._kept.append(make(int(np.prod(part.shape))))

    def advance(
        self,
        kicks: tuple[float, float, float],
        steps: tuple[float, float],
        rows: int = 1,
        limits: RowLimits = NO_LIMITS,
    ) -> np.ndarray:
        """Take steps and return the sums of their rows [done, numbers].

        kicks [s]: before, after, drift; steps [s]: those that end and start at the first row. The last row returned is
        the first one beyond the limits, if there is any; here none has a viscous rate.
        """
        if rows > 1:
            self.keep()
        else:
            self._begin_block()
        found = self.take(kicks, steps, rows)
        places = self._places
        total = found[:, places.nodes.kinetic] + found[:, places.cells.elastic]
        calm = found[:, places.cells.jacobian_min] > limits.jacobian
        if found.shape[1] > places.shared.kinetic:
            total = total + found[:, places.shared.kinetic]
        if found.shape[1] > places.shared.contact_nodes:  # a domain without contact has no limit of them
            calm = calm & ~(found[:, places.shared.contact_nodes] > limits.contact_nodes)
        calm = calm & (total <= limits.energy)
        if self._rate_place is not None:
            calm = calm & (found[:, self._rate_place] <= limits.rigid_rate)
        done = len(found) if calm.all() else int(np.argmin(calm)) + 1
        if done < len(found):
            self.put_back()
            found = self.take(kicks, steps, done)
        self._end_block()
        return found

    def keep(self) -> None:
        """Begin a block that may be taken again: keep the state at its start."""
        self._begin_block()
        for source, target in zip(self._state, self._kept, strict=True):
            arrays.copy(source, target)

    def put_back(self) -> None:
        """Go back to the start of the block that `keep` began, to take it again up to an earlier row."""
        for target, source in zip(self._state, self._kept, strict=True):
            arrays.copy(source, target)
        self._repeat_block()

    def _begin_block(self) -> None:
        """Prepare the terms for a block of steps."""

    def _repeat_block(self) -> None:
        """Prepare the terms for the same block again, up to an earlier row."""

    def _end_block(self) -> None:
        """Tell the terms that the block is not taken again."""

    def take(self, kicks: tuple[float, float, float], steps: tuple[float, float], rows: int) -> np.ndarray:
        """Take up to `rows` steps and return the sums of their rows; arguments as of `advance`."""
        u, v = self._state[:2]
        for row in range(rows):
            self.force.advance(u, v, *kicks, before=steps[1 if row else 0], row=row)
        return self.force.ledger_rows(rows)

    def owned(self) -> list[arrays.Array]:
        """Return the arrays of the state that a block starts from."""
        return self._kept
