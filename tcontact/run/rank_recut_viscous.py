"""The state of viscous contact cells, and of metals with bulk viscosity, on another number of ranks.

Every rank has the displacement of its boundary nodes at the last time level, and the part of the viscous force there
that its own contact cells gave. The power of a step is linear in that force: in the new run the owner of a node takes
the force of all ranks, and the other copies none.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..contact.massless_contact import MasslessContactTerm
from ..device import arrays
from ..planning.domain_packs import massless_count
from ..planning.partition.domain_part import DomainPart
from .checkpoint import store
from .loop import Run
from .rank_cut import Cut


def of_viscous_cells(
    run: Run, cuts: Sequence[Cut], stored: Sequence[store.Stored], parts: Sequence[DomainPart] | None
) -> dict[str, np.ndarray]:
    """Return by path the data of viscous contact cells of this rank; parts: of this rank, None on one process."""
    found = {}
    for number, (state, cut) in enumerate(zip(run.domains, cuts, strict=True)):
        cells = state.contact.cell_viscosity if isinstance(state.contact, MasslessContactTerm) else None
        if cells is None:
            continue
        path, names = f"domains.{number}.contact.cell_viscosity.data", cells.names
        own, whole = np.array(arrays.get(cells.data)), np.zeros((2, len(cut.domain.reference), 3))
        for rank, one in enumerate(stored):
            if path not in one.found:
                continue
            data, nodes = one.found[path], cut.boundary_of(rank)
            moved, force = data[names.NUMBERS :][: 6 * len(nodes)].reshape(2, -1, 3)
            whole[0, nodes] = moved
            whole[1, nodes] += force
            own[names.RATE] = data[names.RATE]
        part = None if parts is None else parts[number]
        mine = state.domain.boundary if part is None else part.nodes[state.domain.boundary]
        values = whole[:, mine]
        if part is not None:
            values[1, ~np.isin(state.domain.boundary, part.owned)] = 0.0
        own[names.NUMBERS :][: values.size] = values.reshape(-1)
        found[path] = own
    return found


def of_viscous_metals(
    run: Run, cuts: Sequence[Cut], stored: Sequence[store.Stored], parts: Sequence[DomainPart] | None
) -> dict[str, np.ndarray]:
    """Return by path what the bulk viscosity of metals keeps of this rank: where its massless nodes were before.

    The rates of the cells behind it are written in every step before they are read.
    """
    found = {}
    for number, (state, cut) in enumerate(zip(run.domains, cuts, strict=True)):
        force, path = state.internal_force, f"domains.{number}.internal_force.bulk_viscosity"
        if force.bulk_viscosity is None:
            continue
        own, whole = np.array(arrays.get(force.bulk_viscosity)), np.zeros((len(cut.domain.reference), 3))
        for rank, one in enumerate(stored):
            if path in one.found:
                nodes = cut.boundary_of(rank)[: massless_count(cut.parts[rank].domain if cut.parts else cut.domain)]
                whole[nodes] = one.found[path][1 : 1 + 3 * len(nodes)].reshape(-1, 3)
        mine = state.domain.boundary[: massless_count(state.domain)]
        values = whole[mine if parts is None else parts[number].nodes[mine]]
        own[1 : 1 + values.size] = values.reshape(-1)
        found[path] = own
    return found
