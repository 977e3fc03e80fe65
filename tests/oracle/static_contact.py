"""The static contact problem on massless nodes, by a dense active-set Newton method.

    f_K(x) - f_ext,K = sum_p lambda_p nu_p,   g_p(x_K) + lambda_p / (kappa A) >= 0,   lambda_p >= 0,   product = 0

with 1/kappa = 0 for the exact constraint. Each Newton step reduces the linearised problem to a linear complementarity
problem in lambda with the compliance matrix D^T K_KK^-1 D, which is solved exactly.
"""

from dataclasses import replace

import numpy as np
from scipy.linalg import LinAlgError, cho_factor, cho_solve
from scipy.optimize import nnls

from oracle.cells import assemble, cell_force, cell_tangent, displacement_gradient
from oracle.laws import volume_change
from oracle.mass import SUPPORT_TOLERANCE


def solve_lcp(compliance, gap, start):
    """lambda >= 0 with gap + compliance lambda >= 0 and zero product; primal-dual active set, else Lawson-Hanson."""
    scale_force = np.abs(gap).max(initial=0.0) / max(np.diag(compliance).max(initial=0.0), 1e-300)
    scale_gap = np.abs(gap).max(initial=0.0)
    active, seen = start.copy(), set()
    while active.tobytes() not in seen:
        seen.add(active.tobytes())
        force = np.zeros_like(gap)
        if active.any():
            block = compliance[np.ix_(active, active)]
            force[active] = np.linalg.lstsq(block, -gap[active], rcond=1e-13)[0]
        after = gap + compliance @ force
        following = np.where(active, force > -1e-14 * scale_force, after < -1e-14 * scale_gap)
        if np.array_equal(following, active):
            return np.maximum(force, 0)
        active = following
    value, vector = np.linalg.eigh(compliance)
    root = np.sqrt(np.maximum(value, 1e-15 * value.max()))
    return nnls(root[:, None] * vector.T, -(vector.T @ gap) / root, maxiter=50 * len(gap))[0]


class StaticContact:
    """The problem for one body: everything that does not change between solves.

    contact [k] node ids, basis [k, 3, 3] movable directions as columns, normals [p, 3], area [n] and penalty
    [N/m^3] (None = exact). viscous: the contact cells with weights times eta/dt, for the rate from the displacement
    `before` [n, 3] (None: no rate yet), of a linear law.
    """

    def __init__(self, quad, law, contact, basis, normals, free, area, penalty=None):
        self.law, self.contact, self.basis = law, contact, basis
        self.normals = np.atleast_2d(normals)
        inside = np.zeros(len(free), bool)
        inside[contact] = True
        self.quad = quad.part(inside[quad.cells].any(axis=1))
        self.movable = np.linalg.norm(basis, axis=1) > 0.5
        self.row = np.full(self.movable.shape, -1)
        self.row[self.movable] = np.arange(self.movable.sum())
        reach = self.normals[None] * free[contact][:, None, :]
        self.pair_node, self.pair_plane = np.nonzero(np.linalg.norm(reach, axis=2) >= SUPPORT_TOLERANCE)
        self.push = np.zeros((int(self.movable.sum()), len(self.pair_node)))
        for column, (k, p) in enumerate(zip(self.pair_node, self.pair_plane, strict=True)):
            self.push[self.row[k][self.movable[k]], column] = (basis[k].T @ self.normals[p])[self.movable[k]]
        weight = area[contact][self.pair_node]
        self.softness = np.zeros(len(weight)) if penalty is None else 1 / (penalty * weight)
        modulus = law.lam + 2 * law.mu
        positive = area[contact][area[contact] > 0]
        self.least_force = 1e-6 * modulus * (positive.mean() if len(positive) else 0)
        self._factor = None
        self._closed = np.zeros(len(weight), bool)
        self.viscous, self.before = None, None

    def viscosity(self, eta_over_dt, whole):
        """Make the contact cells viscous; eta over dt of every cell of the whole quadrature."""
        inside = np.zeros(whole.cells.max() + 1, bool)
        inside[self.contact] = True
        chosen = inside[whole.cells].any(axis=1)
        self.viscous = replace(self.quad, weight=self.quad.weight * eta_over_dt[chosen][:, None])

    def step_from(self, u):
        """Rates count from this displacement."""
        if self.viscous is not None:
            self._factor = self._factor if self.before is not None else None
            self.before = u.copy()

    def viscous_force(self, u):
        """Return the viscous force of every node [n, 3]."""
        if self.before is None:
            return np.zeros_like(u)
        return assemble(self.viscous.cells, cell_force(self.viscous, self.law, u - self.before), len(u))

    def force(self, u):
        """Internal force on the contact nodes [k, 3] and F_ref [N]."""
        local = cell_force(self.quad, self.law, u)
        force = assemble(self.quad.cells, local, len(u))[self.contact]
        force = force + self.viscous_force(u)[self.contact]
        size = assemble(self.quad.cells, np.linalg.norm(local, axis=2)[..., None], len(u))[self.contact]
        return force, max(size.max(initial=0.0), self.least_force)

    def _inverted(self, u):
        return volume_change(displacement_gradient(self.quad, u)).min() <= -1

    def _tangent(self, u):
        """df/du in the movable directions [d, d] [N/m]."""
        node_row = np.full(len(u), -1)
        node_row[self.contact] = np.arange(len(self.contact))
        local = node_row[self.quad.cells]
        frame = np.where((local >= 0)[..., None, None], self.basis[local], 0)
        stiffness = cell_tangent(self.quad, self.law, u)
        if self.before is not None:
            stiffness = stiffness + cell_tangent(self.viscous, self.law, u)
        stiffness = np.einsum("maic,maibj,mbjd->macbd", frame, stiffness, frame, optimize=True)
        dof = np.where((local >= 0)[..., None], self.row[local], -1)
        size = int(self.movable.sum())
        total = np.zeros((size + 1, size + 1))
        rows = np.broadcast_to(dof[:, :, :, None, None], stiffness.shape)
        columns = np.broadcast_to(dof[:, None, None, :, :], stiffness.shape)
        np.add.at(total, (rows, columns), stiffness)
        return total[:size, :size]

    def _linearised(self, u, unbalanced, gap, closed):
        """Solve the linearised problem: the move in the movable directions and the multipliers.

        A strongly compressed skin may be unstable where it is free but held where it touches: if the tangent alone is
        not positive definite, the pairs that are expected to be closed are stiffened, which changes nothing as long
        as they stay closed. An instability of the touching state itself raises ValueError.
        """
        factor = self._factor
        stiffener = 0.0
        if factor is None:
            stiffness = self._tangent(u)
            try:
                factor = cho_factor(stiffness)
            except LinAlgError as error:
                if self.softness.any():
                    raise ValueError("unstable tangent under a penalty") from error
                stiffener = np.trace(stiffness) / len(stiffness)
            self._factor = factor if self.law.is_linear else None
        while True:
            drive = unbalanced
            if stiffener:
                held = self.push[:, closed]
                try:
                    factor = cho_factor(stiffness + stiffener * held @ held.T)
                except LinAlgError as error:
                    name = type(self.law).__name__
                    raise ValueError(f"{name}: contact tangent is not positive definite") from error
                drive = unbalanced + stiffener * held @ gap[closed]
            response = cho_solve(factor, self.push)
            drift = cho_solve(factor, drive)
            compliance = self.push.T @ response + np.diag(self.softness)
            multiplier = solve_lcp(compliance, gap - self.push.T @ drift, closed)
            if not stiffener or np.all(multiplier[closed] > 0):
                return response @ multiplier - drift, multiplier
            closed = closed & (multiplier > 0)

    def solve(self, nodes, u, points, external, tolerance=1e-13, most=60):
        """Move the contact nodes of u [n, 3] into balance; points [p, 3] on the planes, external [n, 3] [N].

        Returns u, multipliers [k, p] [N], the residual relative to F_ref and the number of Newton steps.
        """
        u = u.copy()
        multiplier = np.zeros(len(self.pair_node))
        previous, start = np.inf, self._closed
        for step in range(most):
            force, scale = self.force(u)
            unbalanced = np.einsum("kic,ki->kc", self.basis, force - external[self.contact])[self.movable]
            place = nodes[self.contact] + u[self.contact]
            gap = np.sum((place[self.pair_node] - points[self.pair_plane]) * self.normals[self.pair_plane], axis=1)
            residual = np.abs(unbalanced - self.push @ multiplier).max(initial=0.0) / scale
            apart = gap + self.softness * multiplier
            length = np.sqrt(np.median(np.linalg.norm(self.quad.gradient, axis=3)) ** -2)
            slack = 1e-12 * length + 1e-15 * np.abs(place).max(initial=0.0)
            closed = np.all(apart > -slack) and np.all(np.abs(apart[multiplier > 0]) < slack)
            # displacements are rounded to eps |u|, which bounds the residual from below: stop where it stands still
            if step > 0 and closed and (residual <= tolerance or previous / 2 <= residual <= 1e-8):
                break
            previous = residual
            change, multiplier = self._linearised(u, unbalanced, gap, (multiplier > 0) | (gap < 0) | start)
            start = np.zeros(len(gap), bool)
            move = np.zeros(self.movable.shape)
            move[self.movable] = change
            step_u = np.zeros_like(u)
            step_u[self.contact] = np.einsum("kic,kc->ki", self.basis, move)
            share = 1.0
            while not self.law.is_linear and self._inverted(u + share * step_u):
                share /= 2
                if share < 1e-6:
                    raise ValueError("contact cell inverts")
            u += share * step_u
        else:
            raise ValueError(f"static contact not converged: residual {residual:.1e}")
        self._closed = multiplier > 0
        table = np.zeros((len(self.contact), len(self.normals)))
        table[self.pair_node, self.pair_plane] = multiplier
        return u, table, residual, step
