"""Contact nodes without mass, placed by a projected static solve every step (METHOD 2, paper 4.3)."""

from __future__ import annotations

import numpy as np

from .. import arrays
from ..contact_models import MasslessContact
from ..launch import Prepared
from ..lumped_mass import shape_functions
from ..plan import BodyPlan
from ..scene import Scene
from .boundary_nodes import BoundaryNodes
from .contact import ContactTerm
from .internal_force import InternalForce

TOLERANCE = 1e-4  # on the static residual, unless the user sets one
AIM = 1e-8  # the sweeps then go on to here if they can: what is unbalanced is lost to the momentum
LEFT = 1e-7  # what the last use of a tangent may leave of the residual of a nonlinear law
USED_UP = 0.05  # a tangent that leaves more than this share of a residual is renewed
SLOW = 0.5  # a linearisation that leaves more than this share of a residual below the tolerance is the last one
POLISHING_SWEEPS = 60  # at most this many to go below the tolerance, and per linearisation of a nonlinear law
MOST_SWEEPS = 500  # then the solve of a linear law has not converged
LINEARISATIONS = 4  # a nonlinear law has this many times as many
LEAST_FORCE = 1e-6  # F_ref is at least this times (lambda + 2 mu) times the mean area weight


class MasslessContactTerm(ContactTerm):
    """f_K - f_ext,K = lambda nu, g >= 0, lambda >= 0, lambda g = 0 by Newton outside and Gauss-Seidel inside."""

    name = "massless-contact"

    def __init__(self, scene: Scene, plan: BodyPlan, listed: BoundaryNodes, reference: arrays.Array) -> None:
        from ..kernels import static_solve
        from ..kernels.surface_tangent import make_surface_tangent

        super().__init__(scene, plan, listed, reference)
        model, contact, material = scene.contact, plan.contact, plan.body.material
        assert isinstance(model, MasslessContact) and contact is not None
        assert contact.graph is not None and contact.basis is not None
        graph, block = contact.graph, contact.block
        self.linear = material.linear
        self.lame = (material.lame_lambda, material.lame_mu)
        self.least_sweeps = model.sweeps
        self.tolerance = TOLERANCE if model.tolerance is None else model.tolerance
        self.aim = AIM if model.tolerance is None else model.tolerance
        self.enough = self.aim if model.tolerance is None else model.tolerance
        self.left = LEFT if model.tolerance is None else 0.0
        self.gravity = plan.gravity
        self.law = material.law
        self.exact = 1 if model.penalty is None else 0

        self.predict = Prepared(static_solve.make_predict(block, self.slots))
        self.gather = Prepared(static_solve.gather_cells)
        self.assemble = Prepared(static_solve.make_assemble(block, self.slots))
        self.blocks = Prepared(static_solve.make_blocks(block))
        self.solve = Prepared(static_solve.make_solve(block, self.slots))
        self.kernel = Prepared(static_solve.make_contact_load(block, self.slots))
        plain = bool(block == 3 and (contact.basis == np.eye(3)).all())
        self.tangent = Prepared(make_surface_tangent(material.law, block, plain))

        count = len(contact.nodes)
        area = float(contact.areas.mean())
        self.least_force = LEAST_FORCE * (material.lame_lambda + 2.0 * material.lame_mu) * area
        stiffness = np.inf if model.penalty is None else model.penalty * contact.areas
        self.compliance = arrays.put(np.broadcast_to(1.0 / stiffness, (count,)))
        self.basis = arrays.put(contact.basis[:, :, :block])
        self.massless = contact.basis[:, :, :block]
        for name in ("pair_start", "pair_corners", "pair_nodes", "row_start", "column", "entry_start", "entry_pairs"):
            setattr(self, name, arrays.put(getattr(graph, name).astype(np.int32)))
        self.corner_start = arrays.put(graph.corner_start.astype(np.int32))
        self.corners = arrays.put(graph.corners.astype(np.int32))
        self.active = arrays.put(np.zeros(count, dtype=np.int32))
        self.last = arrays.zeros(count * block)
        self.right = arrays.zeros(count * block)
        self.increment = arrays.zeros(count * block)
        self.values = arrays.zeros(len(graph.column) * block * block)
        self.inverse = arrays.zeros(count * block * block)
        self.pair_values = arrays.zeros(len(graph.pair_nodes) * block * block)
        self.stats = arrays.zeros(8)

        cells = plan.cells[graph.cells]  # every contact cell with corners of its own: forces come out cell by cell
        corners = cells.shape[1]
        own = np.arange(cells.size).reshape(cells.shape)
        self.corner_count = corners
        self.cell_nodes = arrays.put(cells.reshape(-1).astype(np.int32))
        self.cell_u = arrays.zeros(3 * cells.size)
        self.cell_v = arrays.zeros(3 * cells.size)
        points = plan.reference[cells].reshape(-1, 3)
        self.cells = InternalForce(plan, own, points, np.ones(cells.size), np.zeros(0, dtype=np.int64))
        _values, gradients, weights = shape_functions(plan.body.mesh.kind)
        self.shape_gradients = arrays.put(gradients)
        self.weights = arrays.put(weights)
        self.stale = True  # no tangent yet, or one that has lost its use

    def begin(self, u: arrays.Array, velocity: np.ndarray, dt: float) -> None:
        """Static solve at the start; the first prediction then goes on with the given velocity [k, 3] of K."""
        self.find_planes(u)
        self._project(u, 0.0, 0.0)
        self._equilibrate(u)
        moved = arrays.get(u).reshape(-1, 3)[arrays.get(self.nodes)]
        now = np.einsum("kic,ki->kc", self.massless, moved)
        before = now - dt * np.einsum("kic,ki->kc", self.massless, velocity)
        arrays.set_values(self.last, before)

    def load(self, u: arrays.Array, v: arrays.Array, span: float) -> None:
        self.kernel(
            self.nodes,
            self.basis,
            self.planes,
            self.near,
            self.reference,
            u,
            self.listed.load,
            self.compliance,
            self.active,
            self.listed.force,
            self.stats,
            self.contact_force,
            self.totals,
        )

    def close(self, u: arrays.Array, before: float, after: float) -> None:
        """x_K^{n+1}: predicted by extrapolation, then brought to equilibrium with x_J^{n+1}."""
        self.find_planes(u)
        self._project(u, after / before if before > 0.0 else 1.0, after * (before + after) / 2)
        self._equilibrate(u)

    def _project(self, u: arrays.Array, ratio: float, fall_time: float) -> None:
        """Extrapolate; fall_time [s^2] times gravity is what free flight adds."""
        fall = fall_time * self.gravity
        self.predict(
            self.nodes, self.basis, self.planes, self.near, self.reference, ratio, *fall, self.exact, u, self.last
        )

    def _equilibrate(self, u: arrays.Array) -> None:
        """Newton outside, Gauss-Seidel inside; a linear law is done after one linearisation.

        Other laws are measured again at the new state. A tangent is kept, from step to step too, while each use of it
        makes the residual much smaller; once the next use would leave too little to matter, that use is the last.
        Where K_KK is not definite (buckling under strong compression) progress is slow: below the tolerance it is
        enough then, above it each few sweeps get their own linearisation and go down in energy.
        """
        stats = arrays.get(self.stats)
        stats[2] = 0.0
        arrays.set_values(self.stats, stats)
        residual = self._measure(u)
        while True:
            if self.stale:
                self._linearise()
            before, residual = residual, self._sweep(u)
            if self.linear:
                break
            residual = self._measure(u)
            contraction = min(1.0, residual / max(before, self.aim))
            self.stale = contraction > USED_UP
            if residual <= self._bound():
                enough = residual <= max(self.enough, self._rounding())
                if enough or contraction * residual <= self.left or (contraction > SLOW and self.left > 0.0):
                    if residual > self.aim:
                        self._sweep(u)
                    break
            if not np.isfinite(residual) or self._swept() >= LINEARISATIONS * MOST_SWEEPS:
                break
        self.converged = residual <= self._bound()
        self.sweeps = self._swept()
        if not self.converged:
            self.message = self._explain(residual)

    def _swept(self) -> int:
        return int(arrays.get(self.stats)[2])

    def _rounding(self) -> float:
        return float(arrays.get(self.stats)[5])

    def _bound(self) -> float:
        return max(self.tolerance, self._rounding())

    def _measure(self, u: arrays.Array) -> float:
        """Out-of-balance forces at u; returns the static residual for the active set of the last sweep."""
        self.gather(self.cell_nodes, u, self.cell_u, self.cell_v)
        self.cells.minus_force(self.cell_u, self.cell_v)
        self.assemble(
            self.nodes,
            self.basis,
            self.planes,
            self.near,
            self.reference,
            u,
            self.listed.load,
            self.compliance,
            self.active,
            self.corner_start,
            self.corners,
            self.cell_v,
            self.least_force,
            self.right,
            self.stats,
        )
        return float(arrays.get(self.stats)[1])

    def _linearise(self) -> None:
        self.tangent(
            self.shape_gradients,
            self.weights,
            self.cells.reference,
            self.cell_u,
            self.pair_start,
            self.pair_corners,
            self.pair_nodes,
            self.basis,
            self.corner_count,
            *self.lame,
            self.pair_values,
        )
        self.blocks(
            self.row_start, self.entry_start, self.entry_pairs, self.pair_values, self.values, self.inverse, self.stats
        )
        self.stale = False

    def _sweep(self, u: arrays.Array) -> float:
        """Solve for the increment and add it to u; returns the residual of the linearised problem."""
        self.solve(
            self.nodes,
            self.basis,
            self.planes,
            self.near,
            self.reference,
            self.compliance,
            self.row_start,
            self.column,
            self.values,
            self.inverse,
            self.right,
            self.least_sweeps,
            POLISHING_SWEEPS,
            MOST_SWEEPS if self.linear else POLISHING_SWEEPS,
            self.aim,
            self.tolerance,
            u,
            self.increment,
            self.active,
            self.stats,
        )
        return float(arrays.get(self.stats)[1])

    def _explain(self, residual: float) -> str:
        pivot = float(arrays.get(self.stats)[3])
        text = f"the static solve of the contact nodes stopped at a residual of {residual:.3g} (wanted {self.tolerance:.3g})"
        if not pivot > 0.0:
            text += f"; the tangent of the law {self.law} is not positive definite in strong compression"
            if self.law == "st_venant_kirchhoff":
                text += ": StVenantKirchhoff loses ellipticity there, use NeoHookean"
            return text
        return text + "; use removal='normal', a smaller step or a larger tolerance"

    def owned(self) -> list[arrays.Array]:
        return [*super().owned(), *self.cells.owned()]
