"""Internal force of the cells, with kick and drift of the ordinary nodes in the same pass (METHOD 2)."""

from __future__ import annotations

from copy import copy

import numpy as np

from .. import arrays
from ..launch import Prepared
from ..packing import CHUNKS, WIDTHS, pack_cells
from ..plan import BodyPlan

CHUNK_BITS = 0xFF  # of node_info; the rest names the special node
CELL_SUMS = 3  # elastic energy, smallest det F, hourglass energy
NODE_SUMS = 10  # kinetic, momentum (3), angular momentum (3), mass-weighted displacement (3)


class InternalForce:
    """Force pass over a set of cells; nodes listed as special hand out their force instead of being moved.

    `cells` [m, corners] with `reference` [n, 3] and `mass` [n] may be the body itself or, for the static solve, its
    contact cells with corners of their own: one compiled kernel serves both.
    """

    name = "internal-force"

    def __init__(
        self, plan: BodyPlan, cells: np.ndarray, reference: np.ndarray, mass: np.ndarray, special: np.ndarray
    ) -> None:
        from ..kernels.internal_force import make_step

        kind, material = plan.element, plan.body.material
        packs = pack_cells(cells, len(reference), WIDTHS[kind])
        self.step = make_step(kind, material.law)
        self.kernel = Prepared(self.step)
        self.gravity = plan.gravity
        self.lame = (material.lame_lambda, material.lame_mu)
        self.connectivity = arrays.put(packs.connectivity)
        self.cell_count = packs.cell_count
        self.chunks = arrays.put(packs.chunk_table)
        self.info = arrays.put(packs.with_special(special))
        self.reference = arrays.put(reference)
        self.mass = arrays.put(mass)
        self.rows = arrays.zeros(3 * packs.row_count)
        self.special_force = arrays.zeros(3 * len(special))
        self.node_sums = arrays.zeros(CHUNKS * NODE_SUMS)
        self.cell_sums = arrays.zeros(CHUNKS * CELL_SUMS)
        self.parameters = arrays.zeros(8)

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
        gravity = self.gravity if loaded else np.zeros(3)
        arrays.set_values(self.parameters, np.array([kick_before, kick_after, drift, *gravity, *self.lame]))
        self.kernel(
            self.connectivity,
            self.cell_count,
            self.chunks,
            self.info,
            self.reference,
            self.mass,
            self.parameters,
            u,
            v,
            self.rows,
            self.special_force,
            self.node_sums,
            self.cell_sums,
        )

    def without_special(self) -> InternalForce:
        """The same pass over the same arrays, with every node an ordinary one: for products with the whole body."""
        other = copy(self)
        other.info = arrays.put(arrays.get(self.info) & CHUNK_BITS)
        other.kernel = Prepared(self.step)
        return other

    def minus_force(self, u: arrays.Array, out: arrays.Array) -> None:
        """out += -f(u) / mass at ordinary nodes; u stays as it is."""
        self.advance(u, out, 0.0, 1.0, 0.0, loaded=False)

    def sums(self) -> tuple[np.ndarray, float, float, float]:
        """Sums over ordinary nodes [10], elastic energy [J], smallest det F, hourglass energy [J] of the last pass."""
        nodes = arrays.get(self.node_sums).reshape(CHUNKS, NODE_SUMS)
        cells = arrays.get(self.cell_sums).reshape(CHUNKS, CELL_SUMS)
        return nodes.sum(axis=0), float(cells[:, 0].sum()), float(cells[:, 1].min()), float(cells[:, 2].sum())

    def owned(self) -> list[arrays.Array]:
        """Arrays of this term."""
        return [self.connectivity, self.chunks, self.info, self.reference, self.mass, self.rows]
