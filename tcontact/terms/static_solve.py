"""The static solve that places the massless contact nodes (METHOD 2): Newton outside, projected Gauss-Seidel inside."""

from __future__ import annotations

import numpy as np

from .. import arrays
from ..contact_models import MasslessContact
from ..launch import Prepared
from ..mesh_geometry import shortest_edge
from ..plan import BodyPlan
from .contact import ContactTerm
from .surface_cells import SurfaceCells

TOLERANCE = 1e-4  # on the static residual, unless the user sets one
AIM = 1e-8  # the sweeps then go on to here if they can: what is unbalanced is lost to the momentum
LEFT = 1e-8  # what the last use of a tangent may leave of the residual of a nonlinear law
USED_UP = 0.05  # a tangent that leaves more than this share of a residual is renewed
SLOW = 0.5  # a linearisation that leaves more than this share of a residual below the tolerance is the last one
MORE_SWEEPS = 5  # at least this many in the further linearisations of a step
POLISHING_SWEEPS = 60  # at most this many to go below the tolerance, and per linearisation of a nonlinear law
MOST_SWEEPS = 500  # then the solve of a linear law has not converged
LINEARISATIONS = 4  # a nonlinear law has this many times as many
REACH = 0.1  # largest move of a node per linearisation of a nonlinear law, over the shortest edge of the contact cells
LEAST_FORCE = 1e-6  # F_ref is at least this times (lambda + 2 mu) times the mean area weight


class StaticSolve:
    """Brings the massless nodes of a contact term to equilibrium with the rest of the body.

    basis [k, 3, block] and compliance [k] = 1/(kappa A) (0 = exact) are the term's; `active` is the bit mask of the
    planes that hold each node, `stats` what kernels/static_solve.py says.
    """

    def __init__(
        self,
        plan: BodyPlan,
        model: MasslessContact,
        term: ContactTerm,
        basis: arrays.Array,
        compliance: arrays.Array,
    ) -> None:
        from ..kernels import static_solve

        contact, material = plan.contact, plan.body.material
        assert contact is not None
        assert contact.graph is not None
        assert contact.basis is not None
        graph, block = contact.graph, contact.block
        self.term, self.basis, self.compliance = term, basis, compliance
        self.law, self.linear, self.removal = material.law, material.linear, contact.removal
        self.least_sweeps = model.sweeps
        self.tolerance = TOLERANCE if model.tolerance is None else model.tolerance
        self.aim = AIM if model.tolerance is None else model.tolerance
        self.left = LEFT if model.tolerance is None else 0.0
        stiffness = material.lame_lambda + 2.0 * material.lame_mu
        self.least_force = LEAST_FORCE * stiffness * float(contact.areas.mean())
        self.reach = 1e300 if material.linear else REACH * shortest_edge(plan.reference, plan.cells[graph.cells])
        self.cells = SurfaceCells(plan, graph, contact.basis, block)

        count = len(contact.nodes)
        self.row_start = arrays.put(graph.row_start)
        self.column = arrays.put(graph.column)
        self.entry_start = arrays.put(graph.entry_start)
        self.entry_pairs = arrays.put(graph.entry_pairs)
        self.corner_start = arrays.put(graph.corner_start)
        self.corners = arrays.put(graph.corners)
        self.active = arrays.put(np.zeros(count, dtype=np.int32))
        self.right = arrays.zeros(count * block)
        self.increment = arrays.zeros(count * block)
        self.values = arrays.zeros(len(graph.column) * block * block)
        self.inverse = arrays.zeros(count * block * block)
        self.stats = arrays.zeros(8)
        self._assemble = Prepared(static_solve.make_assemble(block, term.slots))
        self._blocks = Prepared(static_solve.make_blocks(block))
        self._solve = Prepared(static_solve.make_solve(block, term.slots))
        self.stale = True  # no tangent yet, or one that has lost its use
        self.sweeps = 0
        self.converged = True
        self.message = ""

    def equilibrate(self, u: arrays.Array) -> None:
        """Move the massless nodes of u to equilibrium; a linear law is done after one linearisation.

        Other laws are measured again at the new state. A tangent is kept, from step to step too, while each use of it
        makes the residual much smaller; once the next use would leave too little to matter, that use is the last.
        Where K_KK is not definite (buckling under strong compression) progress is slow: below the tolerance it is
        enough then, above it each few sweeps get their own linearisation and go down in energy.
        """
        stats = arrays.get(self.stats)
        stats[2] = 0.0
        arrays.set_values(self.stats, stats)
        residual = self._measure(u)
        sweeps = self.least_sweeps
        while True:
            if self.stale:
                self._linearise()
            before, residual = residual, self._sweep(u, sweeps)
            sweeps = min(sweeps, MORE_SWEEPS)
            if self.linear:
                break
            residual = self._measure(u)
            contraction = min(1.0, residual / max(before, self.aim))
            self.stale = contraction > USED_UP
            if residual <= self._bound():
                enough = residual <= max(self.aim, self._rounding())
                if enough or contraction * residual <= self.left or (contraction > SLOW and self.left > 0.0):
                    if residual > self.aim:
                        self._sweep(u, sweeps)
                    break
            if not np.isfinite(residual) or self._swept() >= LINEARISATIONS * MOST_SWEEPS:
                break
        self.converged = residual <= self._bound() and not self._lost()
        self.sweeps = self._swept()
        if not self.converged:
            self.message = self._explain(residual)

    def _measure(self, u: arrays.Array) -> float:
        """Out-of-balance forces at u; returns the static residual for the active set of the last sweep."""
        self.cells.measure(u)
        term = self.term
        self._assemble(
            term.nodes,
            self.basis,
            term.planes,
            term.near,
            term.reference,
            u,
            term.listed.load,
            self.compliance,
            self.active,
            self.corner_start,
            self.corners,
            self.cells.minus_force,
            self.least_force,
            self.right,
            self.stats,
        )
        return float(arrays.get(self.stats)[1])

    def _linearise(self) -> None:
        """K_KK at the displacement of the last measure."""
        self.cells.linearise(self.basis)
        self._blocks(
            self.row_start,
            self.entry_start,
            self.entry_pairs,
            self.cells.pair_values,
            self.values,
            self.inverse,
            self.stats,
        )
        self.stale = False

    def _sweep(self, u: arrays.Array, sweeps: int) -> float:
        """Solve for the increment and add it to u; returns the residual of the linearised problem."""
        term = self.term
        self._solve(
            term.nodes,
            self.basis,
            term.planes,
            term.near,
            term.reference,
            self.compliance,
            self.row_start,
            self.column,
            self.values,
            self.inverse,
            self.right,
            sweeps,
            POLISHING_SWEEPS,
            MOST_SWEEPS if self.linear else POLISHING_SWEEPS,
            self.aim,
            self.tolerance,
            self.reach,
            u,
            self.increment,
            self.active,
            self.stats,
        )
        return float(arrays.get(self.stats)[1])

    def _lost(self) -> bool:
        """St Venant-Kirchhoff in compression beyond its limit: a node's own tangent is not positive definite."""
        return self.law == "st_venant_kirchhoff" and not float(arrays.get(self.stats)[3]) > 0.0

    def _swept(self) -> int:
        return int(arrays.get(self.stats)[2])

    def _rounding(self) -> float:
        return float(arrays.get(self.stats)[5])

    def _bound(self) -> float:
        return max(self.tolerance, self._rounding())

    def _explain(self, residual: float) -> str:
        pivot = float(arrays.get(self.stats)[3])
        text = "the static solve of the contact nodes stopped at a residual of"
        text += f" {residual:.3g} (wanted {self.tolerance:.3g})"
        if not pivot > 0.0:
            text += f"; the tangent of the law {self.law} is not positive definite in strong compression"
            if self.law == "st_venant_kirchhoff":
                text += ": StVenantKirchhoff loses ellipticity there, use NeoHookean"
            return text
        removal = "" if self.removal == "normal" else "removal='normal', "
        return text + f"; use {removal}cells of more even shape at the contact, a smaller step or a larger tolerance"

    def owned(self) -> list[arrays.Array]:
        """Arrays of the solve."""
        own = [self.row_start, self.column, self.entry_start, self.entry_pairs, self.corner_start, self.corners]
        return [*own, self.active, self.right, self.increment, self.values, self.inverse, *self.cells.owned()]
