"""Blocks of steps on a GPU of a domain with supports, springs, or contact by penalty or impulses: no static solve."""

from __future__ import annotations

import numpy as np

from ...cells.device_force import DeviceForce
from ...contact.bundles import rigid_bundle, solve_bundles, support_bundle
from ...contact.term import ContactTerm
from ...device import arrays
from ...kernels.lanes import BLOCK_THREADS
from ...nodes.boundary_nodes import BoundaryNodes, Supports
from ...nodes.rigid_bodies import RigidBodies
from ...planning.domain import Domain
from .device_terms import DeviceTermSteps, Shared


class DeviceBoundarySteps(DeviceTermSteps):
    """Steps in blocks as `DeviceSteps`, of a domain whose boundary nodes one block of threads takes, with their mass.

    contact: None where the boundary nodes have no contact.
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
        shared: Shared | None = None,
    ) -> None:
        from ...kernels.language.bundles import ContactOptions, Launch
        from ...kernels.language.signatures import arguments, signature_of
        from ...kernels.step.device_contact import make_device_contact_step

        super().__init__(domain, groups, force, u, v, boundary, contact, shared)
        own, terms = self._own, self._term_bundles(boundary, contact)
        options = (ContactOptions() if contact is None else contact.options)._replace(threads=BLOCK_THREADS)
        if self.layers is not None:
            options = options._replace(layers=self.layers.options)
        step = {
            "body": force.device_bundle()._replace(u=u, v=v, node_info=force.info, special_force=force.special_force),
            "lists": force.lists._replace(control=own["control"]),
            "boundary": terms["boundary"],
            "supports": support_bundle(supports, own["sums"]),
            **terms,
            **solve_bundles(None),
            "rigid": rigid_bundle(rigid, own["sums"]),
            "launch": Launch(),
        }
        has = True, supports is not None, bool(domain.driven), bool(domain.springs)
        parts = domain.kinds, signature_of(step), force.threads, options, *has
        options_of = domain.options | {"loaded": self.loads.name}
        made = make_device_contact_step
        self._steps = self._launches(lambda stages: made(*parts, **options_of, stages=stages))
        self._bundles, self._parts = (step,), (arguments(step),)
        self._keep_terms(contact, rigid)

    def take(self, kicks: tuple[float, float, float], steps: tuple[float, float], rows: int) -> np.ndarray:
        self._begin_pairs()
        offer, taken, built = 0, 0, self.rows_built
        while taken < rows and self.rows_built == built:
            for _ in range(rows - taken):
                self._launch_step(offer, kicks, steps)
                offer += 1
            control = self._read()
            self.count_steps(control)
            taken = int(control[self.names.TAKEN])  # fewer where friction layers took two layer steps in one
            if control[self.names.WANTS] == self.names.A_ROWS:
                self.build_rows()
                control[self.names.WANTS] = self.names.NOTHING
                arrays.set_values(self._own["control"], control)
        return np.concatenate([self.force.ledger_rows(taken), self._rows_of(control, taken)[:, : self.width]], axis=1)

    def _read(self) -> np.ndarray:
        """Return what the device does next, and the sums of the boundary nodes of the rows of a block."""
        return np.array(arrays.get(self._own["control"]))
