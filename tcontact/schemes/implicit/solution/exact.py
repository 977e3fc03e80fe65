"""Exact contact of nodes without mass in Newton's method: g >= 0, lambda >= 0, lambda g = 0 (paper eqs 15-17).

At active nodes the equations g = 0 replace the balance along the normals of the force; the residual there is the
contact force, R = sum lambda nu*. The set follows the signs of lambda and g at every evaluation
(a primal-dual active set: Hueber and Wohlmuth, Comput. Meth. Appl. Mech. Eng. 194, 3147, 2005).
"""

from __future__ import annotations

import numpy as np

from .surfaces import Passage

SHORT = 1e-6  # a normal shorter than this in the free components of a node exerts no force


class ExactContact:
    """The active set of nodes [k] and obstacles [p], and the rows it rewrites; free [k, 3, 3]: free components."""

    def __init__(self, free: np.ndarray, obstacles: int) -> None:
        self.free = free
        self.active = np.zeros((len(free), obstacles), dtype=bool)

    def balance(self, residual: np.ndarray, passages: list[Passage], gap_tolerance: float) -> np.ndarray:
        """Update the set for a residual [k, 3] (M a + f - f_ext) and return lambda [k, p] [N]."""
        normals = np.stack([past.normal for past in passages], axis=1) @ self.free
        self._gaps = np.stack([past.after for past in passages], axis=1)
        self._gradients = np.stack([past.gradient for past in passages], axis=1)
        self._turning = np.stack([past.turning for past in passages], axis=1)
        reach = np.linalg.norm(normals, axis=2) >= SHORT
        self._solve(normals, residual)
        pushing = self.active & (self.pressure > 0.0)
        self.active = reach & (pushing | (~self.active & (self._gaps < -gap_tolerance)))
        self._solve(normals, residual)
        return self.pressure

    def _solve(self, normals: np.ndarray, residual: np.ndarray) -> None:
        kept = np.where(self.active[:, :, None], normals, 0.0)
        self._inverse = np.linalg.pinv(kept)  # [k, 3, p]
        self.pressure = np.einsum("kip,ki->kp", self._inverse, residual)
        self._along = self._inverse @ kept  # projector on the normals of the active set

    def force(self, passages: list[Passage]) -> np.ndarray:
        """Return the contact forces of every obstacle [p, k, 3] [N]."""
        normals = np.stack([past.normal for past in passages])
        return np.asarray(self.pressure.T[:, :, None] * normals)

    def rows(self, residual: np.ndarray, stiff: np.ndarray) -> np.ndarray:
        """Return the residual [k, 3] with gaps in place of the components that contact balances; stiff [k] [N/m]."""
        gaps = np.where(self.active, self._gaps, 0.0)
        rest = residual - np.einsum("kij,kj->ki", self._along, residual)
        return rest + stiff[:, None] * np.einsum("kip,kp->ki", self._inverse, gaps)

    def curvature(self) -> np.ndarray:
        """Return -lambda d nu*/dx [k, 3, 3], part of the tangent."""
        pressure = np.where(self.active, self.pressure, 0.0)
        return -np.einsum("kp,kpij->kij", pressure, self._turning)

    def keep(self) -> np.ndarray:
        """Return the factors [k, 3, 3] of the rows of the nodes that keep the balance."""
        return np.eye(3) - self._along

    def replaced(self, stiff: np.ndarray) -> np.ndarray:
        """Return the diagonal blocks [k, 3, 3] of the equations that replace it."""
        gradients = np.where(self.active[:, :, None], self._gradients, 0.0)
        return stiff[:, None, None] * np.einsum("kip,kpj->kij", self._inverse, gradients)
