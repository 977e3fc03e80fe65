"""The contact-touching cells: their corner forces and the stiffness between contact nodes.

Every contact cell gets corners of its own, so that the force pass of the body, compiled once, hands out forces cell by
cell: their sum is the force on a contact node, the sum of their sizes its reference force F_ref (METHOD 2).
"""

from __future__ import annotations

import numpy as np

from .. import arrays
from ..contact_graph import ContactGraph
from ..launch import Prepared
from ..lumped_mass import shape_functions
from ..plan import BodyPlan
from .internal_force import InternalForce


class SurfaceCells:
    """minus_force [cells, corners, 3]: minus corner forces of the last `measure`; pair_values: K_ab of the pairs."""

    def __init__(self, plan: BodyPlan, graph: ContactGraph, basis: np.ndarray, block: int) -> None:
        from ..kernels.surface_cells import gather_cells, make_surface_tangent

        cells = plan.cells[graph.cells]
        own = np.arange(cells.size).reshape(cells.shape)
        points = plan.reference[cells].reshape(-1, 3)
        self.force = InternalForce(plan, own, points, np.ones(cells.size), np.zeros(0, dtype=np.int64))
        self.cell_nodes = arrays.put(cells.reshape(-1))
        self.cell_u = arrays.zeros(3 * cells.size)
        self.minus_force = arrays.zeros(3 * cells.size)
        self.corner_count = cells.shape[1]
        _values, gradients, weights = shape_functions(plan.body.mesh.kind)
        self.shape_gradients = arrays.put(gradients)
        self.weights = arrays.put(weights)
        self.pair_start = arrays.put(graph.pair_start)
        self.pair_corners = arrays.put(graph.pair_corners)
        self.pair_nodes = arrays.put(graph.pair_nodes)
        self.pair_values = arrays.zeros(len(graph.pair_nodes) * block * block)
        plain = bool(block == 3 and (basis == np.eye(3)).all())
        self._gather = Prepared(gather_cells)
        if plan.body.formulation == "reduced":
            from ..kernels.reduced_tangent import make_reduced_tangent

            self._tangent = Prepared(make_reduced_tangent(plan.body.material.law, block))
        else:
            self._tangent = Prepared(make_surface_tangent(plan.body.material.law, block, plain))

    def measure(self, u: arrays.Array) -> None:
        """Corner forces at displacement u of the body."""
        self._gather(self.cell_nodes, u, self.cell_u, self.minus_force)
        self.force.minus_force(self.cell_u, self.minus_force)

    def linearise(self, basis: arrays.Array) -> None:
        """Pair stiffnesses at the displacement of the last `measure`."""
        self._tangent(
            self.shape_gradients,
            self.weights,
            self.force.reference,
            self.cell_u,
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
        own = [self.cell_nodes, self.cell_u, self.minus_force, self.pair_start, self.pair_corners, self.pair_nodes]
        return [*own, self.pair_values, *self.force.owned()]
