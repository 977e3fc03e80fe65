"""How the ranks of a checkpoint had cut a domain, for a run that goes on with another number of them."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..planning.domain import Domain
from ..planning.partition.domain_part import DomainPart, cut_domain, domain_parts


class Cut:
    """A domain as some ranks have it.

    ranks: their number, 1 for a run on one process; contact: number of those that share its contact (`cut_domain`).
    """

    def __init__(self, domain: Domain, scene: Any, ranks: int, contact: int | None = None) -> None:
        self.domain, self.parts = domain, list[DomainPart]()
        if ranks > 1:
            cut = cut_domain(domain, scene, ranks, contact)
            self.parts += domain_parts(domain, cut, range(ranks))

    def boundary_of(self, rank: int) -> np.ndarray:
        """Return the numbers [s] of the boundary nodes of a rank in the whole domain."""
        return self.nodes(rank)[self.parts[rank].domain.boundary] if self.parts else self.domain.boundary

    def nodes(self, rank: int) -> np.ndarray:
        """Return the numbers of the nodes of a rank in the whole domain."""
        return self.parts[rank].nodes if self.parts else np.arange(len(self.domain.reference))

    def nodes_of_body(self, rank: int, body: int) -> np.ndarray:
        """Return the numbers of the nodes of a rank in the plan of a body."""
        return self.parts[rank].bodies[body].nodes if self.parts else np.arange(len(self.domain.bodies[body].reference))
