"""Blocks of steps on a GPU of a domain with boundary nodes: what is the same with a static solve and without one."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ...cells.device_force import DeviceForce
from ...contact.bundles import boundary_bundle, contact_bundles
from ...contact.device_layers import DeviceLayers
from ...contact.layered_friction import LayeredFriction
from ...contact.term import ContactTerm
from ...device import arrays
from ...device.exchange import Exchange
from ...device.launch import Prepared
from ...kernels.columns import RIGID, group_size
from ...kernels.lanes import DEVICE_ROWS
from ...kernels.layer_places import ROW as LAYER_ROW
from ...nodes.boundary_nodes import BoundaryNodes
from ...nodes.rigid_bodies import RigidBodies
from ...planning.device_blocks import scratch
from ...planning.domain import Domain
from .device_halo import DeviceHalo
from .device_loads import DeviceLoads
from .device_pairs import DevicePairs, pair_arguments
from .device_step import DeviceSteps

LAYERS = len(LAYER_ROW)  # numbers of the friction layers in a row
Shared = tuple[Exchange, np.ndarray]


class DeviceTermSteps(DeviceSteps):
    """Steps in blocks as `DeviceSteps`, of a domain with boundary nodes, whose loads, layers and pairs it knows.

    A row on the device has the sums of the boundary nodes, the power of the viscous cells and the numbers of the
    layers. groups: of the columns in the raw rows of the domain; shared: where other ranks have copies of its nodes,
    what adds their forces and which of the boundary nodes these are; viscous: it has viscous contact cells; blocks: of
    threads that share the boundary nodes.
    """

    def __init__(
        self,
        domain: Domain,
        groups: tuple[str, ...],
        force: DeviceForce,
        u: arrays.Array,
        v: arrays.Array,
        boundary: BoundaryNodes,
        contact: ContactTerm | None,
        shared: Shared | None,
        viscous: bool = False,
        blocks: int = 1,
    ) -> None:
        from ...kernels.step import device_control

        super().__init__(force, u, v, viscous)
        self.names, self._groups = device_control, groups
        self.width = group_size(*groups[groups.index("boundary") :])
        friction = None if contact is None else contact.friction
        self._row_width = self.width + int(viscous) + (LAYERS if isinstance(friction, LayeredFriction) else 0)
        self._own = {
            "sums": arrays.zeros(self.width),
            "shared": arrays.zeros(scratch(blocks)),
            "control": arrays.zeros(device_control.DEVICE_CONTROL + DEVICE_ROWS * self._row_width),
        }
        if domain.counted is not None:
            self._own["counted"] = arrays.put(domain.counted)
        self.halo: DeviceHalo | None = None
        if shared is not None:
            self.halo = DeviceHalo(*shared, force.special_force, self._own["control"])
        self.layers: DeviceLayers | None = None
        if contact is not None and isinstance(friction, LayeredFriction):
            self.layers = DeviceLayers(friction, contact, self._own["control"])
        pairs = None if contact is None else contact.pairs
        self.pairs = None if pairs is None else DevicePairs(pairs, u)
        self.loads = DeviceLoads(domain, force, u, boundary)
        self._bundles: tuple[dict[str, Any], ...] = ()  # of the launches, and their arrays
        self._parts: tuple[tuple[arrays.Array, ...], ...] = ()
        self._steps: list[Prepared] = []  # the launches of a step, between which come messages and layers

    def _term_bundles(self, boundary: BoundaryNodes, contact: ContactTerm | None, **more: arrays.Array) -> dict:
        """Return the bundles of boundary nodes, obstacles, rows and contact nodes; more: fields of the last one."""
        sums, own = self._own["sums"], ("shared", "counted")
        shared: dict[str, arrays.Array] = {name: self._own[name] for name in own if name in self._own}
        shared |= {} if self.layers is None else self.layers.arguments()
        shared |= pair_arguments(None if contact is None else contact.pairs)
        return {
            "boundary": boundary_bundle(boundary, sums, **self.loads.arguments()),
            **contact_bundles(contact, sums, **shared, **more),
        }

    def _keep_terms(self, contact: ContactTerm | None, rigid: RigidBodies | None) -> None:
        """Keep what loads, layers, contact and free obstacles need to take a block again; watch the last of these."""
        if self.layers is not None:
            self._keep(self.layers.kept())
        if self.loads.name:
            self._keep(self.loads.kept)
        if contact is None:
            return
        posed = contact.obstacles.posed
        self._keep([contact.candidates, *([contact.obstacles.records] if posed else [])])
        if contact.friction is not None:
            assert contact.rows is not None
            self._keep([contact.rows.values, contact.friction.data])
        if rigid is not None:
            before = self._groups[: self._groups.index("rigid")]
            self._rate_place = group_size(*before) + RIGID.rigid_rate
            self._keep([rigid.values, *([] if posed else [contact.obstacles.records])])

    def _launches(self, make: Callable[[tuple[str, ...]], Any]) -> list[Prepared]:
        """Return the launches of a step; make: the kernel of some stages (kernels/step/device_contact.py)."""
        from ...kernels.step.device_contact import FORCES, LOADS, MOTION

        stages: list[tuple[str, ...]] = [(FORCES,), (MOTION,)]
        if self.layers is not None:
            stages.insert(1, (LOADS,))
        if self.halo is None:  # nothing comes behind the forces
            stages[:2] = [stages[0] + stages[1]]
        return [Prepared(make(one)) for one in stages]

    def _launch_step(self, offer: int, kicks: tuple[float, float, float], steps: tuple[float, float]) -> None:
        """Offer a step; arguments as of `advance`."""
        commit = int(self.force.memory is not None)
        numbers = [float(number) for number in (steps[0] or self.force.resting, *kicks, *self.force.gravity, steps[1])]
        given, launches = (offer, commit, *numbers, *self._parts[0]), iter(self._steps)
        next(launches)(*given)
        if self.halo is not None:
            self.halo.add()
            next(launches)(*given)
        if self.layers is not None:
            self.layers.advance(0.5 * (steps[0] + steps[1]))
            next(launches)(*given)

    def _pass_over(self, steps: int) -> None:
        """Let other ranks go on in steps that this one cannot take."""
        if self.halo is not None:
            self.halo.pass_over(steps)

    def count_steps(self, control: np.ndarray) -> None:
        """Let the pairs count the steps of the present block; control: the numbers of the device."""
        if self.pairs is not None:
            self.pairs.passed(int(control[self.names.TAKEN]))

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

    def _begin_pairs(self) -> None:
        """Begin a block of steps with the present rows of pairs."""
        if self.pairs is not None:
            self.pairs.begin()
            self._take_rows()  # those of a checkpoint may have replaced the arrays

    def _begin_block(self) -> None:
        if self.layers is not None:
            self.layers.send()

    def _repeat_block(self) -> None:
        if self.pairs is not None:
            self.pairs.go_back()
            self._take_rows()

    def _end_block(self) -> None:
        if self.pairs is not None:
            self.pairs.end()

    def _rows_of(self, control: np.ndarray, taken: int) -> np.ndarray:
        """Return the rows that a block has left on the device [taken, numbers], and give the layers theirs."""
        rows = control[self.names.DEVICE_CONTROL :].reshape(-1, self._row_width)[:taken]
        if self.layers is not None:
            self.layers.rows = rows[:, -LAYERS:]
        return rows

    def owned(self) -> list[arrays.Array]:
        """Return the arrays of the steps beside those of their terms."""
        others = [] if self.layers is None else self.layers.owned()
        others += [] if self.halo is None else self.halo.owned()
        return [*super().owned(), *self._own.values(), *self.loads.owned(), *others]
