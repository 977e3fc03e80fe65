"""Islands: the contact nodes of a body, or of bodies in contact, in shared lists (kernels/contact/islands.py)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..kernels.lanes import ISLAND, MAXIMUM_SLOTS
from .body_plan import BodyPlan
from .domain import Domain
from .sweep_order import SweepOrder


@dataclass(frozen=True)
class Island:
    """The part of one body, or of several that are in contact with each other, in the contact lists of the domain.

    nodes, all_nodes: its slices of `ContactPlan.nodes` and `ContactPlan.all_nodes`; blocks: of the blocks of contact
    cells.
    """

    bodies: tuple[BodyPlan, ...]
    nodes: slice
    all_nodes: slice
    blocks: slice

    @property
    def removal(self) -> str | None:
        """The mass removed from its nodes: "normal", "full" or None."""
        return None if self.body.contact is None else self.body.contact.removal

    @property
    def body(self) -> BodyPlan:
        """Its body, or the first one of several."""
        return self.bodies[0]

    @property
    def coupled(self) -> bool:
        """Return whether its bodies are in contact with each other."""
        return len(self.bodies) > 1


def islands_of(domain: Domain) -> tuple[Island, ...]:
    """Return the islands of a domain: one for each body that can touch, or one for all bodies that pairs connect."""
    found: list[Island] = []
    everyone, blocks = 0, 0
    for number, body in enumerate(domain.bodies):
        if body.contact is not None:
            own = sum(len(block.contact) > 0 for block in domain.blocks if block.body is body)
            found.append(
                Island(
                    (body,),
                    slice(int(domain.contact_start[number]), int(domain.contact_start[number + 1])),
                    slice(everyone, everyone + len(body.contact.all_nodes)),
                    slice(blocks, blocks + own),
                )
            )
            everyone += len(body.contact.all_nodes)
            blocks += own
    return (_joined(found),) if domain.pairs else tuple(found)


def _joined(islands: Sequence[Island]) -> Island:
    names = ("nodes", "all_nodes", "blocks")
    parts = [slice(getattr(islands[0], name).start, getattr(islands[-1], name).stop) for name in names]
    return Island(tuple(body for island in islands for body in island.bodies), *parts)


def nodes_without_rows(domain: Domain, islands: Sequence[Island], obstacles: int) -> list[np.ndarray]:
    """Return per island the contact nodes whose smallest gap stands in no row: all, if rows leave obstacles out."""
    contact = domain.contact
    assert contact is not None
    known = contact.nodes if obstacles <= MAXIMUM_SLOTS else contact.nodes[:0]
    return [np.setdiff1d(contact.all_nodes[island.all_nodes], known) for island in islands]


def island_starts(islands: Sequence[Island], others: Sequence[np.ndarray], order: SweepOrder | None) -> np.ndarray:
    """Return where every island begins and the last one ends [i+1, ISLAND], as kernels/contact/islands.py reads it.

    others: nodes without rows of each island; order: order of the sweeps, None without a static solve.
    """
    starts = np.zeros((len(islands) + 1, ISLAND), dtype=np.int64)
    starts[1:, 0] = [island.nodes.stop for island in islands]
    starts[:, 2] = starts[-1, 0] + np.cumsum([0, *(len(nodes) for nodes in others)])
    starts[1:, 3] = [island.blocks.stop for island in islands]
    if order is not None:
        starts[:, 1] = np.searchsorted(order.pack_start, starts[:, 0])
    return starts
