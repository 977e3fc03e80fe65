"""Coulomb friction by other means than the program's: scaling back on nodes with mass, De Saxce's cone without it.

With mass: an impulse stops the tangential velocity v* of a kick, or is scaled back to mu lambda span. Without mass the
whole contact law of a node, gap g >= 0, slip s, lambda >= 0, |t| <= mu lambda, is one inclusion (De Saxce and Feng
1998), solved by projections onto the Coulomb cone:

    -(g + mu |s|, s) in N_C(lambda, t),   C = {|t| <= mu lambda}
"""

import numpy as np
from scipy.linalg import cho_factor, cho_solve


def scaled_back(mass, star, walls, normals, pressing, span, coefficient):
    """Friction [p, 3] [N] on one node of this mass whose velocity without it is star [3]."""
    force = np.zeros_like(normals)
    for _ in range(1 if len(normals) == 1 else 500):
        for p in np.flatnonzero(pressing > 0):
            others = force.sum(axis=0) - force[p]
            slip = star + span * others / mass - walls[p]
            slip = slip - normals[p] * (normals[p] @ slip)
            stopping = -slip * mass / span
            size = np.linalg.norm(stopping)
            force[p] = stopping * min(1.0, coefficient * pressing[p] / size) if size > 0 else 0.0
    return force


def onto_cone(force, coefficient):
    """Nearest point of the Coulomb cone to forces [k, 3] given as (normal, two tangential)."""
    normal, along = force[:, 0], force[:, 1:]
    size = np.linalg.norm(along, axis=1)
    inside = size <= coefficient * normal
    apex = coefficient * size <= -normal
    height = (normal + coefficient * size) / (1 + coefficient**2)
    height = np.where(inside, normal, np.where(apex, 0, height))
    share = np.where(inside, 1, coefficient * height / np.maximum(size, 1e-300))
    return np.column_stack([height, share[:, None] * along])


class SlidingContact:
    """The static problem with friction of a linear body whose contact nodes have no mass at all (full removal)."""

    def __init__(self, static, coefficient):
        assert static.law.is_linear
        assert static.movable.all()
        assert not static.softness.any()
        self.static, self.coefficient = static, coefficient
        self.frame = np.array([np.column_stack([n, *np.linalg.svd(n[None])[2][1:]]) for n in static.normals])
        pairs, size = len(static.pair_node), int(static.movable.sum())
        self.lift = np.zeros((size, 3 * pairs))
        for i, (k, p) in enumerate(zip(static.pair_node, static.pair_plane, strict=True)):
            self.lift[np.ix_(static.row[k], range(3 * i, 3 * i + 3))] = static.basis[k].T @ self.frame[p]
        self.force = np.zeros((pairs, 3))
        self._ready = None

    def solve(self, nodes, u, points, walls, external):
        """Move the contact nodes of u [n, 3], which slip from there against walls that move on by walls [p, 3] [m].

        Returns u, and of every pair of node and plane lambda [i], friction [i, 3] and slip [i, 3].
        """
        static, mu = self.static, self.coefficient
        if self._ready is None:
            factor = cho_factor(static._tangent(u))
            compliance = self.lift.T @ cho_solve(factor, self.lift)
            self._ready = factor, compliance, 1 / np.linalg.eigvalsh(compliance)[-1]
        factor, compliance, pace = self._ready
        inner, _ = static.force(u)
        unbalanced = np.einsum("kic,ki->kc", static.basis, inner - external[static.contact])[static.movable]
        node, plane = static.pair_node, static.pair_plane
        place = nodes[static.contact] + u[static.contact]
        gap = np.sum((place[node] - points[plane]) * static.normals[plane], axis=1)
        start = -np.einsum("ijc,ij->ic", self.frame[plane], walls[plane])
        start[:, 0] = gap
        start = start - (self.lift.T @ cho_solve(factor, unbalanced)).reshape(-1, 3)
        force = self.force
        for _ in range(100000):
            moved = start + (compliance @ force.ravel()).reshape(-1, 3)
            moved[:, 0] += mu * np.linalg.norm(moved[:, 1:], axis=1)
            before, force = force, onto_cone(force - pace * moved, mu)
            if np.abs(force - before).max() <= 1e-15 * np.abs(force).max():
                break
        else:
            raise ValueError("friction not converged")
        self.force = force
        moved = start + (compliance @ force.ravel()).reshape(-1, 3)
        change = cho_solve(factor, self.lift @ force.ravel() - unbalanced)
        u = u.copy()
        u[static.contact] += np.einsum("kic,kc->ki", static.basis, change.reshape(static.movable.shape))
        across = self.frame[plane][:, :, 1:]
        friction, slip = (np.einsum("ijc,ic->ij", across, part[:, 1:]) for part in (force, moved))
        return u, force[:, 0], friction, slip
