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

        packs = force.packs
        self.names, self.domain, self.internal_force = names, domain, force
        nodes, cells = len(domain.boundary), _viscosities(domain)
        starts, tail = self._lanes([len(eta) for eta in cells])
        lanes = np.zeros(packs.lanes - packs.first_contact_lane)
        for start, eta in zip(starts, cells, strict=True):
            lanes[start : start + len(eta)] = eta
        numbers = np.zeros(names.NUMBERS)
        numbers[[names.NODES, names.LANES, names.CORNERS]] = nodes, len(lanes), packs.corner_rows
        numbers[[names.FIRST_LANE, names.FIRST_ROW]] = packs.first_contact_lane, self.first_place()
        rows = np.zeros(3 * packs.corner_rows)
        with arrays.standing_in(None):  # other launches take it as it is
            self.data = arrays.put(np.concatenate([numbers, np.zeros(6 * nodes), lanes, rows, *cells, tail]))
        self._before = slice(names.NUMBERS, names.NUMBERS + 3 * nodes)
        start = names.NUMBERS + 6 * nodes + len(lanes)
        self._rows = slice(start, start + len(rows))
        self._nodes = np.concatenate([block.contact_cells.reshape(-1) for block in domain.blocks])
        self._places = self._force_places(packs.corners - packs.first_corner_row)
        self.launch: Callable[..., None] | None = self._pass()

    def _lanes(self, counts: list[int]) -> tuple[list[int], np.ndarray]:
        """Return the first lane of the contact cells of every block, and the numbers behind all others."""
        padded = [-(-count // WIDTH) * WIDTH for count in counts]
        return [sum(padded[:number]) for number in range(len(counts))], np.zeros(0)

    def first_place(self) -> int:
        """Return the first of the places that the kernels know corners by."""
        return self.internal_force.packs.first_corner_row

    def _force_places(self, corners: np.ndarray) -> np.ndarray:
        """Return where the force [corners, 3] of the corners stands among the corner forces."""
        return 3 * corners[:, None] + np.arange(3)

    def _pass(self) -> Callable[..., None] | None:
        """Return the launch over many contact cells; None where another kernel takes them."""
        from ..kernels.language.bundles import Launch
        from ..kernels.language.signatures import signature_of

        if self.domain.few_contact_cells:
            return None
        signature = signature_of({"body": self.internal_force.bundle(), "launch": Launch(viscous_cells=self.data)})
        return Prepared(self.names.make_viscous_pass(self.domain.kinds, signature))

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
        rows = arrays.get(self.data)[self._rows][self._places]
        total = np.stack(
            [np.bincount(self._nodes, rows[:, axis], len(self.domain.reference)) for axis in range(3)], axis=1
        )
        arrays.set_values(self.data, kept)
        return total.reshape(-1)

    def owned(self) -> list[arrays.Array]:
        """Return the arrays of this term."""
        return [self.data]


def _viscosities(domain: Domain) -> list[np.ndarray]:
    """Return eta [s] of the contact cells of every block."""
    found = []
    for block in domain.blocks:
        contact, element = block.body.contact, block.facts
        eta = np.zeros(len(block.contact))
        if len(eta):
            assert contact is not None
            heights = shortest_heights(element.kind, domain.reference, block.contact_cells)
            eta = contact.viscosity * element.spacing * heights / block.material.wave_speed
        found.append(eta)
    return found
