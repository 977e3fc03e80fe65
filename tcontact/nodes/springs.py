"""Springs and dashpots between sets of nodes: their arrays for the kernels (kernels/nodes/springs.py)."""

from __future__ import annotations

import numpy as np

from ..device import arrays
from ..planning.domain import Domain
from ..planning.springs import planned_ends

ROUNDS = 1000  # most turns of dashpots that share nodes: a few where dt resolves m/c, more where it does not


class Springs:
    """The springs of a domain; sums_place: where their sums begin among those of the boundary nodes."""

    name = "springs"

    def __init__(self, domain: Domain, sums_place: int) -> None:
        from ..kernels.nodes import springs as names

        ends = [planned_ends(domain, spring) for spring in domain.springs]
        lists, values, entries = [], np.zeros((len(ends), names.NUMBERS)), 0
        for row, spring, own in zip(values, domain.springs, ends, strict=True):
            given, directions = spring.spring, spring.spring.directions
            middle = entries + len(own[0].nodes)
            last = middle + (0 if spring.grounded else len(own[1].nodes))
            lists += [int(bool(directions)), entries, middle, last]
            entries = last
            row[[names.STIFFNESS, names.DAMPING, names.LENGTH]] = given.stiffness, given.damping, spring.rest_length
            row[names.AXES : names.AXES + 3] = [letter in directions for letter in "xyz"]
            row[names.PLACE_A : names.PLACE_A + 3] = spring.ends[0].place
            row[names.PLACE_B : names.PLACE_B + 3] = spring.ends[1].place
            row[names.REST : names.REST + 3] = spring.rest
        parts = [end for own in ends for end in own]
        nodes = np.concatenate([end.nodes for end in parts])
        shared = len(np.unique(nodes)) < len(nodes)
        head = [len(ends), ROUNDS if shared else 1, sums_place]
        self.lists = arrays.put(np.concatenate([head, lists, nodes]).astype(np.int32))
        self.values = arrays.put(np.concatenate([values.ravel(), *(end.weights for end in parts)]))

    def arguments(self) -> dict[str, arrays.Array]:
        """Arrays by the names of kernels/language/bundles.Springs."""
        return {"lists": self.lists, "values": self.values}

    def owned(self) -> list[arrays.Array]:
        """Arrays of this term."""
        return [self.lists, self.values]
