"""The static solve of pairs of bodies on ranks that share the contact cells and all have every contact node.

    rows, measure -> [ sum f ] -> assemble -> tangent -> [ sum K_KK ] -> MPRGP, move -> rows built anew where they slip

Every rank does the whole solve from equal bits, which takes as long as on one rank and no message for its products.
kernels/step/rank_copies.py has the phases.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..cells.internal_force import InternalForce
from ..device import arrays
from ..device.launch import Prepared
from ..device.team import Team
from ..nodes.boundary_nodes import BoundaryNodes
from ..planning.domain import Domain
from .bundles import behind_body, boundary_bundle, contact_bundles, place_behind_body, solve_bundles, within_limit
from .massless_contact import MasslessContactTerm
from .residual_shares import ResidualShares


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

        assert contact.pairs is not None
        self.names, self.phases = stats, rank_phases
        self.force, self.contact, self.shares, self.group = force, contact, shares, group
        self.rows = contact.pairs
        self._viscous = contact.cell_viscosity
        self._count = len(domain.shared.nodes)
        self._scratch = arrays.zeros(rank_phases.CONTROL), arrays.zeros(rank_phases.MEASURED * self._count)
        self._launch, self._parts, self._place = self._kernel(domain, boundary, sums)
        size = len(contact.static_solve.system["values"])
        widths = self._scratch[1].size, size, contact.block**2 * self._count
        one = [(other, np.zeros(1, dtype=np.int64)) for other in others]  # a row that holds the whole array
        self._forces, self._couplings, self._diagonals = (team.exchange(one, max(1, width)) for width in widths)

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
            "coupling": Coupling(self.rows.lists, self.rows.values),
            **solve_bundles(solve),
            "launch": RankLaunch(*self._scratch, None if self._viscous is None else self._viscous.data),
        }
        bundles = within_limit(bundles, solve)
        kernel = make_rank_copies(signature_of(bundles), domain.kinds, contact.options, contact.plain)
        return Prepared(kernel), behind_body(bundles), place_behind_body(bundles, "coupling")

    @property
    def stats(self) -> np.ndarray:
        """Numbers [STATS] of the solve, those of the kernel itself."""
        return np.asarray(self.contact.static_solve.stats).reshape(-1)

    def share_residual(self) -> None:
        """Share out what the last solve has left unbalanced."""
        self.shares.share_residual(self.force, self.contact)

    def solve(self, u: arrays.Array, v: arrays.Array) -> None:
        """Bring the contact nodes to equilibrium at the displacement u [3n], in place."""
        names, phases, first = self.names, self.phases, 1.0
        while True:
            self.force.measure_surface(u, v)
            if self._viscous is not None:
                self._viscous.measure(u, v)
            self._do(u, v, phases.MEASURE)
            self._forces.add(self._scratch[1].reshape(1, -1))
            self._do(u, v, phases.ASSEMBLE, first)
            if self.stats[names.TODO] != names.DONE and self.stats[names.STALE] == 1.0:
                self._linearise(u, v)
            self._do(u, v, phases.SOLVE)
            again = bool(self.stats[names.NEXT] == names.MEASURE)
            if not (again if self.group is None else self.group.any(again)):
                return
            first = 0.0
            if self._do(u, v, phases.RENEW) == 1.0:
                self.rows.rebuild(arrays.get(u).reshape(-1, 3))

    def _linearise(self, u: arrays.Array, v: arrays.Array) -> None:
        """Assemble K_KK from the cells of all ranks."""
        system, size = self.contact.static_solve.system, self.contact.block**2
        self._do(u, v, self.phases.LINEARISE)
        self._couplings.add(system["values"].reshape(1, -1))
        diagonal = system["inverse"].reshape(size, -1)[:, : self._count]
        total = diagonal.reshape(1, -1)  # a copy
        self._diagonals.add(total)
        diagonal[:] = total.reshape(size, -1)
        self._do(u, v, self.phases.INVERT)

    def _do(self, u: arrays.Array, v: arrays.Array, phase: int, first: float = 0.0) -> float:
        """Do a phase; first: 1 at the first measure of a time step. Returns its result."""
        control, at, rows = self._scratch[0], self.phases, self.rows.owned()
        control[[at.PHASE, at.ISLAND_AT, at.FIRST]] = phase, 0, first
        parts, end = self._parts, self._place + len(rows)  # larger arrays of the rows may have taken their place
        self._launch(*self.force.arguments(u, v), *parts[: self._place], *rows, *parts[end:])
        return float(control[at.RESULT])

    def owned(self) -> list[arrays.Array]:
        """Return the arrays of the phases."""
        return [*self._scratch]
