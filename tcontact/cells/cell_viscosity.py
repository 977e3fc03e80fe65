"""Viscosity of the contact cells: its arrays, and its force for a small step of the body (METHOD 3)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..device import arrays
from ..device.launch import Prepared
from ..mesh.geometry import shortest_heights
from ..planning.domain import Domain
from ..planning.packing import WIDTH
from .internal_force import InternalForce

if TYPE_CHECKING:
    from collections.abc import Callable


class CellViscosity:
    """Viscous stress sigma_v = eta (lambda tr D I + 2 mu D) in the contact cells, eta = beta h/c.

    h: shortest height times `Element.spacing`, so that a hex cut into other cells keeps its eta; data: numbers
    placed as in kernels/contact/cell_viscosity.py, kept from row to row.
    """

    name = "cell-viscosity"

    def __init__(self, domain: Domain, force: InternalForce) -> None:
        from ..kernels.contact import cell_viscosity as names
        from ..kernels.language.bundles import Launch
        from ..kernels.language.signatures import signature_of

        packs = force.packs
        self.names, self.domain, self.internal_force = names, domain, force
        nodes, first_lane = len(domain.boundary), packs.first_contact_lane
        lanes = np.zeros(packs.lanes - first_lane)
        cells, count = [np.zeros(0)], 0
        for block in domain.blocks:
            contact, element, width = block.body.contact, block.facts, WIDTH
            if len(block.contact):
                assert contact is not None
                corners = block.contact_cells
                eta = contact.viscosity * element.spacing * shortest_heights(element.kind, domain.reference, corners)
                eta /= block.material.wave_speed
                lanes[count : count + len(eta)] = eta
                count += -(-len(eta) // width) * width
                cells.append(eta)
        numbers = np.zeros(names.NUMBERS)
        numbers[[names.NODES, names.LANES, names.CORNERS]] = nodes, len(lanes), packs.row_count - packs.first_corner_row
        numbers[[names.FIRST_LANE, names.FIRST_ROW]] = first_lane, packs.first_corner_row
        rows = np.zeros(3 * (packs.row_count - packs.first_corner_row))
        self.data = arrays.put(np.concatenate([numbers, np.zeros(6 * nodes), lanes, rows, *cells]))
        self._before = slice(names.NUMBERS, names.NUMBERS + 3 * nodes)
        start = names.NUMBERS + 6 * nodes + len(lanes)
        self._rows = slice(start, start + len(rows))
        corner_nodes = [block.contact_cells.reshape(-1) for block in domain.blocks]
        self._nodes, self._places = np.concatenate(corner_nodes), packs.corners - packs.first_corner_row
        self.launch: Callable[..., None] | None = None
        if not domain.few_contact_cells:
            signature = signature_of({"body": force.bundle(), "launch": Launch(viscous_cells=self.data)})
            self.launch = Prepared(names.make_viscous_pass(domain.kinds, signature))

    def set_rate(self, rate: float) -> None:
        """Set the factor 1/dt [1/s] of the strain rates of the next pass."""
        numbers = arrays.get(self.data)[: self.names.NUMBERS].copy()
        numbers[self.names.RATE] = rate
        arrays.set_values(self.data, numbers)

    def measure(self, u: arrays.Array, v: arrays.Array) -> None:
        """Compute the corner forces at u [3n] of the step since the last row, in a pass of their own."""
        assert self.launch is not None
        self.launch(*self.internal_force.arguments(u, v), self.data)

    def product(self, u: np.ndarray, step: np.ndarray, measure: Callable[[arrays.Array], None]) -> np.ndarray:
        """Return the viscous force [3n] of a small step [3n] to u [3n] times its duration; measure: does the pass at u.

        The data of a run are restored afterwards.
        """
        kept = arrays.get(self.data).copy()
        data = kept.copy()
        data[self._before] = (u - step).reshape(-1, 3)[self.domain.boundary].reshape(-1)
        data[self.names.RATE] = 1.0
        arrays.set_values(self.data, data)
        measure(arrays.put(u))
        rows = arrays.get(self.data)[self._rows].reshape(-1, 3)[self._places]
        total = np.stack(
            [np.bincount(self._nodes, rows[:, axis], len(self.domain.reference)) for axis in range(3)], axis=1
        )
        arrays.set_values(self.data, kept)
        return total.reshape(-1)

    def owned(self) -> list[arrays.Array]:
        """Return the arrays of this term."""
        return [self.data]
