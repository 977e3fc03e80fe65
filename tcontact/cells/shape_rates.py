"""Shape rates of the bodies of a domain: how the present shape of their cells changes their stable step."""

from __future__ import annotations

import numpy as np

from ..device import arrays
from ..device.launch import Prepared
from ..planning.domain import Domain
from ..planning.domain_packs import material_places
from .device_force import DeviceForce
from .internal_force import InternalForce


class ShapeRates:
    """The kernel of kernels/cells/shape_rate.py for one domain.

    u: its displacement; before: an array of that size for the displacement at the last look.
    """

    def __init__(self, domain: Domain, force: InternalForce, u: arrays.Array, before: arrays.Array) -> None:
        from ..kernels.cells.device_shape_rate import make_device_shape_rates
        from ..kernels.cells.shape_rate import Shape, make_shape_rates
        from ..kernels.language.bundles import Body
        from ..kernels.language.signatures import arguments, signature_of

        blocks = domain.blocks
        owners = [domain.bodies.index(block.body) for block in blocks]
        self._bodies, self._owner = len(domain.bodies), np.array(owners)
        self._squared = np.array([block.material.wave_speed**2 for block in blocks])
        places = np.array(material_places(domain))  # of laws with other numbers of constants, and behind viscosities
        self._own, span = places - places[0], int(places[-1] - places[0]) + 1
        self._numbers = int(places[0]), 1, span
        self.u, self.before = u, before
        on_device = isinstance(force, DeviceForce)
        self._scratch = arrays.zeros(1 + 2 * span * (1 if on_device else force.packs.all_chunks))
        body = Body(
            u=self.u,
            v=self.before,
            connectivity=force.connectivity,
            chunk_table=force.table,
            segments=force.segments,
            position=force.reference,
            params=force.parameters,
        )
        shape = Shape(self._scratch)
        if isinstance(force, DeviceForce):
            unused = dict.fromkeys(("chunk_table", "segments"))
            bundles = {"body": body._replace(**unused), "lists": force.lists, "shape": shape}
            made = make_device_shape_rates(domain.kinds, signature_of(bundles), force.threads)
        else:
            bundles = {"body": body, "shape": shape}
            made = make_shape_rates(domain.kinds, signature_of(bundles))
        self._arrays, self._launch = arguments(bundles), Prepared(made)

    def measure(self, ahead: float) -> np.ndarray:
        """Return the largest squared rate [2, bodies] [1/s^2] of every body, now and foreseen; 0 in linear bodies.

        ahead: the motion since the last look goes on by this multiple of itself.
        """
        values = np.zeros(self._scratch.shape[0])
        values[0] = ahead
        arrays.set_values(self._scratch, values)
        self._launch(*self._numbers, *self._arrays)
        by_block = arrays.get(self._scratch)[1:].reshape(-1, self._numbers[2], 2).max(axis=0)[self._own]
        found = np.zeros((2, self._bodies))
        for row, values in zip(found, (by_block * self._squared[:, None]).T, strict=True):
            np.maximum.at(row, self._owner, values)
        return found

    def remember(self) -> None:
        """Remember the present displacement for the next look."""
        arrays.copy(self.u, self.before)
