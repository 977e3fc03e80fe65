"""Exact contact of nodes without mass in Newton's method: g >= 0, lambda >= 0, lambda g = 0 (paper eqs 15-17).

At active nodes the equations g = 0 replace the balance along the normals of the force; the residual there is the
contact force, R = sum lambda nu*. The set follows the signs of lambda and g at every evaluation
(a primal-dual active set: Hueber and Wohlmuth, Comput. Meth. Appl. Mech. Eng. 194, 3147, 2005).

A node may reach several obstacles. They enter one after the other, the nearest first, each only if its gap would stay
negative where the gaps before it are closed: of two planes that nearly coincide the nearer one holds the node alone,
and a node is put on the line where they meet only when it crosses that line. (Both at once would put it there from
anywhere, over a distance of gap/angle.) Obstacles whose normals are one but for ALIKE are one: the nearer one counts.
"""

from __future__ import annotations

import numpy as np

from .surfaces import Passage

SHORT = 1e-6  # a normal shorter than this in the free components of a node exerts no force
# Sine of the angle between normals below which they are one. A node pressed in by a strain e of a body of size h lies
# within e s h of the line where two planes of sine s meet if both hold it, and e s^2 h deep in one if the other one
# holds it alone: less than NEARER tolerances of the gap (1e-10 h), so that neither takes the node from the other.
ALIKE = 1e-5
NEARER = 1e3


class ExactContact:
    """The active set of nodes [k] and obstacles [p], and the rows it rewrites; free [k, 3, 3]: free components."""

    def __init__(self, free: np.ndarray, obstacles: int) -> None:
        self.free = free
        self.active = np.zeros((len(free), obstacles), dtype=bool)

    def balance(self, residual: np.ndarray, passages: list[Passage], gap_tolerance: float) -> np.ndarray:
        """Update the set for a residual [k, 3] (M a + f - f_ext) and return lambda [k, p] [N]."""
        self._normals = np.stack([past.normal for past in passages], axis=1) @ self.free
        self._gaps = np.stack([past.after for past in passages], axis=1)
        self._gradients = np.stack([past.gradient for past in passages], axis=1)
        self._turning = np.stack([past.turning for past in passages], axis=1)
        open_before = ~self.active
        self._choose(self.active, np.zeros_like(self.active), gap_tolerance)
        pressure = self._pressure(residual)
        self._choose(self.active & (pressure > 0.0), open_before, gap_tolerance)
        self.pressure = self._pressure(residual)
        return self.pressure

    def _choose(self, kept: np.ndarray, others: np.ndarray, gap_tolerance: float) -> None:
        """Choose the active set [k, p] out of those kept and of others that the closed gaps leave violated.

        Sets what belongs to it: an orthonormal basis of its normals, whose projector is _along; _inverse [k, 3, p], the
        smallest motion that changes the gaps by given amounts; _weights, the same with every direction times the part
        of a normal along it, so that nearly equal normals do not magnify the rounding errors of gaps.
        """
        count, obstacles = self.active.shape
        node = np.arange(count)
        lengths = np.linalg.norm(self._normals, axis=2)
        # the nearest first; of those as near one that is kept, then the earlier one of the scene
        places = self._gaps + gap_tolerance * (np.arange(obstacles) - NEARER * kept)
        self.active = np.zeros_like(kept)
        self._along = np.zeros((count, 3, 3))
        self._inverse, self._weights = np.zeros((count, 3, obstacles)), np.zeros((count, 3, obstacles))
        for which in np.argsort(places, axis=1, kind="stable").T:
            normal = self._normals[node, which]
            rest = normal - np.einsum("kij,kj->ki", self._along, normal)
            size = np.linalg.norm(rest, axis=1)
            remaining = np.eye(obstacles)[which] - np.einsum("ki,kip->kp", normal, self._inverse)
            violated = np.einsum("kp,kp->k", remaining, self._gaps) < -gap_tolerance
            enters = kept[node, which] | (others[node, which] & violated)
            enters &= (lengths[node, which] >= SHORT) & (size >= ALIKE * lengths[node, which])
            direction = rest * (enters / np.where(enters, size, 1.0))[:, None]
            self.active[node, which] = enters
            self._along += direction[:, :, None] * direction[:, None, :]
            self._weights += direction[:, :, None] * remaining[:, None, :]
            self._inverse += direction[:, :, None] * (remaining / np.where(enters, size, 1.0)[:, None])[:, None, :]

    def _pressure(self, residual: np.ndarray) -> np.ndarray:
        return np.asarray(np.einsum("kip,ki->kp", self._inverse, residual))

    def force(self, passages: list[Passage]) -> np.ndarray:
        """Return the contact forces of every obstacle [p, k, 3] [N]."""
        normals = np.stack([past.normal for past in passages])
        return np.asarray(self.pressure.T[:, :, None] * normals)

    def rows(self, residual: np.ndarray, stiff: np.ndarray) -> np.ndarray:
        """Return the residual [k, 3] with gaps in place of the components that contact balances; stiff [k] [N/m]."""
        rest = residual - np.einsum("kij,kj->ki", self._along, residual)
        return rest + stiff[:, None] * np.einsum("kip,kp->ki", self._weights, self._gaps)

    def curvature(self) -> np.ndarray:
        """Return -lambda d nu*/dx [k, 3, 3], part of the tangent."""
        return -np.einsum("kp,kpij->kij", self.pressure, self._turning)

    def keep(self) -> np.ndarray:
        """Return the factors [k, 3, 3] of the rows of the nodes that keep the balance."""
        return np.eye(3) - self._along

    def replaced(self, stiff: np.ndarray) -> np.ndarray:
        """Return the diagonal blocks [k, 3, 3] of the equations that replace it."""
        return stiff[:, None, None] * np.einsum("kip,kpj->kij", self._weights, self._gradients)
