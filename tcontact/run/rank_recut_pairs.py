"""The rows of pairs of bodies, for a run that goes on with another number of ranks.

Every rank that has the contact of such a domain has all of it, in one order, so that the new ranks take what the first
one has. Rows refer to nodes and boundary nodes, whose numbers depend on the cut.
"""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from ..kernels import pair_places as at
from ..planning.partition.domain_part import DomainPart
from .rank_cut import Cut

# of the cells of a rank, and written in every step before it is read; what only a contact that ranks share has
OF_CELLS = re.compile(r"domains\.\d+\.contact\.(?:static_solve\.pairs\.|cell_viscosity\.|residual_shares$|shared$)")


def of_pairs(state: Any, cut: Cut, part: DomainPart | None, path: str, found: dict[str, np.ndarray]) -> None:
    """Renumber the rows that stand under a path in `found`, in place.

    state: of the new run; cut: the domain as the ranks of the checkpoint had it; part: that of this rank, None on one
    process.
    """
    lists, values = found.get(f"{path}/lists"), found.get(f"{path}/values")
    if lists is None or values is None:
        return
    domain, count = state.domain, len(cut.domain.reference)
    nodes = np.arange(count) if part is None else part.nodes
    node, slot = np.full(count, -1, dtype=np.int64), np.full(count, -1, dtype=np.int64)
    node[nodes], slot[nodes[domain.boundary]] = np.arange(len(nodes)), np.arange(len(domain.boundary))
    lists = lists.copy()
    rows, first, first_face = (int(lists[place]) for place in (at.ROWS, at.FIRST_ENTRY, at.FIRST_FACE))
    sizes = {at.SLAVES: rows, at.MASTERS: int(lists[first + rows]), at.SURFACE: int(lists[at.SURFACE_NODES])}
    for section, size in sizes.items():
        part_of = slice(lists[section], lists[section] + size)
        lists[part_of] = slot[cut.boundary_of(0)[lists[part_of]]]
    faces = slice(lists[at.FACES], lists[at.FACES] + 4 * int(lists[first_face + rows]))
    lists[faces] = node[cut.nodes(0)[lists[faces]]]
    found[f"{path}/lists"] = lists
    if lists[at.VELOCITIES] > 0:  # of the boundary nodes, at the end
        end = int(lists[at.VELOCITIES])
        found[f"{path}/values"] = np.concatenate([values[:end], np.zeros(3 * len(domain.boundary))])
