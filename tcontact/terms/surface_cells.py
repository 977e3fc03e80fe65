"""The contact-touching cells: their corner forces and the stiffness between contact nodes."""

from __future__ import annotations

import numpy as np

from .. import arrays
from ..contact_graph import ContactGraph
from ..launch import Prepared
from ..lumped_mass import shape_functions
from ..plan import BodyPlan
from .internal_force import InternalForce


class SurfaceCells:
    """corner_rows: force row of every corner in K, in the order of `graph.corners`; pair_values: K_ab of the pairs."""

    def __init__(
        self, plan: BodyPlan, force: InternalForce, graph: ContactGraph, basis: np.ndarray, block: int
    ) -> None:
        from ..kernels.surface_cells import make_surface_tangent

        cells = plan.cells[graph.cells]
        self.force = force
        self.corner_count = cells.shape[1]
        assert force.surface is not None
        self.corner_rows = arrays.put(
            force.surface.rows(graph.corners // cells.shape[1], graph.corners % cells.shape[1])
        )
        self.cell_nodes = arrays.put(cells.reshape(-1))
        _values, gradients, weights = shape_functions(plan.body.mesh.kind)
        self.shape_gradients = arrays.put(gradients)
        self.weights = arrays.put(weights)
        self.pair_start = arrays.put(graph.pair_start)
        self.pair_corners = arrays.put(graph.pair_corners)
        self.pair_nodes = arrays.put(graph.pair_nodes)
        self.pair_values = arrays.zeros(len(graph.pair_nodes) * block * block)
        plain = bool(block == 3 and (basis == np.eye(3)).all())
        self._tangent = Prepared(make_surface_tangent(plan.body.material.law, block, plain))

    def linearise(self, basis: arrays.Array, u: arrays.Array) -> None:
        """Pair stiffnesses at displacement u."""
        self._tangent(
            self.shape_gradients,
            self.weights,
            self.cell_nodes,
            self.force.reference,
            u,
            self.pair_start,
            self.pair_corners,
            self.pair_nodes,
            basis,
            self.corner_count,
            *self.force.lame,
            self.pair_values,
        )

    def owned(self) -> list[arrays.Array]:
        """Arrays of the contact cells."""
        own = [self.corner_rows, self.cell_nodes, self.pair_start, self.pair_corners, self.pair_nodes]
        return [*own, self.pair_values]
