"""One-point hexes, as a textbook has them: mean B by quadrature, gamma vectors, a stiffness per hourglass mode.

G_k = 1/V int grad N_k dV,   gamma_a = h_a - sum over k of (h_a,k x_k) . G,   W = V W(H) + kappa/2 sum |gamma_a u|^2
kappa = share (lam + 2 mu) V (G:G) / 8
"""

import numpy as np

from oracle.cells import (
    HEX_CORNERS,
    Quadrature,
    assemble,
    cell_force,
    cell_tangent,
    displacement_gradient,
    energy,
    equivalent,
    quadrature,
)

r, s, t = HEX_CORNERS.T
HOURGLASS_MODES = np.array([r * s, r * t, s * t, r * s * t])
SHARE = 0.05


class ReducedHex:
    """point: the mean gradients as a quadrature of one point; gamma [m, 4, 8]; kappa [m] [N/m]."""

    def __init__(self, nodes, cells, law, share=SHARE):
        full = quadrature(nodes, cells, "hex8")
        volume = full.weight.sum(axis=1)
        mean = np.einsum("mq,mqai->mai", full.weight, full.gradient) / volume[:, None, None]
        self.law = law
        self.point = Quadrature(cells, np.full((1, 8), 1 / 8), mean[:, None], volume[:, None])
        modes = np.einsum("ha,mai->mhi", HOURGLASS_MODES, nodes[cells] - nodes[cells[:, :1]])
        self.gamma = HOURGLASS_MODES - np.einsum("mhi,mai->mha", modes, mean)
        self.kappa = share * (law.lam + 2 * law.mu) * volume * np.sum(mean**2, axis=(1, 2)) / 8

    def hourglass(self, u):
        """q_a = gamma_a u [m, 4, 3] [m]."""
        cells = self.point.cells
        return np.einsum("mha,mai->mhi", self.gamma, u[cells] - u[cells[:, :1]])

    def hourglass_energy(self, u):
        """Energy of the hourglass stiffness [J]."""
        return float(np.sum(self.kappa[:, None, None] * self.hourglass(u) ** 2) / 2)

    def energy(self, u):
        """Stored energy, hourglass energy included [J]."""
        return energy(self.point, self.law, u) + self.hourglass_energy(u)

    def cell_force(self, u):
        """Internal force of each cell on its nodes [m, 8, 3] [N]."""
        stiff = self.kappa[:, None, None] * self.hourglass(u)
        return cell_force(self.point, self.law, u) + np.einsum("mha,mhi->mai", self.gamma, stiff)

    def von_mises(self, u):
        """Von Mises norm of the Cauchy stress of the mean gradient [m] [Pa]."""
        return equivalent(self.law.cauchy(displacement_gradient(self.point, u)[:, 0]))

    def force(self, u):
        """f(u) = dW/du [n, 3] [N]."""
        return assemble(self.point.cells, self.cell_force(u), len(u))

    def tangent(self, u):
        """df/du [3n, 3n], dense."""
        blocks = cell_tangent(self.point, self.law, u)
        blocks += np.einsum("m,mha,mhb,ij->maibj", self.kappa, self.gamma, self.gamma, np.eye(3))
        cells, size = self.point.cells, u.size
        dof = (3 * cells[:, :, None] + np.arange(3)).reshape(len(cells), -1)
        result = np.zeros((size, size))
        for places, block in zip(dof, blocks.reshape(len(cells), 24, 24), strict=True):
            result[np.ix_(places, places)] += block
        return result
