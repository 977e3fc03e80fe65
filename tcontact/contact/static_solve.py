"""The static solve that places the massless contact nodes (METHOD 2): its system, its result."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..cells.internal_force import InternalForce
from ..device import arrays
from ..kernels.lanes import SWEEP_LANES, WIDTH
from ..planning.body_plan import BodyPlan
from ..planning.domain import Domain
from ..planning.islands import Island
from ..planning.static_solver import MAXIMUM_POISSON, projected, response_components
from ..planning.sweep_order import SweepOrder
from ..scene.scene import Scene
from .solve_settings import solve_settings, tolerance_of


class StaticSolve:
    """Arrays of the static solve of a domain; order: of the sweeps; slots: constraint rows of a node.

    pairs: stiffness between pairs of contact nodes [N/m] and its assembly, by the names of `Pairs` in
    kernels/language/solve_bundles.py; system: the linear problem K d = right + lambda nu for the increments d [m] of
    the massless components, right [N], K [N/m], gaps [m], by the names of `System` there. ghosts: number of contact
    nodes of other ranks that stand behind those of this one. Of each island: settings [islands, SETTINGS]
    (solve_settings.py) and stats [islands, STATS] in the order of kernels/static/control.py.
    """

    def __init__(
        self,
        scene: Scene,
        domain: Domain,
        force: InternalForce,
        order: SweepOrder,
        islands: Sequence[Island],
        slots: int,
        ghosts: int = 0,
    ) -> None:
        from ..kernels.static import control as names

        contact = domain.contact
        assert contact is not None
        assert contact.graph is not None
        graph, block = contact.graph, contact.block
        self.names = names
        self.islands = islands
        self.friction = scene.largest_friction
        self.tolerance = tolerance_of(scene)
        self.coupled = bool(domain.pairs)
        self.projected = projected(scene, domain.bodies) if domain.settings is None else domain.projected
        components = response_components(scene, block, slots, self.coupled, self.projected)
        room = len(contact.nodes) + ghosts + SWEEP_LANES - 1
        settings = solve_settings(scene, domain, islands) if domain.settings is None else domain.settings
        pairs = contact_blocks(domain, force) | {
            "start": graph.pair_start,
            "corners": graph.pair_corners,
            "nodes": graph.pair_nodes,
            "values": np.zeros(len(graph.pair_nodes) * block * block),
            "row_start": graph.row_start,
            "entries": np.column_stack([graph.entry_start, np.append(order.entry_place, 0)]),
            "entry_pairs": graph.entry_pairs,
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
            "response": arrays.zeros(room * components),
            "increment": arrays.zeros(3 * room * block),
            "settings": arrays.put(settings),
            "stats": self.stats,
        }

    def _start(self) -> np.ndarray:
        stats = np.zeros((len(self.islands), self.names.STATS))
        stats[:, [self.names.CONTRACTION, self.names.STALE, self.names.CONVERGED]] = 1.0
        return stats

    @property
    def trouble(self) -> tuple[BodyPlan, str] | None:
        """The first body whose last solve did not converge, and the reason; None if all did."""
        stats = arrays.get(self.stats).reshape(-1, self.names.STATS)
        wrong = np.flatnonzero(stats[:, self.names.CONVERGED] != 1.0)
        if not len(wrong):
            return None
        island = self.islands[wrong[0]]
        return island.body, self._reason(island, stats[wrong[0]])

    def _reason(self, island: Island, numbers: np.ndarray) -> str:
        """Return why the solve of an island with these numbers [STATS] did not converge, and what to try."""
        own = [block.own for block in island.body.contact_blocks]
        text = "the static solve of the contact nodes stopped at a residual of"
        text += f" {numbers[self.names.RESIDUAL]:.3g} (wanted {self.tolerance:.3g})"
        if not numbers[self.names.PIVOT] > 0.0:
            from ..kernels.materials import LAWS

            laws = dict.fromkeys(block.material.law for block in own)
            text += f"; the tangent of the law {' or '.join(laws)} is not positive definite in strong compression"
            refusal = next((LAWS[law].refusal for law in laws if LAWS[law].refusal), "")
            return f"{text}: {refusal}" if refusal else text
        limit = MAXIMUM_POISSON[self.projected]
        poisson = max((block.material.poisson for block in own if block.formulation == "mean-dilatation"), default=0.0)
        if poisson > limit:
            text += f"; poisson {poisson:.6g} makes it ill-conditioned: use at most {limit:g},"
            return text + " or an implicit scheme, which solves for all nodes together, such as tc.Gonzalez()"
        removal = "" if island.removal == "normal" else "removal='normal', "
        if self.friction > 1.0 and removal:
            removal += "a friction coefficient of at most 1 (there may be several solutions above it), "
        return text + f"; use {removal}cells of more even shape at the contact, a smaller step or a larger tolerance"

    def owned(self) -> list[arrays.Array]:
        """Return the arrays of the solve."""
        return [*self.pairs.values(), *self.system.values()]


def contact_blocks(domain: Domain, force: InternalForce) -> dict[str, np.ndarray]:
    """Return the contact cells by block, see `Pairs` in kernels/language/solve_bundles.py: nodes, quadrature."""
    lane = 0
    blocks, nodes, gradients, weights = [], [np.zeros(0, dtype=np.int64)], [np.zeros((0, 3))], [np.zeros(0)]
    for number, block in enumerate(domain.blocks):
        if len(block.contact):
            _values, slopes, own = block.facts.rule
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
                    force.packs.memory_places[len(domain.blocks) + number],
                    domain.kinds.index(block.kind),
                    lane,
                )
            )
            lane += -(-len(block.contact) // WIDTH) * WIDTH
            nodes.append(block.contact_cells.reshape(-1))
            gradients.append(slopes.reshape(-1, 3))
            weights.append(own)
    behind = sum(part.size for part in gradients)
    return {
        "blocks": np.array([(*one[:4], behind + one[4], *one[5:]) for one in blocks]),
        "cell_nodes": np.concatenate(nodes),
        "shape_gradients": np.concatenate([*(part.reshape(-1) for part in gradients), *weights]),
    }
