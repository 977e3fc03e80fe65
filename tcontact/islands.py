"""Islands of contact: the contact nodes of one body in lists that several bodies share (kernels/islands.py)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .kernels.lanes import ISLAND, MOST_SLOTS

if TYPE_CHECKING:
    from .materials import Material
    from .plan import BodyPlan
    from .sweep_order import SweepOrder


@dataclass(frozen=True)
class Island:
    """The share of one body in the lists of contact, and what its static solve is set by.

    label: of the body; kind of its cells and formulation, as `Mesh.kind` and `Body.formulation`; removal: "normal",
    "full" or None; nodes, all_nodes, cells: its slices of `ContactPlan.nodes`, `ContactPlan.all_nodes` and
    `ContactGraph.cells`.
    """

    label: str
    material: Material
    kind: str
    formulation: str
    removal: str | None
    nodes: slice
    all_nodes: slice
    cells: slice


def islands_of(plan: BodyPlan) -> tuple[Island, ...]:
    """The islands of a plan: one, of its body."""
    contact, body = plan.contact, plan.body
    assert contact is not None
    cells = 0 if contact.graph is None else len(contact.graph.cells)
    nodes, all_nodes = slice(0, len(contact.nodes)), slice(0, len(contact.all_nodes))
    kind, removal = body.mesh.kind, contact.removal
    return (Island(plan.label, body.material, kind, body.formulation, removal, nodes, all_nodes, slice(0, cells)),)


def nodes_without_rows(plan: BodyPlan, islands: Sequence[Island], obstacles: int) -> list[np.ndarray]:
    """Per island the nodes of its contact set whose smallest gap no row knows: all where rows leave obstacles out."""
    contact = plan.contact
    assert contact is not None
    known = contact.nodes if obstacles <= MOST_SLOTS else contact.nodes[:0]
    return [np.setdiff1d(contact.all_nodes[island.all_nodes], known) for island in islands]


def island_starts(islands: Sequence[Island], others: Sequence[np.ndarray], order: SweepOrder | None) -> np.ndarray:
    """Where every island begins [i+1, ISLAND] and the last one ends, as `kernels/islands.py` reads it.

    others: per island its nodes without rows; order: of the sweeps, None without a static solve.
    """
    starts = np.zeros((len(islands) + 1, ISLAND), dtype=np.int64)
    starts[1:, 0] = [island.nodes.stop for island in islands]
    starts[1:, 2] = [island.cells.stop for island in islands]
    starts[:, 3] = starts[-1, 0] + np.cumsum([0, *(len(nodes) for nodes in others)])
    if order is not None:
        starts[:, 1] = np.searchsorted(order.pack_start, starts[:, 0])
    return starts
