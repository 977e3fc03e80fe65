"""The static solve that places the massless contact nodes (METHOD 2): Newton outside, projected Gauss-Seidel inside."""

from __future__ import annotations

import numpy as np

from .. import arrays
from ..contact_models import MasslessContact
from ..launch import Prepared
from ..mesh_geometry import shortest_edge
from ..plan import BodyPlan
from ..sweep_order import sweep_order
from .contact import ContactTerm
from .internal_force import InternalForce
from .surface_cells import SurfaceCells

TOLERANCE = 1e-4  # on the static residual, unless the user sets one
AIM = 1e-8  # the sweeps then go on to here if they can: what is unbalanced is lost to the momentum
LEFT = 1e-8  # what the last use of a tangent may leave of the residual of a nonlinear law
POLISHING_SWEEPS = 60  # at most this many to go below the tolerance, and per linearisation of a nonlinear law
MOST_SWEEPS = 500  # then the solve of a linear law has not converged
LINEARISATIONS = 4  # a nonlinear law has this many times as many
REACH = 0.1  # largest move of a node per linearisation of a nonlinear law, over the shortest edge of the contact cells
RELAXATION = 1.0
LEAST_FORCE = 1e-6  # F_ref is at least this times (lambda + 2 mu) times the mean area weight


class StaticSolve:
    """Brings the massless nodes of a contact term to equilibrium with the rest of the body.

    basis [k, 3, block] and compliance [k] = 1/(kappa A) (0 = exact) are the term's; `active` is the bit mask of the
    planes that hold each node, `stats` and `settings` are numbered in kernels/static_control.py.
    """

    def __init__(
        self,
        plan: BodyPlan,
        model: MasslessContact,
        term: ContactTerm,
        force: InternalForce,
        basis: arrays.Array,
        compliance: arrays.Array,
    ) -> None:
        from ..kernels import static_control, static_solve

        contact, material = plan.contact, plan.body.material
        assert contact is not None
        assert contact.graph is not None
        assert contact.basis is not None
        graph, block = contact.graph, contact.block
        self.term, self.force, self.basis, self.compliance = term, force, basis, compliance
        self.names = static_control
        self.law, self.linear, self.removal = material.law, material.linear, contact.removal
        self.tolerance = TOLERANCE if model.tolerance is None else model.tolerance
        self.cells = SurfaceCells(plan, force, graph, contact.basis, block)
        count, order = len(contact.nodes), sweep_order(graph, block)
        self.row_start = arrays.put(graph.row_start)
        self.entry_start = arrays.put(graph.entry_start)
        self.entry_pairs = arrays.put(graph.entry_pairs)
        self.entry_place = arrays.put(order.entry_place)
        self.corner_start = arrays.put(graph.corner_start)
        self.lane_start = arrays.put(order.lane_start)
        self.lane_node = arrays.put(order.lane_node)
        self.column = arrays.put(order.column)
        self.values = arrays.zeros(order.column.size * block * block)
        self.inverse = arrays.zeros(count * block * block)
        self.stiffness = arrays.zeros(count)
        self.settings = arrays.put(self._settings(plan, model, float(contact.areas.mean()), graph.cells))
        self.right = arrays.zeros(count * block)
        self.gaps = arrays.zeros(count * term.slots)
        self.normals = arrays.zeros(count * term.slots * block)
        self.push = arrays.zeros(count * (block + 1) if term.slots == 1 else 1)
        self.increment = arrays.zeros(count * block)
        self.stats = arrays.zeros(static_control.STATS)
        stats = np.zeros(static_control.STATS)
        stats[[static_control.CONTRACTION, static_control.STALE]] = 1.0
        arrays.set_values(self.stats, stats)
        self.active = arrays.put(np.zeros(count, dtype=np.int32))
        self._equilibrium = Prepared(static_solve.make_equilibrium(block, term.slots))
        self._blocks = Prepared(static_solve.make_blocks(block))
        self.converged = True
        self.message = ""

    def _settings(self, plan: BodyPlan, model: MasslessContact, area: float, cells: np.ndarray) -> np.ndarray:
        material, names = plan.body.material, self.names
        most = MOST_SWEEPS if material.linear else POLISHING_SWEEPS
        stiffness = material.lame_lambda + 2.0 * material.lame_mu
        reach = 1e300 if material.linear else REACH * shortest_edge(plan.reference, plan.cells[cells])
        settings = np.zeros(names.SETTINGS)
        settings[names.LEAST_SWEEPS] = model.sweeps
        settings[names.POLISHING_SWEEPS] = POLISHING_SWEEPS
        settings[names.MOST_SWEEPS] = most
        settings[names.MOST_IN_ALL] = LINEARISATIONS * MOST_SWEEPS
        settings[names.AIM] = AIM if model.tolerance is None else model.tolerance
        settings[names.TOLERANCE] = self.tolerance
        settings[names.LEFT] = LEFT if model.tolerance is None else 0.0
        settings[names.REACH] = reach
        settings[names.LEAST_FORCE] = LEAST_FORCE * stiffness * area
        settings[names.LINEAR] = 1.0 if material.linear else 0.0
        settings[names.RELAXATION] = RELAXATION if model.penalty is None else 1.0
        return settings

    def equilibrate(self, u: arrays.Array, v: arrays.Array) -> None:
        """Move the massless nodes of u to equilibrium; a linear law is done after one linearisation."""
        names, first, fresh = self.names, 1, 0
        while True:
            if not fresh:
                self._measure(u, v)
            step = self._advance(u, first, fresh)
            if step == names.DONE:
                break
            fresh = 1 if step == names.LINEARISE else 0
            if fresh:
                self._linearise(u)
            else:
                first = 0
        residual = self.stat(names.RESIDUAL)
        self.converged = residual <= self._bound() and not self._lost()
        if not self.converged:
            self.message = self._explain(residual)

    def _measure(self, u: arrays.Array, v: arrays.Array) -> None:
        """Corner forces of the contact cells at u."""
        self.force.measure_surface(u, v)

    def _advance(self, u: arrays.Array, first: int, fresh: int) -> float:
        """Judge the measure, or use the fresh tangent; says what has to come next."""
        term = self.term
        self._equilibrium(
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
            self.cells.corner_rows,
            self.force.rows,
            self.lane_start,
            self.lane_node,
            self.column,
            self.values,
            self.inverse,
            self.stiffness,
            self.settings,
            self.right,
            self.gaps,
            self.normals,
            self.push,
            self.increment,
            self.stats,
            first,
            fresh,
        )
        return self.stat(self.names.NEXT)

    def _linearise(self, u: arrays.Array) -> None:
        """K_KK at u."""
        self.cells.linearise(self.basis, u)
        self._blocks(
            self.row_start,
            self.entry_start,
            self.entry_pairs,
            self.entry_place,
            self.cells.pair_values,
            self.values,
            self.inverse,
            self.stiffness,
            self.stats,
        )

    def stat(self, number: int) -> float:
        """One of the numbers in `stats`."""
        return float(arrays.get(self.stats)[number])

    @property
    def sweeps(self) -> int:
        """Sweeps of the last solve."""
        return int(self.stat(self.names.SWEEPS))

    def _lost(self) -> bool:
        """St Venant-Kirchhoff in compression beyond its limit: a node's own tangent is not positive definite."""
        return self.law == "st_venant_kirchhoff" and not self.stat(self.names.PIVOT) > 0.0

    def _bound(self) -> float:
        return max(self.tolerance, self.stat(self.names.ROUNDING))

    def _explain(self, residual: float) -> str:
        pivot = self.stat(self.names.PIVOT)
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
        own = [self.row_start, self.entry_start, self.entry_pairs, self.entry_place, self.corner_start, self.lane_start]
        own += [self.lane_node, self.column, self.values, self.inverse, self.stiffness, self.right, self.gaps]
        return [*own, self.normals, self.push, self.increment, self.active, *self.cells.owned()]
