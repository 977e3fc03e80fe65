"""The static solve by projections on ranks that share the contact cells and all have every contact node.

    rows, measure -> [ sum f ] -> assemble -> tangent -> [ sum K_KK ] -> MPRGP, move -> rows built anew where they slip

Pairs of bodies are solved so, and bodies for whose contact with obstacles MPRGP solves. Every rank does the whole solve
from equal bits, which takes as long as on one rank and no message for its products. kernels/step/rank_copies.py has the
phases.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..cells.internal_force import InternalForce
from ..device import arrays
from ..device.exchange import Exchange
from ..device.launch import Prepared
from ..device.team import Team
from ..kernels.lanes import SWEEP_LANES
from ..nodes.boundary_nodes import BoundaryNodes
from ..planning.domain import Domain
from .bundles import behind_body, boundary_bundle, contact_bundles, place_behind_body, solve_bundles, within_limit
from .massless_contact import MasslessContactTerm
from .residual_shares import ResidualShares


@dataclass(frozen=True, eq=False)
class CopiedIsland:
    """An island of which all these ranks have every contact node.

    nodes: its contact nodes; places [e]: of its blocks of K_KK off the diagonal in `System.values`; couplings,
    diagonals: add these blocks, and those on the diagonal, over the ranks.
    """

    number: int
    nodes: slice
    places: np.ndarray
    couplings: Exchange
    diagonals: Exchange


class CopiedSolve:
    """Solves for the contact nodes of a domain as the other ranks of the contact do.

    sums: of the step (kernels/columns.py); shares: hands over what is left; group: the ranks of the contact, None
    for this one alone; others: their numbers in `team`, without this one.
    """

    def __init__(
        self,
        team: Team,
        domain: Domain,
        force: InternalForce,
        boundary: BoundaryNodes,
        contact: MasslessContactTerm,
        sums: arrays.Array,
        shares: ResidualShares,
        group: Team | None,
        others: Sequence[int],
    ) -> None:
        from ..kernels.static import control as stats
        from ..kernels.step import rank_phases

        self.names, self.phases = stats, rank_phases
        self.force, self.contact, self.shares, self.group = force, contact, shares, group
        self.rows = contact.pairs
        self._viscous = contact.cell_viscosity
        count = len(domain.shared.nodes)
        self._scratch = arrays.zeros(rank_phases.CONTROL), arrays.zeros(rank_phases.MEASURED * count)
        self._launch, self._parts, self._place = self._kernel(domain, boundary, sums)
        one = [(other, np.zeros(1, dtype=np.int64)) for other in others]  # a row that holds a whole array
        self._forces = team.exchange(one, max(1, rank_phases.MEASURED * count))
        self._islands = self._made_islands(domain, team, one)

    def _made_islands(self, domain: Domain, team: Team, one: list[tuple[int, np.ndarray]]) -> list[CopiedIsland]:
        """Return the islands of the domain; one: a list of the other ranks for an exchange of one row."""
        found, size = list[CopiedIsland](), self.contact.block**2
        graph = domain.contact.graph  # type: ignore[union-attr]
        assert graph is not None
        for number, island in enumerate(self.contact.islands):
            nodes = island.nodes
            places = self.contact.order.entry_place[graph.row_start[nodes.start] : graph.row_start[nodes.stop]]
            every = (places[places >= 0][:, None] + SWEEP_LANES * np.arange(size)).reshape(-1)
            widths = len(every), size * (nodes.stop - nodes.start)
            found.append(CopiedIsland(number, nodes, every, *(team.exchange(one, max(1, width)) for width in widths)))
        return found

    def _kernel(
        self, domain: Domain, boundary: BoundaryNodes, sums: arrays.Array
    ) -> tuple[Prepared, tuple[arrays.Array, ...], int]:
        """Make the kernel, its arrays behind those of the force pass, and the place of those of the rows among them."""
        from ..kernels.language.bundles import Coupling, RankLaunch
        from ..kernels.language.signatures import signature_of
        from ..kernels.step.rank_copies import make_rank_copies

        contact, solve = self.contact, self.contact.static_solve
        bundles = {
            "body": self.force.bundle(),
            "boundary": boundary_bundle(boundary, sums),
            **contact_bundles(contact, sums),
            "coupling": Coupling() if self.rows is None else Coupling(self.rows.lists, self.rows.values),
            **solve_bundles(solve),
            "launch": RankLaunch(*self._scratch, None if self._viscous is None else self._viscous.data),
        }
        bundles = within_limit(bundles, solve)
        kernel = make_rank_copies(signature_of(bundles), domain.kinds, contact.options, contact.plain)
        return Prepared(kernel), behind_body(bundles), place_behind_body(bundles, "coupling")

    @property
    def stats(self) -> np.ndarray:
        """Numbers [islands, STATS] of the solve, those of the kernel itself."""
        return np.asarray(self.contact.static_solve.stats).reshape(-1, self.names.STATS)

    def share_residual(self) -> None:
        """Share out what the last solve has left unbalanced."""
        self.shares.share_residual(self.force, self.contact)

    def solve(self, u: arrays.Array, v: arrays.Array) -> None:
        """Bring the contact nodes to equilibrium at the displacement u [3n], in place."""
        at, phases, first, left = self.names, self.phases, 1.0, list(self._islands)
        while True:
            self.force.measure_surface(u, v)
            if self._viscous is not None:
                self._viscous.measure(u, v)
            self._do(u, v, phases.MEASURE)
            self._forces.add(self._scratch[1].reshape(1, -1))
            for island in left:
                self._resolve(u, v, island, first)
            left = [one for one in left if self.stats[one.number, at.NEXT] == at.MEASURE]
            if not (bool(left) if self.group is None else self.group.any(bool(left))):
                return
            first = 0.0
            if self.rows is not None and self._do(u, v, phases.RENEW) == 1.0:
                self.rows.rebuild(arrays.get(u).reshape(-1, 3))

    def _resolve(self, u: arrays.Array, v: arrays.Array, island: CopiedIsland, first: float) -> None:
        """Do one iteration of the static solve of an island; first: 1 at the first measure of a time step."""
        at, stats = self.names, self.stats[island.number]
        self._do(u, v, self.phases.ASSEMBLE, island.number, first)
        if stats[at.TODO] != at.DONE and stats[at.STALE] == 1.0:
            self._linearise(u, v, island)
        self._do(u, v, self.phases.SOLVE, island.number)

    def _linearise(self, u: arrays.Array, v: arrays.Array, island: CopiedIsland) -> None:
        """Assemble K_KK of an island from the cells of all ranks."""
        system, size = self.contact.static_solve.system, self.contact.block**2
        self._do(u, v, self.phases.LINEARISE, island.number)
        values, diagonal = system["values"], system["inverse"].reshape(size, -1)[:, island.nodes]
        couplings, diagonals = values[island.places].reshape(1, -1), diagonal.reshape(1, -1)  # copies
        island.couplings.add(couplings)
        island.diagonals.add(diagonals)
        values[island.places], diagonal[:] = couplings[0], diagonals.reshape(size, -1)
        self._do(u, v, self.phases.INVERT, island.number)

    def _do(self, u: arrays.Array, v: arrays.Array, phase: int, island: int = 0, first: float = 0.0) -> float:
        """Do a phase; first: 1 at the first measure of a time step. Returns its result."""
        control, at = self._scratch[0], self.phases
        rows = [] if self.rows is None else self.rows.owned()
        control[[at.PHASE, at.ISLAND_AT, at.FIRST]] = phase, island, first
        parts, end = self._parts, self._place + len(rows)  # larger arrays of the rows may have taken their place
        self._launch(*self.force.arguments(u, v), *parts[: self._place], *rows, *parts[end:])
        return float(control[at.RESULT])

    def owned(self) -> list[arrays.Array]:
        """Return the arrays of the phases."""
        return [*self._scratch]
