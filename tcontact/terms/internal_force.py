"""Internal force of the cells, with kick and drift of the ordinary nodes in the same pass (METHOD 2)."""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from typing import TYPE_CHECKING

import numpy as np

from .. import arrays
from ..kernels.lanes import CELL_SUMS, LAW_PARAMETERS, NODE_SUMS, VISCOUS_HELD, VISCOUS_START, VISCOUS_SUMS
from ..launch import Prepared
from ..packing import CHUNKS, WIDTH, CellPacks, OwnRows, append_own_rows, pack_cells
from ..plan import BodyPlan

if TYPE_CHECKING:
    from ..kernels.bundles import Body
    from ..kernels.materials.law import Law

CHUNK_BITS = 0xFF  # of node_info; the rest names the special node


class InternalForce:
    """Force pass over the cells of a body; its boundary nodes hand out their force instead of being moved.

    Massless contact cells are listed once more with corner rows of their own (`surface`): one kernel serves both.
    """

    name = "internal-force"

    def __init__(self, plan: BodyPlan) -> None:
        from ..kernels.internal_force import make_step
        from ..kernels.materials import LAWS
        from ..kernels.signatures import signature_of

        kind, material = plan.variant, plan.body.material
        packs = pack_cells(plan.cells, len(plan.reference), WIDTH)
        self.surface: OwnRows | None = None
        if plan.contact is not None and plan.contact.graph is not None:
            self.surface = append_own_rows(packs, plan.cells[plan.contact.graph.cells])
            packs = self.surface.packs
        self.gravity = plan.gravity
        law_parameters = np.zeros(LAW_PARAMETERS)
        law_parameters[: len(material.parameters)] = material.parameters
        self.connectivity = arrays.put(packs.connectivity)
        self.chunks = arrays.put(packs.chunk_table)
        self.info = arrays.put(packs.with_special(plan.boundary))
        self.reference = arrays.put(plan.reference)
        self.mass = arrays.put(plan.lumped)
        self.rows = arrays.zeros(3 * packs.row_count)
        self.special_force = arrays.zeros(3 * len(plan.boundary))
        self.node_sums = arrays.zeros(CHUNKS * NODE_SUMS)
        self.cell_sums = arrays.zeros(VISCOUS_START)
        self.viscous = plan.viscosity is not None
        if self.viscous:
            self.cell_sums = arrays.zeros(VISCOUS_HELD + packs.connectivity.size // packs.corners)
        self.memory, self.memory_start = self._memory(LAWS[material.law], plan, packs)
        self.constants = (*law_parameters, *plan.constants)
        self.parameters = arrays.put(np.array([0.0] * 6 + [*self.constants]))
        self.step = make_step(kind, material.law, signature_of({"body": self.bundle()}), **plan.options)
        self.kernel: Callable[..., None] = Prepared(self.step)
        self._measure = Prepared(self.step)

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
        self.kernel(0, CHUNKS, CHUNKS, *self._commit(loaded), *self.arguments(u, v))

    def measure_surface(self, u: arrays.Array, v: arrays.Array) -> None:
        """Corner forces dW/du of the massless contact cells at u, into their own rows; nothing moves."""
        self._measure(CHUNKS, 2 * CHUNKS, 0, *self._commit(False), *self.arguments(u, v))

    def _memory(self, law: Law, plan: BodyPlan, packs: CellPacks) -> tuple[arrays.Array | None, arrays.Array | None]:
        """What the points of a law with state keep, 0 at the start, and where that of every lane begins; else None."""
        if not law.state:
            return None, None
        from ..kernels.elements import FUNCTIONS

        width, numbers = packs.width, len(law.state) * FUNCTIONS[plan.variant].points
        cells = np.arange(packs.pack_count * width)
        places = cells // width * (width * numbers) + cells % width
        if self.surface is not None:
            assert plan.contact is not None
            assert plan.contact.graph is not None
            again = plan.contact.graph.cells
            places = np.concatenate([places, places[np.pad(again, (0, -len(again) % width), mode="edge")]])
        return arrays.zeros(len(cells) * numbers), arrays.put(places.astype(np.int32))

    def _commit(self, commits: bool) -> tuple[int, ...]:
        """Whether the points keep what their state becomes; no argument for a law without state."""
        return () if self.memory is None else (int(commits),)

    def set_steps(self, kick_before: float, kick_after: float, drift: float, *, loaded: bool = True) -> None:
        """The parameters of the next pass."""
        gravity = self.gravity if loaded else np.zeros(3)
        arrays.set_values(self.parameters, np.array([kick_before, kick_after, drift, *gravity, *self.constants]))

    def arguments(self, u: arrays.Array, v: arrays.Array) -> tuple[arrays.Array, ...]:
        """The arrays of the pass, as in kernels/bundles.Body."""
        return (u, v, *self._arrays())

    def _arrays(self) -> tuple[arrays.Array, ...]:
        first = (self.connectivity, self.chunks, self.info, self.reference, self.mass, self.parameters)
        sums = (self.rows, self.special_force, self.node_sums, self.cell_sums)
        return (*first, *sums) if self.memory is None else (*first, *sums, self.memory, self.memory_start)

    def bundle(self) -> Body:
        """The arrays under their names, without a state."""
        from ..kernels.bundles import Body

        return Body(*[self.reference] * 2, *self._arrays())

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
        """Sums of the last pass [13]: ordinary nodes (10), elastic energy [J], smallest det F, hourglass energy [J]."""
        nodes = arrays.get(self.node_sums).reshape(CHUNKS, NODE_SUMS)
        cells = arrays.get(self.cell_sums)[: CHUNKS * CELL_SUMS].reshape(CHUNKS, CELL_SUMS)
        return np.array([*nodes.sum(axis=0), cells[:, 0].sum(), cells[:, 1].min(), cells[:, 2].sum()])

    def viscous_sums(self) -> np.ndarray:
        """With bulk viscosity: power dissipated in the step to the last pass [W], largest rate of a cell [1/s]."""
        chunks = arrays.get(self.cell_sums)[VISCOUS_START:VISCOUS_HELD].reshape(-1, VISCOUS_SUMS)[:CHUNKS]
        return np.array([chunks[:, 0].sum(), chunks[:, 1].max()])

    def owned(self) -> list[arrays.Array]:
        """Arrays of this term."""
        shared = [self.connectivity, self.chunks, self.info, self.reference, self.mass, self.rows]
        shared += [] if self.memory is None else [self.memory, self.memory_start]
        return [*shared, self.cell_sums] if self.viscous else shared
