"""The static solve that places the massless contact nodes (METHOD 2): its system, its settings, its verdict."""

from __future__ import annotations

import numpy as np

from .. import arrays
from ..contact_models import MasslessContact
from ..elements import shape_functions
from ..kernels.lanes import SWEEP_LANES
from ..mesh_geometry import shortest_edge
from ..plan import BodyPlan
from ..scene import Scene
from ..sweep_order import sweep_order
from .cell_viscosity import corner_lists
from .internal_force import InternalForce

TOLERANCE = 1e-4  # on the static residual, unless the user sets one
AIM = 1e-6  # the sweeps then go on to here if they can
LEFT = 1e-5  # what the last use of a tangent may leave of the residual of a nonlinear law
POLISHING_SWEEPS = 60  # at most this many to go below the tolerance, and per linearisation of a nonlinear law
MOST_SWEEPS = 500  # then the solve of a linear law has not converged
LINEARISATIONS = 4  # a nonlinear law has this many times as many
REACH = 0.1  # largest move of a node per linearisation of a nonlinear law, over the shortest edge of the contact cells
MOST_POISSON = 0.499  # of a mean dilatation: above it the sweeps may not converge with either removal
LEAST_FORCE = 1e-6  # F_ref is at least this times (lambda + 2 mu) times the mean area weight


class StaticSolve:
    """Arrays of the solve; `stats` and `settings` are numbered in kernels/static_control.py."""

    def __init__(self, scene: Scene, plan: BodyPlan, force: InternalForce, slots: int) -> None:
        from ..kernels import static_control as names
        from ..kernels.materials import LAWS

        contact, material, model = plan.contact, plan.body.material, scene.contact
        assert isinstance(model, MasslessContact)
        assert contact is not None
        assert contact.graph is not None
        assert force.surface is not None
        graph, block = contact.graph, contact.block
        self.names = names
        self.law, self.refusal, self.removal = material.law, LAWS[material.law].refusal, contact.removal
        self.friction = 0.0 if scene.friction is None else scene.friction.coefficient
        self.poisson = material.poisson if plan.body.formulation == "mean-dilatation" else 0.0
        self.tolerance = TOLERANCE if model.tolerance is None else model.tolerance
        order = sweep_order(graph, block)
        room = len(contact.nodes) + SWEEP_LANES - 1
        cells = plan.cells[graph.cells]
        _values, gradients, weights = shape_functions(plan.body.mesh.kind)
        pairs = {
            "cell_nodes": cells.reshape(-1),
            "shape_gradients": gradients,
            "weights": weights,
            "start": graph.pair_start,
            "corners": graph.pair_corners,
            "nodes": graph.pair_nodes,
            "values": np.zeros(len(graph.pair_nodes) * block * block),
            "row_start": graph.row_start,
            "entry_start": graph.entry_start,
            "entry_pairs": graph.entry_pairs,
            "entry_place": order.entry_place,
        }
        self.pairs = {name: arrays.put(values) for name, values in pairs.items()}
        width = cells.shape[1]
        start, corners = graph.corner_start, force.surface.rows(graph.corners // width, graph.corners % width)
        if plan.viscous_cells:
            start, corners = corner_lists(plan, force.surface)
        self.stats = arrays.put(self._start())
        self.system = {
            "corner_rows": arrays.put(np.concatenate([start + len(start), corners])),
            "lane_start": arrays.put(order.lane_start),
            "pack_start": arrays.put(order.pack_start),
            "column": arrays.put(order.column),
            "values": arrays.zeros(order.column.size * block * block),
            "inverse": arrays.zeros(room * block * block),
            "stiffness": arrays.zeros(room),
            "right": arrays.zeros(room * block),
            "gaps": arrays.zeros(room * slots),
            "normals": arrays.zeros(room * slots * block),
            "push": arrays.zeros(room * (block + 1)),
            "increment": arrays.zeros(3 * room * block),
            "settings": arrays.put(self._settings(scene, plan, model, graph.cells)),
            "stats": self.stats,
        }

    def _start(self) -> np.ndarray:
        stats = np.zeros(self.names.STATS)
        stats[[self.names.CONTRACTION, self.names.STALE, self.names.CONVERGED]] = 1.0
        return stats

    def _settings(self, scene: Scene, plan: BodyPlan, model: MasslessContact, cells: np.ndarray) -> np.ndarray:
        material, names = plan.body.material, self.names
        assert plan.contact is not None
        linear = material.linear and all(obstacle.shape == "plane" for obstacle in scene.obstacles)
        stiffness = material.lame_lambda + 2.0 * material.lame_mu
        settings = np.zeros(names.SETTINGS)
        settings[names.LEAST_SWEEPS] = model.sweeps
        settings[names.POLISHING_SWEEPS] = POLISHING_SWEEPS
        settings[names.MOST_SWEEPS] = MOST_SWEEPS if linear else POLISHING_SWEEPS
        settings[names.MOST_IN_ALL] = LINEARISATIONS * MOST_SWEEPS
        settings[names.AIM] = AIM if model.tolerance is None else model.tolerance
        settings[names.TOLERANCE] = self.tolerance
        settings[names.LEFT] = LEFT if model.tolerance is None else 0.0
        settings[names.REACH] = 1e300
        if not linear:
            settings[names.REACH] = REACH * shortest_edge(plan.reference, plan.cells[cells])
        settings[names.LEAST_FORCE] = LEAST_FORCE * stiffness * float(plan.contact.areas.mean())
        settings[names.LINEAR] = 1.0 if linear else 0.0
        exact = model.penalty is None and scene.friction is None and self.removal == "full"
        settings[names.RELAXATION] = plan.body.mesh.element.relaxation if exact else 1.0
        return settings

    def _stat(self, number: int) -> float:
        return float(arrays.get(self.stats)[number])

    @property
    def trouble(self) -> str | None:
        """Why the last solve did not converge; None if it did."""
        if self._stat(self.names.CONVERGED) == 1.0:
            return None
        residual = self._stat(self.names.RESIDUAL)
        text = "the static solve of the contact nodes stopped at a residual of"
        text += f" {residual:.3g} (wanted {self.tolerance:.3g})"
        if not self._stat(self.names.PIVOT) > 0.0:
            text += f"; the tangent of the law {self.law} is not positive definite in strong compression"
            return f"{text}: {self.refusal}" if self.refusal else text
        if self.poisson > MOST_POISSON:
            text += f"; poisson {self.poisson:.5g} makes it ill-conditioned: use at most {MOST_POISSON:g},"
            return text + " or an implicit scheme, which solves for all nodes together, such as tc.DiscreteGradient()"
        removal = "" if self.removal == "normal" else "removal='normal', "
        if self.friction > 1.0 and removal:
            removal += "a friction coefficient of at most 1 (there may be several solutions above it), "
        return text + f"; use {removal}cells of more even shape at the contact, a smaller step or a larger tolerance"

    def owned(self) -> list[arrays.Array]:
        """Arrays of the solve."""
        return [*self.pairs.values(), *self.system.values()]
