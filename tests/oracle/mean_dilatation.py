"""Hexes with one volume change per cell, as a textbook has them (Q1-P0), all by 2x2x2 quadrature.

W = sum over points of w W0(H) + V k/2 (Theta - 1)^2,   Theta = sum w J / V,   W0 = W without k/2 (J - 1)^2
(linear law: Theta - 1 = sum w tr H / V, W0 = W without k/2 (tr H)^2)
"""

import numpy as np

from oracle.cells import assemble, cell_force, cell_tangent, displacement_gradient, energy, quadrature
from oracle.laws import IDENTITY, LinearElastic, MooneyRivlin, NeoHookean, trace, transposed, volume_change


class Without:
    """A law without its volumetric part of modulus k."""

    def __init__(self, law):
        self.law = law
        self.modulus = law.bulk if isinstance(law, MooneyRivlin) else law.lam
        assert isinstance(law, (LinearElastic, MooneyRivlin, NeoHookean))

    def change(self, H):
        """J - 1, its slope dJ/dF and its second derivative d2J/dFdF."""
        if self.law.is_linear:
            return trace(H), np.broadcast_to(IDENTITY, H.shape), np.zeros((*H.shape, 3, 3))
        change = volume_change(H)
        G = transposed(np.linalg.inv(IDENTITY + H))
        J = 1 + change
        curve = np.einsum("...ik,...jl->...ikjl", G, G) - np.einsum("...il,...jk->...ikjl", G, G)
        return change, J[..., None, None] * G, J[..., None, None, None, None] * curve

    def energy_density(self, H):
        return self.law.energy_density(H) - self.modulus / 2 * self.change(H)[0] ** 2

    def stress(self, H):
        change, slope, _ = self.change(H)
        return self.law.stress(H) - self.modulus * change[..., None, None] * slope

    def moduli(self, H):
        change, slope, curve = self.change(H)
        volumetric = np.einsum("...ik,...jl->...ikjl", slope, slope) + change[..., None, None, None, None] * curve
        return self.law.moduli(H) - self.modulus * volumetric


class MeanDilatation:
    """nodes [n, 3], cells [m, 8] and a law of this directory."""

    def __init__(self, nodes, cells, law):
        self.law, self.point = law, Without(law)
        self.quad = quadrature(nodes, cells, "hex8")
        self.volume = self.quad.weight.sum(axis=1)

    def _pressure(self, u):
        """p [m], dv/du [m, a, 3], p d2v/dudu [m, a, 3, b, 3]."""
        quad = self.quad
        change, slope, curve = self.point.change(displacement_gradient(quad, u))
        pressure = self.point.modulus * (quad.weight * change).sum(axis=1) / self.volume
        spread = np.einsum("mq,mqik,mqak->mai", quad.weight, slope, quad.gradient)
        half = np.einsum("mq,mqikjl,mqbl->mqikbj", quad.weight, curve, quad.gradient, optimize=True)
        second = np.einsum("mqak,mqikbj->maibj", quad.gradient, half, optimize=True)
        return pressure, spread, pressure[:, None, None, None, None] * second

    def energy(self, u):
        """Stored energy [J]."""
        pressure = self._pressure(u)[0]
        return energy(self.quad, self.point, u) + float(np.sum(self.volume * pressure**2) / (2 * self.point.modulus))

    def cell_force(self, u):
        """Internal force of each cell on its nodes [m, 8, 3] [N]."""
        pressure, spread, _ = self._pressure(u)
        return cell_force(self.quad, self.point, u) + pressure[:, None, None] * spread

    def force(self, u):
        """f(u) = dW/du [n, 3] [N]."""
        return assemble(self.quad.cells, self.cell_force(u), len(u))

    def tangent(self, u):
        """df/du [3n, 3n], dense."""
        _, spread, second = self._pressure(u)
        rank_one = np.einsum("m,mai,mbj->maibj", self.point.modulus / self.volume, spread, spread)
        blocks = cell_tangent(self.quad, self.point, u) + second + rank_one
        cells = self.quad.cells
        dof = (3 * cells[:, :, None] + np.arange(3)).reshape(len(cells), -1)
        result = np.zeros((u.size, u.size))
        for places, block in zip(dof, blocks.reshape(len(cells), 24, 24), strict=True):
            result[np.ix_(places, places)] += block
        return result
