"""Blocks of steps of a domain on a GPU: within a block the host only launches, it reads and copies nothing."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ...cells.device_force import DeviceForce
from ...contact.device_layers import DeviceLayers
from ...contact.pairs.pair_contact import PairContact
from ...device import arrays, runtime
from ...device.launch import Prepared
from ...kernels.columns import RIGID, group_size, raw_places
from ...kernels.lanes import DEVICE_ROWS
from ...kernels.layer_places import ROW as LAYER_ROW
from ...planning.device_path import hindrances
from ...planning.domain import Domain
from ...scene.scene import Scene
from .device_pairs import DevicePairs

LAYERS = len(LAYER_ROW)  # numbers of the friction layers in a row


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
        self._rate_place: int | None = None
        self.layers: DeviceLayers | None = None  # the friction layers, if there are any
        self.pairs: DevicePairs | None = None  # the rows of pairs of bodies, if there are any
        self._bundles: tuple[dict[str, Any], ...] = ()  # of the launches, and their arrays
        self._parts: tuple[tuple[arrays.Array, ...], ...] = ()
        self._steps: list[Prepared] = []  # the launches of a step; with layers they come between two of them

    def layer_arguments(self) -> dict[str, arrays.Array]:
        """Return the arrays of the friction layers by the names of kernels/language/bundles.Contact."""
        return {} if self.layers is None else self.layers.arguments()

    def parts_of_step(self, make: Callable[[str], Any]) -> list[Prepared]:
        """Return the launches of a step; make: its kernel, or that of a part (kernels/step/device_contact.py)."""
        from ...kernels.step.device_contact import LOADS, MOTION

        return [Prepared(make(part)) for part in ([""] if self.layers is None else [LOADS, MOTION])]

    def launch_step(self, offer: int, commit: int, numbers: list[float], given: tuple[arrays.Array, ...]) -> None:
        """Offer a step; numbers [s]: CONTACT_STEPS of the kernels."""
        self._steps[0](offer, commit, *numbers, *given)
        if self.layers is not None:
            self.layers.advance(0.5 * (numbers[0] + numbers[-1]))
            self._steps[1](offer, commit, *numbers, *given)

    def watch_pairs(self, pairs: PairContact | None, u: arrays.Array) -> None:
        """Build the rows of pairs of bodies where the device asks for it; u: displacement."""
        self.pairs = None if pairs is None else DevicePairs(pairs, u)

    def begin_pairs(self) -> None:
        """Begin a block of steps with the present rows of pairs."""
        if self.pairs is not None:
            self.pairs.begin()
            self._take_rows()  # those of a checkpoint may have replaced the arrays

    def build_rows(self) -> None:
        """Build the rows of pairs anew."""
        assert self.pairs is not None
        self.pairs.build()
        self._take_rows()

    def _take_rows(self) -> None:
        """Hand the arrays of the rows of pairs to the launches."""
        from ...kernels.language.signatures import arguments

        assert self.pairs is not None
        self._parts = tuple(arguments(self.pairs.replaced(bundles)) for bundles in self._bundles)

    @property
    def rows_built(self) -> int:
        """How often the rows of pairs were built."""
        return 0 if self.pairs is None else self.pairs.built

    def note_layers(self, rows: np.ndarray) -> None:
        """Take the numbers of the friction layers from the end of each of the rows of the boundary nodes."""
        if self.layers is not None:
            self.layers.rows = rows[:, -LAYERS:]

    def watch(self, groups: tuple[str, ...]) -> None:
        """Watch the rate of free obstacles in the rows, which have these groups of columns."""
        self._rate_place = group_size(*groups[: groups.index("rigid")]) + RIGID.rigid_rate

    def _keep(self, parts: list[arrays.Array]) -> None:
        """Let a block start from these arrays too, of which it needs a copy."""
        for part in parts:
            make = arrays.whole_numbers if "i32" in str(part.dtype) else arrays.zeros
            self._state.append(part)
            self._kept.append(make(int(np.prod(part.shape))))

    def advance(
        self,
        kicks: tuple[float, float, float],
        steps: tuple[float, float],
        rows: int = 1,
        jacobian: float = -np.inf,
        energy: float = np.inf,
        touching: float = np.inf,
        rigid_rate: float = np.inf,
    ) -> np.ndarray:
        """Take steps and return the sums of their rows [done, numbers].

        kicks [s]: before, after, drift; steps [s]: those that end and start at the first row. The last row returned is
        the first one with a det F of at most `jacobian`, an energy above `energy` [J], more than `touching` nodes in
        contact or a rate of free obstacles above `rigid_rate` [1/s^2], if there is any.
        """
        if self.layers is not None:
            self.layers.send()
        if rows > 1:
            for source, target in zip(self._state, self._kept, strict=True):
                arrays.copy(source, target)
        found = self._take(kicks, steps, rows)
        places = self._places
        total = found[:, places.nodes.kinetic] + found[:, places.cells.elastic]
        calm = found[:, places.cells.jacobian_min] > jacobian
        if found.shape[1] > places.shared.kinetic:
            total = total + found[:, places.shared.kinetic]
        if found.shape[1] > places.shared.contact_nodes:  # a domain without contact has no limit of them
            calm = calm & ~(found[:, places.shared.contact_nodes] > touching)
        calm = calm & (total <= energy)
        if self._rate_place is not None:
            calm = calm & (found[:, self._rate_place] <= rigid_rate)
        done = len(found) if calm.all() else int(np.argmin(calm)) + 1
        if done < len(found):
            for target, source in zip(self._state, self._kept, strict=True):
                arrays.copy(source, target)
            if self.pairs is not None:
                self.pairs.go_back()
                self._take_rows()
            found = self._take(kicks, steps, done)
        if self.pairs is not None:
            self.pairs.end()
        return found

    def _take(self, kicks: tuple[float, float, float], steps: tuple[float, float], rows: int) -> np.ndarray:
        u, v = self._state[:2]
        for row in range(rows):
            self.force.advance(u, v, *kicks, before=steps[1 if row else 0], row=row)
        return self.force.ledger_rows(rows)

    def owned(self) -> list[arrays.Array]:
        """Return the arrays of the state that a block starts from."""
        return self._kept
