"""Blocks of steps of a domain on a GPU: within a block the host only launches, it reads and copies nothing."""

from __future__ import annotations

import numpy as np

from ...cells.device_force import DeviceForce
from ...device import arrays, runtime
from ...kernels.columns import raw_places
from ...kernels.lanes import DEVICE_ROWS
from ...planning.domain import Domain
from ...scene.scene import Scene
from ..sensors import sensed


def steps_on_device(scene: Scene, domain: Domain, arch: str | None = None) -> bool:
    """Return whether `DeviceSteps` can step a domain: on a GPU, if all of its nodes are ordinary ones.

    Contact, supports, loads other than constant gravity, springs, rigid parts, periodic bodies, bulk viscosity,
    node-averaged cells and probes are stepped by the kernels of the CPU, which run on a GPU too, slowly.
    arch: the backend, None = the one in use.
    """
    from ...kernels.elements import FUNCTIONS

    if (arch or runtime.arch()) != "cuda":
        return False
    if len(domain.boundary) or domain.contact is not None or domain.images is not None:
        return False
    if domain.rigid or domain.springs or domain.loaded or domain.viscosity is not None:
        return False
    averaged = any(FUNCTIONS[element].averaged for element, _law in domain.kinds)
    return not averaged and not sensed(scene, domain.bodies)


class DeviceSteps:
    """Steps of a domain in blocks of up to DEVICE_ROWS rows, whose sums the device keeps until their end.

    A block cannot stop at a row that the host must check. Instead the state at its start is kept on the device: if
    such a row is found at the end, the block is taken again up to this row, with the same bits.
    """

    name = "device-steps"
    rows_at_once = DEVICE_ROWS

    def __init__(self, force: DeviceForce, u: arrays.Array, v: arrays.Array) -> None:
        self.force = force
        self._state = [part for part in (u, v, force.memory) if part is not None]
        self._kept = [arrays.zeros(int(np.prod(part.shape))) for part in self._state]
        self._places = raw_places(False, force.plastic)

    def advance(
        self,
        kicks: tuple[float, float, float],
        steps: tuple[float, float],
        rows: int = 1,
        jacobian: float = -np.inf,
        energy: float = np.inf,
    ) -> np.ndarray:
        """Take steps and return the sums of their rows [done, numbers].

        kicks [s]: before, after, drift; steps [s]: those that end and start at the first row. The last row returned is
        the first one with a det F of at most `jacobian` or an energy above `energy` [J], if there is any.
        """
        if rows > 1:
            for source, target in zip(self._state, self._kept, strict=True):
                arrays.copy(source, target)
        found = self._take(kicks, steps, rows)
        total = found[:, self._places.nodes.kinetic] + found[:, self._places.cells.elastic]
        calm = (total <= energy) & (found[:, self._places.cells.jacobian_min] > jacobian)
        done = rows if calm.all() else int(np.argmin(calm)) + 1
        if done < rows:
            for target, source in zip(self._state, self._kept, strict=True):
                arrays.copy(source, target)
            found = self._take(kicks, steps, done)
        return found

    def _take(self, kicks: tuple[float, float, float], steps: tuple[float, float], rows: int) -> np.ndarray:
        u, v = self._state[:2]
        for row in range(rows):
            self.force.advance(u, v, *kicks, before=steps[1 if row else 0], row=row)
        return self.force.ledger_rows(rows)

    def owned(self) -> list[arrays.Array]:
        """Return the arrays of the state that a block starts from."""
        return self._kept
