"""Internal force of the cells, with kick and drift of the ordinary nodes in the same pass (METHOD 2)."""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from typing import TYPE_CHECKING

import numpy as np

from ..device import arrays, runtime
from ..device.launch import Prepared
from ..kernels import lanes
from ..kernels.columns import NODE_SUMS, cell_groups, group_columns, group_size, raw_places
from ..planning.domain import Domain
from ..planning.domain_packs import (
    corner_lists,
    massless_count,
    material_numbers,
    material_places,
    pack_domain,
    positions_and_shapes,
)
from ..planning.measured import COMBINE
from ..planning.node_volumes import volume_arrays
from ..planning.packing import chunks_for

if TYPE_CHECKING:
    from ..kernels.language.bundles import Body


class InternalForce:
    """Force pass over the cells of a domain; it moves ordinary nodes and only sums the force of boundary nodes.

    packs: the packed cells; corner_rows: force rows of the corners of contact cells, by boundary node. chunks: of the
    cells, None = those of the domain.
    """

    name = "internal-force"

    def __init__(self, domain: Domain, chunks: int | None = None) -> None:
        from ..kernels.elements import FUNCTIONS
        from ..kernels.language.signatures import signature_of
        from ..kernels.materials import LAWS
        from ..kernels.step.internal_force import make_step

        kept = {kind: FUNCTIONS[kind[0]].points * len(LAWS[kind[1]].state) for kind in domain.kinds}
        self.packs = packs = pack_domain(domain, chunks or domain.chunks or chunks_for(runtime.threads()), kept)
        self.chunks = packs.chunks
        self.gravity, self.pulled = domain.gravity, domain.pulled  # pulled: the loads set it in every step
        self.connectivity = arrays.share(packs.connectivity)
        self.table = arrays.put(packs.chunk_table)
        self.segments = arrays.put(packs.segments)
        self.info = arrays.share(packs.with_boundary(domain.boundary))
        self.reference = arrays.share(positions_and_shapes(domain, packs))
        self.mass = arrays.share(domain.lumped)
        self.rows = self.force_rows()
        self.special_force = arrays.zeros(3 * len(domain.boundary))
        self.node_sums = arrays.zeros(packs.chunks * NODE_SUMS)
        self.corner_rows = arrays.put(corner_lists(domain, packs)) if len(packs.corners) else None
        self.viscous = domain.viscosity is not None
        held = packs.lanes if self.viscous else 0
        self.plastic = domain.plastic
        self.cell_sums = arrays.zeros(packs.all_chunks * group_size(*cell_groups(self.viscous, self.plastic)) + held)
        damping = [] if domain.damping is None else [*domain.damping.constants]
        damping += [0.0] * (lanes.FREE - lanes.DAMPING - len(damping))
        self.constants = [*damping, 0.0, float(massless_count(domain)), float(packs.all_chunks), 0.0]
        self.material_at = material_places(domain)
        for block in domain.blocks:
            self.constants += material_numbers(domain, block)
        self.parameters = arrays.put(np.array([0.0] * lanes.DAMPING + self.constants))
        self.memory = arrays.zeros(packs.memory) if packs.memory else None  # state of the quadrature points
        volumes = volume_arrays(domain, packs) or (None, None)
        self.volume_lists, self.volumes = (None if part is None else arrays.put(part) for part in volumes)
        laws = [LAWS[block.material.law].plastic for block in domain.blocks]
        self.strengths = [at + law.strength for at, law in zip(self.material_at, laws, strict=True) if law is not None]
        heated = self.viscous and self.plastic  # metals, whose viscosity acts in contact cells and heats the points
        self.timed = self.viscous or any(LAWS[law].rates for _, law in domain.kinds)
        self.resting = 0.0  # the step [s] of a pass that no step ends at
        self.bulk_viscosity = None
        if heated and self.corner_rows is not None:
            self.bulk_viscosity = arrays.zeros(1 + 3 * massless_count(domain) + packs.lanes - packs.first_contact_lane)
            arrays.set_values(self.bulk_viscosity, np.array([float(packs.first_contact_lane)]))
        signature, cornered = signature_of({"body": self.bundle()}), self.corner_rows is not None
        apart = {} if domain.held is None else {"apart": True}
        self.step = make_step(domain.kinds, signature, **domain.options, cornered=cornered, **apart)
        # of the part of a rank: averages volume changes over the cells of all ranks (shared_volumes.ForceVolumes)
        self.average: Callable[[int, tuple[arrays.Array, ...]], None] | None = None
        self._kept = [False]  # whether the contact cells have their forces at the present u; shared with the products
        self.kernel: Callable[..., None] = Prepared(self.step)
        self._measure = Prepared(self.step)

    def force_rows(self) -> arrays.Array:
        """Make the force rows."""
        return arrays.zeros(3 * self.packs.row_count)

    def advance(
        self,
        u: arrays.Array,
        v: arrays.Array,
        kick_before: float,
        kick_after: float,
        drift: float,
        *,
        loaded: bool = True,
        before: float = 0.0,
    ) -> None:
        """Launch a pass at u: v^n = v + kick_before a, sums of level n, v = v^n + kick_after a, u += drift v.

        before [s]: the step that ends at u.
        """
        self.set_steps(kick_before, kick_after, drift, loaded=loaded, before=before)
        end = self.chunks if loaded and self.surface_known else self.packs.all_chunks
        self.surface_known = False
        if self.average is not None:
            self.average(end, self.arguments(u, v))
        self.kernel(0, end, self.chunks, *self._commit(loaded), *self.arguments(u, v))

    @property
    def surface_known(self) -> bool:
        """Whether the corner forces and sums of the contact cells are those of the present u; any pass forgets it."""
        return self._kept[0]

    @surface_known.setter
    def surface_known(self, known: bool) -> None:
        self._kept[0] = known

    def measure_surface(self, u: arrays.Array, v: arrays.Array) -> None:
        """Compute the corner forces dW/du of the contact cells at u into their rows; nothing moves."""
        self._measure(self.chunks, 2 * self.chunks, 0, *self._commit(False), *self.arguments(u, v))

    def _commit(self, commits: bool) -> tuple[int, ...]:
        """Return the argument that commits the new state of the points; empty without laws that have state."""
        return () if self.memory is None else (int(commits),)

    def rest(self) -> None:
        """Let the passes before the first step leave the state of the points as it is: it fits their present strain."""
        if self.timed:
            self.resting = lanes.RESTING
            arrays.set_values(self.parameters, np.array([self.resting]), lanes.STEP)

    def set_steps(
        self, kick_before: float, kick_after: float, drift: float, *, loaded: bool = True, before: float = 0.0
    ) -> None:
        """Set the parameters of the next pass; before [s]: the step that ends at u."""
        if self.timed:
            arrays.set_values(self.parameters, np.array([before or self.resting]), lanes.STEP)
        gravity = self.gravity if loaded else np.zeros(3)
        numbers = np.array([kick_before, kick_after, drift, *gravity])
        arrays.set_values(self.parameters, numbers[:3] if self.pulled and loaded else numbers)

    def arguments(self, u: arrays.Array, v: arrays.Array) -> tuple[arrays.Array, ...]:
        """Return the arrays of the pass in the order of kernels/language/bundles.Body."""
        return (u, v, *self._arrays)

    @property
    def _arrays(self) -> tuple[arrays.Array, ...]:
        cells = [self.connectivity, self.table, self.segments]
        if self.corner_rows is not None:
            cells.append(self.corner_rows)
        nodes = (self.info, self.reference, self.mass, self.parameters)
        sums = (self.rows, self.special_force, self.node_sums, self.cell_sums)
        rest = (self.memory, self.volume_lists, self.volumes, self.bulk_viscosity)
        return (*cells, *nodes, *sums, *(part for part in rest if part is not None))

    def bundle(self) -> Body:
        """Return the arrays by name; the positions take the places of u and v."""
        from ..kernels.language.bundles import Body

        return Body(
            u=self.reference,
            v=self.reference,
            connectivity=self.connectivity,
            chunk_table=self.table,
            segments=self.segments,
            corner_rows=self.corner_rows,
            node_info=self.info,
            position=self.reference,
            mass=self.mass,
            params=self.parameters,
            rows=self.rows,
            special_force=self.special_force,
            node_sums=self.node_sums,
            cell_sums=self.cell_sums,
            memory=self.memory,
            volume_lists=self.volume_lists,
            volumes=self.volumes,
            bulk_viscosity=self.bulk_viscosity,
        )

    def without_boundary(self) -> InternalForce:
        """Return a pass over these arrays with every node an ordinary one, for products with the whole body."""
        from ..kernels.materials.law import HIGH

        other = copy(self)
        values = np.array(arrays.get(self.parameters))
        values[lanes.FREE] = 1.0
        values[self.strengths] = HIGH  # elastic products: plastic ones are below them, and unloading is elastic
        other.parameters = arrays.put(values)
        if self.viscous:  # products must not change the pressures
            other.cell_sums = arrays.put(arrays.get(self.cell_sums))
        other.kernel = Prepared(self.kernel.kernel) if isinstance(self.kernel, Prepared) else self.kernel
        return other

    def minus_force(self, u: arrays.Array, out: arrays.Array) -> None:
        """Add -f(u) / mass to out at ordinary nodes; u does not change."""
        self.advance(u, out, 0.0, 1.0, 0.0, loaded=False)

    def sums(self) -> np.ndarray:
        """Return the sums of the last pass over all chunks, in the order of a raw row: ordinary nodes, then cells."""
        columns = group_columns(*cell_groups(self.viscous, self.plastic))
        combine = [COMBINE[column.combine] for column in columns for _ in range(column.size)]
        nodes, count = arrays.get(self.node_sums).reshape(-1, NODE_SUMS), self.packs.all_chunks
        cells = arrays.get(self.cell_sums)[: count * len(combine)].reshape(count, len(combine))
        return np.array([*nodes.sum(axis=0), *(pick(cells[:, j]) for j, pick in enumerate(combine))])

    def sum_of(self, name: str) -> float:
        """Return a sum over the cells of the last pass by the name of its column."""
        return float(self.sums()[getattr(raw_places(self.viscous, self.plastic).cells, name)])

    def owned(self) -> list[arrays.Array]:
        """Return the arrays of this term."""
        shared = [self.connectivity, self.table, self.segments, self.info, self.reference, self.mass, self.rows]
        parts = (self.corner_rows, self.memory, self.volume_lists, self.volumes, self.bulk_viscosity)
        shared += [part for part in parts if part is not None]
        return [*shared, self.cell_sums] if self.viscous else shared
