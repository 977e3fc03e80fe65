"""The static solve that places the massless contact nodes (METHOD 2): its system, its settings, its verdict."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .. import arrays
from ..contact_models import MasslessContact
from ..islands import Island
from ..kernels.lanes import SWEEP_LANES
from ..lumped_mass import shape_functions
from ..mesh_geometry import shortest_edge
from ..plan import BodyPlan
from ..scene import Scene
from ..sweep_order import SweepOrder
from .cell_viscosity import corner_lists
from .internal_force import InternalForce

TOLERANCE = 1e-4  # on the static residual, unless the user sets one
AIM = 1e-6  # the sweeps then go on to here if they can
LEFT = 1e-5  # what the last use of a tangent may leave of the residual of a nonlinear law
POLISHING_SWEEPS = 60  # at most this many to go below the tolerance, and per linearisation of a nonlinear law
MOST_SWEEPS = 500  # then the solve of a linear law has not converged
LINEARISATIONS = 4  # a nonlinear law has this many times as many
REACH = 0.1  # largest move of a node per linearisation of a nonlinear law, over the shortest edge of the contact cells
RELAXATION = {("hex8", "full"): 1.1, ("tet4", "full"): 1.3}  # measured best at nu = .3; else 1
MOST_POISSON = 0.499  # of a mean dilatation: above it the sweeps may not converge with either removal
LEAST_FORCE = 1e-6  # F_ref is at least this times (lambda + 2 mu) times the mean area weight


class StaticSolve:
    """Arrays of the solve; `stats` [islands, STATS] and `settings` are numbered in kernels/static_control.py."""

    def __init__(
        self,
        scene: Scene,
        plan: BodyPlan,
        force: InternalForce,
        order: SweepOrder,
        islands: Sequence[Island],
        slots: int,
    ) -> None:
        from ..kernels import static_control as names

        contact, model = plan.contact, scene.contact
        assert isinstance(model, MasslessContact)
        assert contact is not None
        assert contact.graph is not None
        assert force.surface is not None
        graph, block = contact.graph, contact.block
        self.names = names
        self.islands = islands
        self.friction = 0.0 if scene.friction is None else scene.friction.coefficient
        self.tolerance = TOLERANCE if model.tolerance is None else model.tolerance
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
            "response": arrays.zeros(room * (block + 1)),
            "increment": arrays.zeros(3 * room * block),
            "settings": arrays.put(np.stack([self._settings(scene, plan, island) for island in islands])),
            "stats": self.stats,
        }

    def _start(self) -> np.ndarray:
        stats = np.zeros((len(self.islands), self.names.STATS))
        stats[:, [self.names.CONTRACTION, self.names.STALE, self.names.CONVERGED]] = 1.0
        return stats

    def _settings(self, scene: Scene, plan: BodyPlan, island: Island) -> np.ndarray:
        contact, model, material, names = plan.contact, scene.contact, island.material, self.names
        assert isinstance(model, MasslessContact)
        assert contact is not None
        assert contact.graph is not None
        linear = material.linear and all(obstacle.shape == "plane" for obstacle in scene.obstacles)
        stiffness = material.lame_lambda + 2.0 * material.lame_mu
        settings = np.zeros(names.SETTINGS)
        settings[names.MINIMUM_SWEEPS] = model.sweeps
        settings[names.POLISHING_SWEEPS] = POLISHING_SWEEPS
        settings[names.MAXIMUM_SWEEPS] = MOST_SWEEPS if linear else POLISHING_SWEEPS
        settings[names.MAXIMUM_IN_ALL] = LINEARISATIONS * MOST_SWEEPS
        settings[names.AIM] = AIM if model.tolerance is None else model.tolerance
        settings[names.TOLERANCE] = self.tolerance
        settings[names.LEFT] = LEFT if model.tolerance is None else 0.0
        settings[names.REACH] = 1e300
        if not linear:
            cells = plan.cells[contact.graph.cells[island.cells]]
            settings[names.REACH] = REACH * shortest_edge(plan.reference, cells)
        settings[names.MINIMUM_FORCE] = LEAST_FORCE * stiffness * float(contact.areas[island.nodes].mean())
        settings[names.LINEAR] = 1.0 if linear else 0.0
        settings[names.RELAXATION] = 1.0
        if model.penalty is None and scene.friction is None:
            settings[names.RELAXATION] = RELAXATION.get((island.kind, str(island.removal)), 1.0)
        return settings

    @property
    def trouble(self) -> str | None:
        """Why the last solve did not converge; None if it did. With several islands the first one in trouble."""
        stats = arrays.get(self.stats).reshape(-1, self.names.STATS)
        wrong = np.flatnonzero(stats[:, self.names.CONVERGED] != 1.0)
        if not len(wrong):
            return None
        island, numbers = self.islands[wrong[0]], stats[wrong[0]]
        whose = "" if len(self.islands) == 1 else f" of {island.label}"
        text = f"the static solve of the contact nodes{whose} stopped at a residual of"
        text += f" {numbers[self.names.RESIDUAL]:.3g} (wanted {self.tolerance:.3g})"
        if not numbers[self.names.PIVOT] > 0.0:
            text += f"; the tangent of the law {island.material.law} is not positive definite in strong compression"
            if island.material.law == "st_venant_kirchhoff":
                text += ": StVenantKirchhoff loses ellipticity there, use NeoHookean"
            return text
        poisson = island.material.poisson if island.formulation == "mean-dilatation" else 0.0
        if poisson > MOST_POISSON:
            text += f"; poisson {poisson:.5g} makes it ill-conditioned: use at most {MOST_POISSON:g},"
            return text + " or an implicit scheme, which solves for all nodes together, such as tc.DiscreteGradient()"
        removal = "" if island.removal == "normal" else "removal='normal', "
        if self.friction > 1.0 and removal:
            removal += "a friction coefficient of at most 1 (there may be several solutions above it), "
        return text + f"; use {removal}cells of more even shape at the contact, a smaller step or a larger tolerance"

    def owned(self) -> list[arrays.Array]:
        """Arrays of the solve."""
        return [*self.pairs.values(), *self.system.values()]
