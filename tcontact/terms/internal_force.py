"""Internal force of the cells, with kick and drift of the ordinary nodes in the same pass (METHOD 2)."""

from __future__ import annotations

from collections.abc import Callable
from copy import copy

import numpy as np

from .. import arrays
from ..kernels.columns import NODE_SUMS, cell_groups, group_columns, group_size, raw_places
from ..kernels.lanes import MODULI
from ..launch import Prepared
from ..measured import COMBINE
from ..packing import CHUNKS, WIDTHS, OwnRows, append_own_rows, pack_cells
from ..plan import BodyPlan

CHUNK_BITS = 0xFF  # of node_info; the rest names the special node


class InternalForce:
    """Force pass over the cells of a body; its boundary nodes hand out their force instead of being moved.

    Massless contact cells are listed once more with corner rows of their own (`surface`): one kernel serves both.
    """

    name = "internal-force"

    def __init__(self, plan: BodyPlan) -> None:
        from ..kernels.internal_force import make_step

        kind, material = plan.variant, plan.body.material
        packs = pack_cells(plan.cells, len(plan.reference), WIDTHS[kind])
        self.surface: OwnRows | None = None
        if plan.contact is not None and plan.contact.graph is not None:
            self.surface = append_own_rows(packs, plan.cells[plan.contact.graph.cells])
            packs = self.surface.packs
        self.step = make_step(kind, material.law, **plan.options)
        self.kernel: Callable[..., None] = Prepared(self.step)
        self._measure = Prepared(self.step)
        self.gravity = plan.gravity
        self.moduli = (*material.moduli, *[0.0] * (MODULI - len(material.moduli)))
        self.connectivity = arrays.put(packs.connectivity)
        self.chunks = arrays.put(packs.chunk_table)
        self.info = arrays.put(packs.with_special(plan.boundary))
        self.reference = arrays.put(plan.reference)
        self.mass = arrays.put(plan.lumped)
        self.rows = arrays.zeros(3 * packs.row_count)
        self.special_force = arrays.zeros(3 * len(plan.boundary))
        self.node_sums = arrays.zeros(CHUNKS * NODE_SUMS)
        self.viscous = plan.viscosity is not None
        held = packs.connectivity.size // packs.corners if self.viscous else 0
        self.cell_sums = arrays.zeros(2 * CHUNKS * group_size(*cell_groups(self.viscous)) + held)
        self.constants = (*self.moduli, *plan.constants)
        self.parameters = arrays.put(np.array([0.0] * 6 + [*self.constants]))

    def advance(
        self,
        u: arrays.Array,
        v: arrays.Array,
        kick_before: float,
        kick_after: float,
        drift: float,
        *,
        loaded: bool = True,
    ) -> None:
        """One pass at the present u: v^n = v + kick_before a, v = v^n + kick_after a, u += drift v; sums at level n."""
        self.set_steps(kick_before, kick_after, drift, loaded=loaded)
        self.kernel(0, CHUNKS, CHUNKS, *self.arguments(u, v))

    def measure_surface(self, u: arrays.Array, v: arrays.Array) -> None:
        """Corner forces dW/du of the massless contact cells at u, into their own rows; nothing moves."""
        self._measure(CHUNKS, 2 * CHUNKS, 0, *self.arguments(u, v))

    def set_steps(self, kick_before: float, kick_after: float, drift: float, *, loaded: bool = True) -> None:
        """The parameters of the next pass."""
        gravity = self.gravity if loaded else np.zeros(3)
        arrays.set_values(self.parameters, np.array([kick_before, kick_after, drift, *gravity, *self.constants]))

    def arguments(self, u: arrays.Array, v: arrays.Array) -> tuple[arrays.Array, ...]:
        """The arrays of the pass, as in kernels/bundles.Body."""
        first = (self.connectivity, self.chunks, self.info, self.reference, self.mass, self.parameters)
        return (*first, u, v, self.rows, self.special_force, self.node_sums, self.cell_sums)

    def without_special(self) -> InternalForce:
        """The same pass over the same arrays, with every node an ordinary one: for products with the whole body."""
        other = copy(self)
        other.info = arrays.put(arrays.get(self.info) & CHUNK_BITS)
        other.parameters = arrays.put(arrays.get(self.parameters))
        if self.viscous:  # products leave the pressures alone
            other.cell_sums = arrays.put(arrays.get(self.cell_sums))
        other.kernel = Prepared(self.kernel.kernel) if isinstance(self.kernel, Prepared) else self.kernel
        return other

    def minus_force(self, u: arrays.Array, out: arrays.Array) -> None:
        """out += -f(u) / mass at ordinary nodes; u stays as it is."""
        self.advance(u, out, 0.0, 1.0, 0.0, loaded=False)

    def sums(self) -> np.ndarray:
        """Sums of the last pass over all chunks, as a raw row begins: those of ordinary nodes, then those of cells."""
        columns = group_columns(*cell_groups(self.viscous))
        combine = [COMBINE[column.combine] for column in columns for _ in range(column.size)]
        nodes = arrays.get(self.node_sums).reshape(CHUNKS, NODE_SUMS)
        cells = arrays.get(self.cell_sums)[: CHUNKS * len(combine)].reshape(CHUNKS, len(combine))
        return np.array([*nodes.sum(axis=0), *(pick(cells[:, j]) for j, pick in enumerate(combine))])

    def sum_of(self, name: str) -> float:
        """One number of the cells of the last pass, by the name of its column."""
        return float(self.sums()[getattr(raw_places(self.viscous).cells, name)])

    def owned(self) -> list[arrays.Array]:
        """Arrays of this term."""
        shared = [self.connectivity, self.chunks, self.info, self.reference, self.mass, self.rows]
        return [*shared, self.cell_sums] if self.viscous else shared
