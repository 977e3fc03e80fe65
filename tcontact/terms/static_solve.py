"""The static solve that places the massless contact nodes (METHOD 2): its system, its settings, its verdict."""

from __future__ import annotations

import numpy as np

from .. import arrays
from ..contact_models import MasslessContact
from ..domain import Domain
from ..elements import shape_functions
from ..kernels.lanes import SWEEP_LANES
from ..kernels.node_places import PLACES
from ..mesh_geometry import shortest_edge
from ..scene import Scene
from ..static_solver import static_solver
from ..sweep_order import sweep_order
from .internal_force import InternalForce

TOLERANCE = 1e-4  # on the static residual, unless the user sets one
AIM = 1e-6  # the sweeps then go on to here if they can
LEFT = 1e-5  # what the last use of a tangent may leave of the residual of a nonlinear law
POLISHING_SWEEPS = 60  # at most this many to go below the tolerance, and per linearisation of a nonlinear law
MOST_SWEEPS = 500  # then the solve of a linear law has not converged
LINEARISATIONS = 4  # a nonlinear law has this many times as many
REACH = 0.1  # largest move of a node per linearisation of a nonlinear law, over the shortest edge of the contact cells
# of a mean dilatation: above it the sweeps, or MPRGP, may not converge with either removal
MOST_POISSON = {False: 0.499, True: 0.4999}
STEP_LENGTH = 1.9  # of a projected step, over the bound of the largest eigenvalue: less than 2
LEAST_FORCE = 1e-6  # F_ref is at least this times (lambda + 2 mu) times the mean area weight


class StaticSolve:
    """Arrays of the solve; `stats` and `settings` are numbered in kernels/static_control.py."""

    def __init__(self, scene: Scene, domain: Domain, force: InternalForce, slots: int) -> None:
        from ..kernels import static_control as names
        from ..kernels.materials import LAWS

        contact, model, body = domain.contact, scene.contact, domain.bodies[0]
        material = body.body.material
        assert isinstance(model, MasslessContact)
        assert contact is not None
        assert contact.graph is not None
        graph, block = contact.graph, contact.block
        self.names = names
        self.law, self.refusal, self.removal = material.law, LAWS[material.law].refusal, contact.removal
        self.friction = 0.0 if scene.friction is None else scene.friction.coefficient
        self.projected = static_solver(scene, body).projected
        self.poisson = material.poisson if body.body.formulation == "mean-dilatation" else 0.0
        self.tolerance = TOLERANCE if model.tolerance is None else model.tolerance
        order = sweep_order(graph, block)
        room = len(contact.nodes) + SWEEP_LANES - 1
        pairs = contact_blocks(domain, force) | {
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
        self.stats = arrays.put(self._start())
        self.system = {
            "lane_start": arrays.put(order.lane_start),
            "pack_start": arrays.put(order.pack_start),
            "column": arrays.put(order.column),
            "values": arrays.zeros(order.column.size * block * block),
            "inverse": arrays.zeros(room * block * block),
            "stiffness": arrays.zeros(room),
            "right": arrays.zeros(room * block),
            "gaps": arrays.zeros(room * slots),
            "normals": arrays.zeros(room * slots * block),
            "push": arrays.zeros(room * (PLACES[block].end if self.projected else block + 1)),
            "increment": arrays.zeros(3 * room * block),
            "settings": arrays.put(self._settings(scene, domain, model)),
            "stats": self.stats,
        }

    def _start(self) -> np.ndarray:
        stats = np.zeros(self.names.STATS)
        stats[[self.names.CONTRACTION, self.names.STALE, self.names.CONVERGED]] = 1.0
        return stats

    def _settings(self, scene: Scene, domain: Domain, model: MasslessContact) -> np.ndarray:
        body, names = domain.bodies[0], self.names
        material = body.body.material
        assert domain.contact is not None
        assert domain.contact.graph is not None
        linear = material.linear and all(obstacle.shape == "plane" for obstacle in scene.obstacles)
        stiffness = material.lame_lambda + 2.0 * material.lame_mu
        settings = np.zeros(names.SETTINGS)
        settings[names.LEAST_SWEEPS] = model.sweeps
        settings[names.POLISHING_SWEEPS] = POLISHING_SWEEPS
        settings[names.MOST_SWEEPS] = MOST_SWEEPS if linear else POLISHING_SWEEPS
        if self.projected:  # it notices an indefinite tangent by itself
            settings[names.MOST_SWEEPS] = LINEARISATIONS * MOST_SWEEPS
        settings[names.MOST_IN_ALL] = LINEARISATIONS * MOST_SWEEPS
        settings[names.AIM] = AIM if model.tolerance is None else model.tolerance
        settings[names.TOLERANCE] = self.tolerance
        settings[names.LEFT] = LEFT if model.tolerance is None else 0.0
        settings[names.REACH] = 1e300
        if not linear:
            settings[names.REACH] = REACH * min(
                shortest_edge(domain.reference, block.contact_cells) for block in domain.blocks if len(block.contact)
            )
        settings[names.LEAST_FORCE] = LEAST_FORCE * stiffness * float(domain.contact.areas.mean())
        settings[names.LINEAR] = 1.0 if linear else 0.0
        settings[names.STEP_LENGTH] = STEP_LENGTH / domain.contact.graph.corners_together
        exact = model.penalty is None and scene.friction is None and self.removal == "full"
        settings[names.RELAXATION] = body.body.mesh.element.relaxation if exact else 1.0
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
        most = MOST_POISSON[self.projected]
        if self.poisson > most:
            text += f"; poisson {self.poisson:.6g} makes it ill-conditioned: use at most {most:g},"
            return text + " or an implicit scheme, which solves for all nodes together, such as tc.DiscreteGradient()"
        removal = "" if self.removal == "normal" else "removal='normal', "
        if self.friction > 1.0 and removal:
            removal += "a friction coefficient of at most 1 (there may be several solutions above it), "
        return text + f"; use {removal}cells of more even shape at the contact, a smaller step or a larger tolerance"

    def owned(self) -> list[arrays.Array]:
        """Arrays of the solve."""
        return [*self.pairs.values(), *self.system.values()]


def contact_blocks(domain: Domain, force: InternalForce) -> dict[str, np.ndarray]:
    """The contact cells block by block, as in kernels/bundles.Pairs: their nodes and the data of their points."""
    blocks, nodes, gradients, weights = [], [np.zeros(0, dtype=np.int64)], [np.zeros((0, 3))], [np.zeros(0)]
    for number, block in enumerate(domain.blocks):
        if len(block.contact):
            _values, slopes, own = shape_functions(block.body.body.mesh.kind)
            starts = [sum(part.size for part in parts) for parts in (nodes, weights)]
            blocks.append(
                (
                    block.contact[0],
                    block.contact[-1] + 1,
                    starts[0],
                    sum(map(len, gradients)),
                    starts[1],
                    len(own),
                    force.material_at[number],
                    force.packs.contact_memory[number],
                    domain.kinds.index(block.kind),
                )
            )
            nodes.append(block.contact_cells.reshape(-1))
            gradients.append(slopes.reshape(-1, 3))
            weights.append(own)
    return {
        "blocks": np.array(blocks),
        "cell_nodes": np.concatenate(nodes),
        "shape_gradients": np.concatenate(gradients),
        "weights": np.concatenate(weights),
    }
