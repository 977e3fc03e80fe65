"""Springs and dashpots between sets of nodes: their numbers for the kernels (kernels/nodes/springs.py)."""

from __future__ import annotations

import numpy as np

from ..kernels.columns import group_size
from ..kernels.lanes import SPRING_HEAD, SPRING_NUMBERS
from ..planning.domain import Domain
from ..planning.springs import part_carriers, part_of_nodes, planned_ends

ROUNDS = 1000  # most turns of dashpots that share nodes or parts: a few where dt resolves m/c, more where it does not


def spring_numbers(domain: Domain, groups: tuple[str, ...]) -> np.ndarray:
    """Return the numbers of the springs of a domain; groups: of the columns in its raw rows."""
    from ..kernels.nodes import springs as names

    ends = planned_ends(domain)
    values, entries = np.zeros((len(ends), SPRING_NUMBERS)), 0
    for row, spring, own in zip(values, domain.springs, ends, strict=True):
        given, directions = spring.spring, spring.spring.directions
        middle = entries + len(own[0].nodes)
        last = middle + (0 if spring.grounded else len(own[1].nodes))
        row[: names.STIFFNESS] = bool(directions), entries, middle, last
        entries = last
        row[[names.STIFFNESS, names.DAMPING, names.LENGTH]] = given.stiffness, given.damping, spring.rest_length
        row[names.AXES : names.AXES + 3] = [letter in directions for letter in "xyz"]
        row[names.PLACE_A : names.PLACE_A + 3] = spring.ends[0].place
        row[names.PLACE_B : names.PLACE_B + 3] = spring.ends[1].place
        row[names.REST : names.REST + 3] = spring.rest
    parts = [end for own in ends for end in own]
    nodes = np.concatenate([end.nodes for end in parts])
    carried = part_of_nodes(domain)[nodes] >= 0
    carriers = part_carriers(domain)
    counts = np.array([len(own) for own in carriers])
    values[:, names.LAST_CARRIER] = np.cumsum(counts)
    values[:, names.FIRST_CARRIER] = np.cumsum(counts) - counts
    movers = [int(number) for own in carriers for number in own[:, 0]] + nodes[~carried].tolist()
    turns = ROUNDS if len(set(nodes.tolist())) < len(nodes) or len(movers) > len(set(movers)) else 1
    sums = group_size(*groups[groups.index("boundary") : groups.index("springs")])
    weighted = np.stack([nodes, np.concatenate([end.weights for end in parts]), carried], axis=1)
    head = [len(ends), turns, sums, SPRING_HEAD + values.size + weighted.size]
    return np.concatenate([head, values.ravel(), weighted.ravel(), np.concatenate(carriers).ravel()])
