"""Blocks of steps on a GPU of a domain with supports, springs, or contact by penalty or impulses: no static solve."""

from __future__ import annotations

import numpy as np

from ...cells.device_force import DeviceForce
from ...contact.device_layers import DeviceLayers
from ...contact.layered_friction import LayeredFriction
from ...contact.term import ContactTerm
from ...device import arrays
from ...kernels.columns import group_size
from ...kernels.lanes import BLOCK_THREADS, DEVICE_ROWS
from ...nodes.boundary_nodes import BoundaryNodes, Supports
from ...nodes.rigid_bodies import RigidBodies
from ...planning.device_blocks import scratch
from ...planning.domain import Domain
from .device_loads import DeviceLoads
from .device_pairs import pair_arguments
from .device_step import LAYERS, DeviceSteps


class DeviceBoundarySteps(DeviceSteps):
    """Steps in blocks as `DeviceSteps`, of a domain whose boundary nodes one block of threads takes, with their mass.

    contact: None where the boundary nodes have no contact; groups: of the columns in its raw rows.
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
        supports: Supports | None,
        rigid: RigidBodies | None = None,
    ) -> None:
        from ...kernels.language.bundles import Boundary, Contact, ContactOptions, Launch, Obstacles, Rigid, Rows
        from ...kernels.language.bundles import Supports as SupportArrays
        from ...kernels.language.signatures import arguments, signature_of
        from ...kernels.language.solve_bundles import Pairs, System
        from ...kernels.step import device_contact, device_control

        super().__init__(force, u, v)
        self.names = device_control
        self.width = group_size(*groups[groups.index("boundary") :])
        pairs = None if contact is None else contact.pairs
        layered = contact is not None and isinstance(contact.friction, LayeredFriction)
        self._row_width = self.width + layered * LAYERS
        own = self._own = {
            "sums": arrays.zeros(self.width),
            "shared": arrays.zeros(scratch(1)),
            "control": arrays.zeros(device_control.DEVICE_CONTROL + DEVICE_ROWS * self._row_width),
        }
        options = (ContactOptions() if contact is None else contact.options)._replace(threads=BLOCK_THREADS)
        if contact is not None and isinstance(contact.friction, LayeredFriction):
            self.layers = DeviceLayers(contact.friction, contact, own["control"])
            options = options._replace(layers=self.layers.options)
            self._keep(self.layers.kept())
        shared = {"sums": own["sums"], "shared": own["shared"], **self.layer_arguments()}
        loads = self.loads = DeviceLoads(domain, force, u, boundary)
        step = {
            "body": force.device_bundle()._replace(u=u, v=v, node_info=force.info, special_force=force.special_force),
            "lists": force.lists._replace(control=own["control"]),
            "boundary": Boundary(**boundary.arguments(), **loads.arguments(), sums=own["sums"]),
            "supports": SupportArrays()
            if supports is None
            else SupportArrays(**supports.arguments(), sums=own["sums"]),
            "obstacles": Obstacles() if contact is None else Obstacles(**contact.obstacle_arguments()),
            "rows": Rows() if contact is None else Rows(**contact.row_arguments()),
            "contact": Contact(**({} if contact is None else contact.arguments()), **shared, **pair_arguments(pairs)),
            "pairs": Pairs(),
            "system": System(),
            "rigid": Rigid() if rigid is None else Rigid(**rigid.arguments(), sums=own["sums"]),
            "launch": Launch(),
        }
        made = device_contact.make_device_contact_step
        has = True, supports is not None, bool(domain.driven), bool(domain.springs)
        signature = signature_of(step)
        parts = domain.kinds, signature, force.threads, options, *has
        options_of = domain.options | {"loaded": loads.name}
        self._steps = self.parts_of_step(lambda part: made(*parts, **options_of, part=part))
        self._bundles = (step,)
        self._parts = (arguments(step),)
        self.watch_pairs(pairs, u)
        if loads.name:
            self._keep(loads.kept)
        if rigid is not None and contact is not None:
            self.watch(groups)
            self._keep([rigid.values, *([] if contact.obstacles.posed else [contact.obstacles.records])])
        if contact is not None:
            self._keep([contact.candidates, *([contact.obstacles.records] if contact.obstacles.posed else [])])
            if contact.friction is not None:
                assert contact.rows is not None
                self._keep([contact.rows.values, contact.friction.data])

    def _take(self, kicks: tuple[float, float, float], steps: tuple[float, float], rows: int) -> np.ndarray:
        commit = int(self.force.memory is not None)
        numbers = [float(number) for number in (steps[0], *kicks, *self.force.gravity, steps[1])]
        self.begin_pairs()
        offer, taken, built = 0, 0, self.rows_built
        while taken < rows and self.rows_built == built:
            for _ in range(rows - taken):
                self.launch_step(offer, commit, numbers, self._parts[0])
                offer += 1
            control = self._read()
            taken = int(control[self.names.TAKEN])  # fewer where friction layers took two layer steps in one
            if control[self.names.WANTS] == self.names.A_ROWS:
                self.build_rows()
                control[self.names.WANTS] = self.names.NOTHING
                arrays.set_values(self._own["control"], control)
        boundary = control[self.names.DEVICE_CONTROL :].reshape(-1, self._row_width)[:taken]
        self.note_layers(boundary)
        return np.concatenate([self.force.ledger_rows(taken), boundary[:, : self.width]], axis=1)

    def _read(self) -> np.ndarray:
        """Return what the device does next, and the sums of the boundary nodes of the rows of a block."""
        return np.array(arrays.get(self._own["control"]))

    def owned(self) -> list[arrays.Array]:
        """Return the arrays of the steps beside those of their terms."""
        layers = [] if self.layers is None else self.layers.owned()
        return [*super().owned(), *self._own.values(), *self.loads.owned(), *layers]
