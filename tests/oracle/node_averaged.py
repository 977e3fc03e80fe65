"""Linear tetrahedra whose volume changes are averaged at the nodes: an energy per cell and one per node.

W = sum over cells of V_e W0(H) + sum over nodes of V_a k/2 th_a^2,   W0 = W without k/2 (J - 1)^2
V_a = sum of w_e V_e,   th_a = sum of w_e V_e (J_e - 1) / V_a   over the cells round a node (linear law: tr H)

w_e = 1 over the number of corners of a cell that are no `held` nodes; a cell of held nodes alone is its own group.
"""

import numpy as np

from oracle.cells import assemble, cell_force, cell_tangent, displacement_gradient, energy, quadrature
from oracle.mean_dilatation import Without


class NodeAveraged:
    """nodes [n, 3], cells [m, 4] and a law of this directory; held [n]: nodes without volume."""

    def __init__(self, nodes, cells, law, held=None):
        self.law, self.point, self.cells = law, Without(law), cells
        self.quad = quadrature(nodes, cells, "tet4")
        self.volume = self.quad.weight[:, 0]
        held = np.zeros(len(nodes), dtype=bool) if held is None else held
        groups = [(number, node) for number, cell in enumerate(cells) for node in cell if not held[node]]
        alone = np.flatnonzero(held[cells].all(axis=1))
        count = len(nodes) + len(alone)
        self.average = np.zeros((count, len(cells)))  # w_e V_e
        for cell, node in groups:
            self.average[node, cell] = self.volume[cell] / (~held[cells[cell]]).sum()
        self.average[len(nodes) + np.arange(len(alone)), alone] = self.volume[alone]
        self.average = self.average[self.average.sum(axis=1) > 0.0]
        self.total = self.average.sum(axis=1)

    def changes(self, u):
        """Return J_a - 1 of the groups, J_e - 1, its slope dJ/dF and its second derivative."""
        change, slope, curve = (part[:, 0] for part in self.point.change(displacement_gradient(self.quad, u)))
        return self.average @ change / self.total, change, slope, curve

    def energy(self, u):
        """Stored energy [J]."""
        return energy(self.quad, self.point, u) + self.point.modulus / 2 * float(self.total @ self.changes(u)[0] ** 2)

    def pressure(self, u):
        """p_e [m] [Pa]."""
        return self.point.modulus * (self.average.T @ self.changes(u)[0]) / self.volume

    def force(self, u):
        """f(u) = dW/du [n, 3] [N]."""
        slope = self.changes(u)[2]
        spread = np.einsum("m,m,mik,mak->mai", self.volume, self.pressure(u), slope, self.quad.gradient[:, 0])
        return assemble(self.cells, cell_force(self.quad, self.point, u) + spread, len(u))

    def tangent(self, u):
        """df/du [3n, 3n], dense."""
        _, _, slope, curve = self.changes(u)
        gradient = self.quad.gradient[:, 0]
        scale = self.volume * self.pressure(u)
        blocks = cell_tangent(self.quad, self.point, u).reshape(len(self.cells), 12, 12)
        second = np.einsum("m,mak,mikjl,mbl->maibj", scale, gradient, curve, gradient, optimize=True)
        dof = (3 * self.cells[:, :, None] + np.arange(3)).reshape(len(self.cells), -1)
        result, spread = np.zeros((u.size, u.size)), np.zeros((len(self.cells), u.size))
        for number, (places, block) in enumerate(zip(dof, blocks + second.reshape(blocks.shape), strict=True)):
            result[np.ix_(places, places)] += block
            spread[number, places] = np.einsum("ik,ak->ai", slope[number], gradient[number]).ravel()
        along = self.average @ spread
        return result + self.point.modulus * along.T @ (along / self.total[:, None])
