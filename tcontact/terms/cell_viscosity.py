"""Viscosity of the contact cells: its arrays, and its force for any small step of the body (METHOD 3)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .. import arrays
from ..launch import Prepared
from ..mesh_geometry import shortest_heights
from ..packing import OwnRows
from ..plan import BodyPlan
from .internal_force import InternalForce

if TYPE_CHECKING:
    from collections.abc import Callable


class CellViscosity:
    """sigma_v = eta (lambda tr D I + 2 mu D) in the contact cells of a body, eta = beta h/c.

    h: shortest height times `Element.spacing`, so that a hex cut into other cells keeps its eta.

    data: as in kernels/cell_viscosity.py; what it holds of a row goes on to the next one.
    """

    name = "cell-viscosity"

    def __init__(self, plan: BodyPlan, force: InternalForce) -> None:
        from ..kernels import cell_viscosity as names
        from ..kernels.bundles import Launch
        from ..kernels.signatures import signature_of

        contact, surface, material = plan.contact, force.surface, plan.body.material
        assert contact is not None
        assert contact.graph is not None
        assert surface is not None
        self.names, self.plan, self.internal_force = names, plan, force
        cells = plan.cells[contact.graph.cells]
        count, corners = cells.shape
        nodes, lanes = len(plan.boundary), -(-count // surface.width) * surface.width
        numbers = np.zeros(names.NUMBERS)
        numbers[[names.LAMBDA, names.MU]] = material.lame_lambda, material.lame_mu
        numbers[[names.NODES, names.LANES, names.FIRST_ROW]] = nodes, lanes, surface.first_row
        eta = np.zeros(lanes)
        heights = shortest_heights(plan.body.mesh.kind, plan.reference[cells])
        eta[:count] = contact.viscosity * plan.body.mesh.element.spacing * heights / material.wave_speed
        self.data = arrays.put(np.concatenate([numbers, np.zeros(6 * nodes), eta, np.zeros(3 * lanes * corners)]))
        self._before = slice(names.NUMBERS, names.NUMBERS + 3 * nodes)
        self._rows = slice(names.NUMBERS + 6 * nodes + lanes, None)
        cell, corner = np.divmod(np.arange(cells.size), corners)
        self._nodes, self._places = cells.reshape(-1), surface.rows(cell, corner) - surface.first_row
        self.launch: Callable[..., None] | None = None
        if not plan.few_contact_cells:
            signature = signature_of({"body": force.bundle(), "launch": Launch(viscous_cells=self.data)})
            self.launch = Prepared(names.make_viscous_pass(plan.variant, material.law, surface.width, signature))

    def set_rate(self, rate: float) -> None:
        """1/dt [1/s] of the strain rates of the next pass."""
        numbers = arrays.get(self.data)[: self.names.NUMBERS].copy()
        numbers[self.names.RATE] = rate
        arrays.set_values(self.data, numbers)

    def measure(self, u: arrays.Array, v: arrays.Array) -> None:
        """Corner forces at u [3n] of the step since the last row, in a pass of its own: where the cells are many."""
        assert self.launch is not None
        self.launch(*self.internal_force.arguments(u, v), self.data)

    def product(self, u: np.ndarray, step: np.ndarray, measure: Callable[[arrays.Array], None]) -> np.ndarray:
        """Viscous force [3n] of a small step [3n] to u [3n] times its length in time; measure: does the pass at u.

        It may be taken between the steps of a run, whose data are as they were afterwards.
        """
        kept = arrays.get(self.data).copy()
        data = kept.copy()
        data[self._before] = (u - step).reshape(-1, 3)[self.plan.boundary].reshape(-1)
        data[self.names.RATE] = 1.0
        arrays.set_values(self.data, data)
        measure(arrays.put(u))
        rows = arrays.get(self.data)[self._rows].reshape(-1, 3)[self._places]
        total = np.stack(
            [np.bincount(self._nodes, rows[:, axis], len(self.plan.reference)) for axis in range(3)], axis=1
        )
        arrays.set_values(self.data, kept)
        return total.reshape(-1)

    def owned(self) -> list[arrays.Array]:
        """Arrays of this term."""
        return [self.data]


def corner_lists(plan: BodyPlan, surface: OwnRows) -> tuple[np.ndarray, np.ndarray]:
    """List the force rows of the corners in contact cells by boundary node: where each begins [s+1], and the rows.

    The corners of images belong to their masters.
    """
    assert plan.contact is not None
    assert plan.contact.graph is not None
    cells = plan.cells[plan.contact.graph.cells]
    row = np.full(len(plan.reference), -1)
    row[plan.boundary] = np.arange(len(plan.boundary))
    named = row[cells if plan.images is None else plan.images.master[cells]].reshape(-1)
    order = np.argsort(named, kind="stable")
    cell, corner = np.divmod(order, cells.shape[1])
    return np.searchsorted(named[order], np.arange(len(plan.boundary) + 1)), surface.rows(cell, corner)
