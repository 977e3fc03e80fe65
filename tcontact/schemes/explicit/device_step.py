"""Blocks of steps of a domain on a GPU: within a block the host only launches, it reads and copies nothing."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ...cells.device_force import DeviceForce
from ...contact.device_layers import DeviceLayers
from ...device import arrays, runtime
from ...device.launch import Prepared
from ...kernels.columns import RIGID, group_size, raw_places
from ...kernels.lanes import DEVICE_ROWS
from ...kernels.layer_places import ROW as LAYER_ROW
from ...planning.domain import Domain
from ...scene.contact_models import ImpulseContact, MasslessContact, PenaltyContact
from ...scene.friction_models import FrictionLayer
from ...scene.layer_metals import warms_bodies
from ...scene.scene import Scene
from ..sensors import sensed

LAYERS = len(LAYER_ROW)  # numbers of the friction layers in a row


def steps_on_device(scene: Scene, domain: Domain, arch: str | None = None) -> bool:
    """Return whether threads of a GPU step a domain: its nodes, supports and contact.

    Supports, springs and loads are of all kinds but own forces of the user, contact is that with obstacles, with or
    without friction, friction layers among it. Pairs of bodies, friction layers that warm cells, own forces, rigid
    parts, periodic bodies, bulk viscosity, node-averaged cells and probes are stepped by the kernels of the CPU, which
    run on a GPU too, slowly. arch: the backend, None = the one in use.
    """
    from ...kernels.elements import FUNCTIONS

    if (arch or runtime.arch()) != "cuda":
        return False
    if not _boundary_on_device(scene, domain) or domain.images is not None:
        return False
    if any(one.part is not None for one in domain.rigid) or domain.viscosity is not None:
        return False
    if any(load.own for body in domain.bodies for load in body.body.loads):
        return False
    averaged = any(FUNCTIONS[element].averaged for element, _law in domain.kinds)
    return not averaged and not sensed(scene, domain.bodies)


def _boundary_on_device(scene: Scene, domain: Domain) -> bool:
    """Return whether threads of a GPU step the boundary nodes of a domain, or there are none."""
    contact = domain.contact
    if domain.mixed and len(domain.boundary):
        return False
    if contact is None:
        return not domain.rigid
    if not isinstance(scene.contact, MasslessContact | PenaltyContact | ImpulseContact) or not len(contact.nodes):
        return False
    return not domain.pairs and not (isinstance(scene.friction, FrictionLayer) and warms_bodies(scene))


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
