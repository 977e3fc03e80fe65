"""Loads other than constant gravity of a domain on a GPU, whose boundary nodes one block of threads takes."""

from __future__ import annotations

import numpy as np

from ...cells.device_force import DeviceForce
from ...device import arrays
from ...device.launch import Prepared
from ...kernels.lanes import BLOCK_THREADS
from ...kernels.load_places import FACES
from ...nodes.boundary_nodes import BoundaryNodes
from ...planning.device_lists import load_sources
from ...planning.domain import Domain


class DeviceLoads:
    """Lists with which threads apply the loads (kernels/nodes/shared_loads.py), and the launch for those of t = 0.

    name: of the loads for the kernels, "" without any.
    """

    def __init__(self, domain: Domain, force: DeviceForce, u: arrays.Array, boundary: BoundaryNodes) -> None:
        from ...kernels.language.bundles import Boundary, Contact, ContactOptions
        from ...kernels.language.signatures import arguments, signature_of
        from ...kernels.step.device_loads import make_device_loads

        self.name = ("gravity" if domain.pulled else "loads") if domain.loaded else ""
        self.force, self._lists = force, dict[str, arrays.Array]()
        if not self.name:
            return
        data = np.array(arrays.get(boundary.load)[3 * len(domain.boundary) :])
        faces = max(1, int(data[FACES]))
        self._lists = {"load_sources": arrays.put(load_sources(data)), "load_shares": arrays.zeros(12 * faces)}
        body = force.device_bundle()._replace(u=u)
        parts = {"body": body, "boundary": Boundary(**boundary.arguments(), **self._lists), "contact": Contact()}
        options = ContactOptions(threads=BLOCK_THREADS)
        self._launch = Prepared(make_device_loads(signature_of(parts), options, domain.pulled))
        self._arrays = arguments(parts)
        # what the loads of a level leave behind for the next one
        self.kept = [boundary.load, *([force.parameters] if domain.pulled else [])]

    def start(self) -> None:
        """Apply the loads of t = 0."""
        self._launch(*(float(number) for number in self.force.gravity), *self._arrays)

    def arguments(self) -> dict[str, arrays.Array]:
        """Return the lists by the names of kernels/language/bundles.Boundary."""
        return self._lists

    def owned(self) -> list[arrays.Array]:
        """Return the lists."""
        return list(self._lists.values())
