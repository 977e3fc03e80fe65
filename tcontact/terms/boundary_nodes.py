"""Nodes with tensor mass, supports or contact: their kick and drift, and the reactions of the supports."""

from __future__ import annotations

import numpy as np

from .. import arrays
from ..launch import Prepared
from ..plan import BodyPlan

SYMMETRIC = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))


def flat_tensors(tensors: np.ndarray) -> np.ndarray:
    """Symmetric tensors [s, 3, 3] as (xx, yy, zz, xy, yz, xz) [s, 6]."""
    return np.stack([tensors[:, i, j] for i, j in SYMMETRIC], axis=1)


class BoundaryNodes:
    """The list of boundary nodes: `force` is their internal force of the last pass, less the contact force."""

    name = "boundary-nodes"

    def __init__(self, plan: BodyPlan, force: arrays.Array) -> None:
        from ..kernels.boundary_nodes import SUMS, kick_and_drift

        self.kernel = Prepared(kick_and_drift)
        self.force = force
        self.nodes = arrays.put(plan.boundary.astype(np.int32))
        self.mass = arrays.put(flat_tensors(plan.tensors))
        self.inverse_mass = arrays.put(flat_tensors(plan.inverses))
        self.load = arrays.put(plan.loads)
        self.totals = arrays.zeros(SUMS)

    def advance(
        self,
        reference: arrays.Array,
        u: arrays.Array,
        v: arrays.Array,
        kick_before: float,
        kick_after: float,
        drift: float,
    ) -> None:
        """The same update as for ordinary nodes, with mass tensors."""
        self.kernel(
            self.nodes,
            self.mass,
            self.inverse_mass,
            self.load,
            self.force,
            reference,
            kick_before,
            kick_after,
            drift,
            u,
            v,
            self.totals,
        )

    def sums(self) -> np.ndarray:
        """Kinetic energy, momentum (3), angular momentum (3), work of the loads [8]."""
        return arrays.get(self.totals)

    def owned(self) -> list[arrays.Array]:
        """Arrays of this term."""
        return [self.nodes, self.mass, self.inverse_mass, self.load, self.force]


class Supports:
    """Reactions of held and driven components (METHOD 1): M a + f - f_ext - contact force."""

    name = "supports"

    def __init__(self, plan: BodyPlan, nodes: BoundaryNodes) -> None:
        from ..kernels.boundary_nodes import support_reactions

        self.kernel = Prepared(support_reactions)
        self.nodes = nodes
        self.rows = arrays.put(plan.support_rows.astype(np.int32))
        self.axes = arrays.put(plan.support_axes.astype(np.int32))
        self.speeds = arrays.put(plan.speeds)
        self.totals = arrays.zeros(4)

    def react(self) -> tuple[np.ndarray, float]:
        """Total reaction [3] [N] and its power [W] at the last force pass, contact forces already taken off."""
        listed = self.nodes
        self.kernel(
            self.rows, self.axes, self.speeds, listed.mass, listed.inverse_mass, listed.load, listed.force, self.totals
        )
        totals = arrays.get(self.totals)
        return totals[:3], float(totals[3])

    def owned(self) -> list[arrays.Array]:
        """Arrays of this term."""
        return [self.rows, self.axes, self.speeds]
