"""Mass of an implicit step: mass tensors of nodes, or the consistent matrix with redistribution (paper eq. 13).

Mbar_T = I_T M_T I_T^t,   I_T: the massless components of a node of K go to the nodes of its cell outside K

Supports do not change the shares here, as they do for the lumped mass.
"""

from __future__ import annotations

import numpy as np

from ....planning.body_plan import BodyPlan
from .sparsity import Sparsity


class NodalMass:
    """Mass tensors [n, 3, 3] [kg] of the nodes."""

    def __init__(self, plan: BodyPlan) -> None:
        self.tensors = plan.lumped[:, None, None] * np.eye(3)
        self.tensors[plan.boundary] = plan.tensors
        self.inverses = np.zeros_like(self.tensors)
        free = np.setdiff1d(np.arange(len(plan.lumped)), plan.boundary)
        self.inverses[free] = np.eye(3) / plan.lumped[free, None, None]
        self.inverses[plan.boundary] = plan.inverses

    def times(self, values: np.ndarray) -> np.ndarray:
        """Return M times nodal vectors [n, 3]."""
        return np.einsum("nij,nj->ni", self.tensors, values)

    def solve(self, values: np.ndarray) -> np.ndarray:
        """Apply the inverse on the components that have mass and are not prescribed; zero on the others."""
        return np.einsum("nij,nj->ni", self.inverses, values)

    def add_to(self, blocks: np.ndarray, factor: float, sparsity: Sparsity) -> None:
        """Add factor times M to the blocks [b, 3, 3]."""
        blocks[sparsity.diagonal] += factor * self.tensors


class ConsistentMass:
    """The matrix of eq. 13 as blocks in the sparsity of the tangent."""

    def __init__(self, plan: BodyPlan, sparsity: Sparsity) -> None:
        import scipy.sparse

        matrices = consistent_cells(plan)  # [m, a, 3, b, 3]
        self.blocks = np.zeros((len(sparsity.columns), 3, 3))
        np.add.at(self.blocks, sparsity.slots, matrices.transpose(0, 1, 3, 2, 4))
        count = len(plan.reference)
        self.matrix = scipy.sparse.bsr_matrix(
            (self.blocks, sparsity.columns, sparsity.starts), shape=(3 * count, 3 * count)
        )
        self.plan = plan

    def times(self, values: np.ndarray) -> np.ndarray:
        """Return M times nodal vectors [n, 3]."""
        return np.asarray(self.matrix @ values.reshape(-1)).reshape(-1, 3)

    def solve(self, values: np.ndarray) -> np.ndarray:
        """Apply the inverse on the components that move freely by conjugate gradients; zero on the others."""
        nodal = NodalMass(self.plan)
        from scipy.sparse.linalg import LinearOperator, cg

        moves = np.einsum("nij,njk->nik", nodal.tensors, nodal.inverses)  # a projector
        size = values.size

        def inside(x: np.ndarray) -> np.ndarray:
            here = np.einsum("nij,nj->ni", moves, x.reshape(-1, 3))
            return np.asarray(np.einsum("nji,nj->ni", moves, self.times(here)) + x.reshape(-1, 3) - here).reshape(-1)

        right = np.einsum("nji,nj->ni", moves, values).reshape(-1)
        found, _ = cg(LinearOperator((size, size), matvec=inside), right, rtol=1e-13, maxiter=1000)
        return np.einsum("nij,nj->ni", moves, found.reshape(-1, 3))

    def add_to(self, blocks: np.ndarray, factor: float, sparsity: Sparsity) -> None:
        """Add factor times M to the blocks [b, 3, 3]."""
        blocks += factor * self.blocks


def consistent_cells(plan: BodyPlan) -> np.ndarray:
    """Return the redistributed mass matrices [m, a, 3, b, 3] [kg] of the cells."""
    body, cells = plan.body, plan.cells
    values, slopes, weights = body.mesh.element.product_rule
    corners = plan.reference[cells]
    jacobian = np.einsum("mad,qac->mqdc", corners - corners[:, :1], slopes, optimize=True)
    volumes = weights * np.linalg.det(jacobian)
    scalar = body.blocks[0].material.density * np.einsum("mq,qa,qb->mab", volumes, values, values, optimize=True)
    result = np.einsum("mab,ij->maibj", scalar, np.eye(3))
    contact = plan.contact
    if contact is None or contact.basis is None:
        return result
    slot = np.full(len(plan.reference), -1)
    slot[contact.nodes] = np.arange(len(contact.nodes))
    width = cells.shape[1]
    for cell in np.flatnonzero((slot[cells] >= 0).any(axis=1)):
        inside = slot[cells[cell]] >= 0
        transfer = np.einsum("ab,ij->aibj", np.eye(width), np.eye(3))
        for k in np.flatnonzero(inside):
            basis = contact.basis[slot[cells[cell, k]]]
            along = basis @ basis.T
            distance = np.linalg.norm(corners[cell] - corners[cell, k], axis=1)
            share = np.where(inside, 0.0, 1.0 / np.where(inside, 1.0, distance))
            transfer[:, :, k, :] += (share / share.sum())[:, None, None] * along
            transfer[k, :, k, :] -= along
        size = 3 * width
        moved = transfer.reshape(size, size) @ result[cell].reshape(size, size) @ transfer.reshape(size, size).T
        result[cell] = moved.reshape(width, 3, width, 3)
    return result
