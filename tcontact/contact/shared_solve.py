"""The static solve of contact nodes that several ranks share: phases of a kernel, and what the ranks exchange between.

    measure -> [ sum f, max F_ref, residual ] -> judge -> tangent -> [ sum rows ] -> sweeps, colour by colour,
    [ increments from owners to copies and ghosts after each colour, max defect after each sweep ] -> move -> measure

The iterates are those of one rank: colours are those of the whole contact, and every decision follows from numbers that
all ranks of an island have alike. kernels/step/rank_solve.py has the phases.
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
from ..planning.partition.shared_contact import SharedContact
from .bundles import behind_body, boundary_bundle, contact_bundles, solve_bundles, within_limit
from .massless_contact import MasslessContactTerm
from .residual_shares import ResidualShares
from .shared_islands import ExchangePlaces, SharedIsland


class SharedSolve:
    """Solves for the contact nodes of a domain together with the other ranks that have some.

    sums: of the step (kernels/columns.py); shares: hands over what is left. passes_over_failed: islands whose last
    solve did not converge are left as they are, in rows of a block that will not count.
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
        teams: Sequence[Team | None],
    ) -> None:
        from ..kernels.static import control as stats
        from ..kernels.static import sweeps
        from ..kernels.step import rank_phases

        self.names, self.rules, self.phases = stats, sweeps, rank_phases
        self.passes_over_failed = False
        self.force, self.contact, self.shares = force, contact, shares
        shared: SharedContact = domain.shared
        count = len(shared.nodes)
        self._viscous = contact.cell_viscosity
        self._scratch = arrays.zeros(rank_phases.CONTROL), arrays.zeros(rank_phases.MEASURED * count)
        self._launch, self._launch_sweep, self._parts = self._kernels(domain, boundary, sums)
        self._block, self._room = contact.block, len(contact.static_solve.system["stiffness"])
        places = ExchangePlaces(team, domain, contact, self._room)
        self._islands = [places.island(number, own) for number, own in enumerate(teams)]

    @property
    def stats(self) -> np.ndarray:
        """Numbers [islands, STATS] of the solve, those of the kernels themselves."""
        return np.asarray(self.contact.static_solve.stats).reshape(-1, self.names.STATS)

    @property
    def settings(self) -> np.ndarray:
        """Settings [islands, SETTINGS] of the solve."""
        return np.asarray(self.contact.static_solve.system["settings"]).reshape(-1, self.names.SETTINGS)

    def _kernels(
        self, domain: Domain, boundary: BoundaryNodes, sums: arrays.Array
    ) -> tuple[Prepared, Prepared, tuple[tuple, tuple]]:
        """Make the kernels of the phases and of the sweeps, and the arrays of both, behind those of the force pass."""
        from ..kernels.language.bundles import Contact, RankLaunch
        from ..kernels.language.signatures import arguments, signature_of
        from ..kernels.step.rank_solve import make_rank_solve, make_rank_sweep

        contact, solve = self.contact, self.contact.static_solve
        bundles = {
            "body": self.force.bundle(),
            "boundary": boundary_bundle(boundary, sums),
            **contact_bundles(contact, sums),
            **solve_bundles(solve),
            "launch": RankLaunch(*self._scratch, None if self._viscous is None else self._viscous.data),
        }
        names = "nodes", "islands", "basis", "active", "compliance", "friction"
        of_sweeps = {
            "rows": bundles["rows"],
            "contact": Contact(**{name: one for name, one in contact.arguments().items() if name in names}),
            "system": bundles["system"],
            "launch": RankLaunch(self._scratch[0]),
        }
        sweep = make_rank_sweep(signature_of(of_sweeps), contact.options)
        bundles = within_limit(bundles, solve)
        kernel = make_rank_solve(signature_of(bundles), domain.kinds, contact.options, contact.plain)
        return Prepared(kernel), Prepared(sweep), (behind_body(bundles), arguments(of_sweeps))

    def share_residual(self) -> None:
        """Share out what the last solve has left unbalanced."""
        self.shares.share_residual(self.force, self.contact)

    def solve(self, u: arrays.Array, v: arrays.Array) -> None:
        """Bring the contact nodes to equilibrium at the displacement u [3n], in place."""
        arguments = (*self.force.arguments(u, v), *self._parts[0])
        first, left = 1.0, list(self._islands)
        if self.passes_over_failed:
            left = [one for one in left if self.stats[one.number, self.names.CONVERGED] == 1.0]
        while left:
            self.force.measure_surface(u, v)
            if self._viscous is not None:
                self._viscous.measure(u, v)
            self._do(arguments, self.phases.MEASURE)
            for island in left:
                self._resolve(arguments, island, first)
            at = self.names
            left = [one for one in left if self.stats[one.number, at.NEXT] == at.MEASURE]
            first = 0.0

    def _do(self, arguments: tuple, phase: int, island: int = 0, **numbers: float) -> np.ndarray:
        """Do a phase; numbers: of `control` by their names in rank_phases.py, in small letters. Returns the results."""
        control, at = self._scratch[0], self.phases
        control[at.PHASE], control[at.ISLAND_AT] = phase, island
        for name, value in numbers.items():
            control[getattr(at, name.upper())] = value
        self._launch(*arguments)
        return control[at.RESULT :]

    def _resolve(self, arguments: tuple, island: SharedIsland, first: float) -> None:
        """Do one iteration of the static solve of an island, as `resolve_island` of kernels/static/solve.py."""
        names, phases, number = self.names, self.phases, island.number
        stats = self.stats[number]
        island.forces.add(self._scratch[1].reshape(-1, phases.MEASURED))
        found = self._do(arguments, phases.ASSEMBLE, number)
        found[:] = self._largest(island, found)
        self._do(arguments, phases.JUDGE, number, first=first)
        if stats[names.TODO] != names.DONE:
            if stats[names.STALE] == 1.0:
                self._linearise(arguments, island)
                stats[names.STALE] = 0.0
            self._sweep(arguments, island)
            self._move(arguments, island)
        self._do(arguments, phases.CONCLUDE, number)

    def _largest(self, island: SharedIsland, values: np.ndarray) -> np.ndarray:
        """Return the largest values over the ranks that have a part of an island."""
        return values if island.team is None else np.asarray(island.team.largest(values))

    def _linearise(self, arguments: tuple, island: SharedIsland) -> None:
        """Assemble K_KK: the rows of own nodes, the diagonal blocks of all."""
        names, number, system = self.names, island.number, self.contact.static_solve.system
        self._do(arguments, self.phases.LINEARISE, number)
        size = self._block * self._block
        island.rows.add(system["values"])
        island.diagonals.add(system["inverse"].reshape(size, self._room).T)
        found = self._do(arguments, self.phases.INVERT, number)
        weakest, stiffest = self._largest(island, np.array([-found[0], found[1]]))
        self.stats[number, [names.PIVOT, names.STIFFEST]] = -weakest, stiffest

    def _sweep(self, arguments: tuple, island: SharedIsland) -> None:
        """Sweep over an island, as `sweep` of kernels/static/sweeps.py, which says what the numbers are."""
        names, rules, phases, number = self.names, self.rules, self.phases, island.number
        stats, settings = self.stats[number], self.settings[number]
        increments = self.contact.static_solve.system["increment"]
        minimum, aim, accepted = self._do(arguments, phases.BEGIN, number).tolist()
        increments.reshape(-1, self._room)[:, island.ghosts] = 0.0
        done, residual, stalled = 0.0, 1e300, False
        relaxation, maximum = settings[names.RELAXATION], settings[names.MAXIMUM_SWEEPS]
        accelerated, checked, mark, backward, factor, straight = False, 0.0, 1e300, False, 0.0, 0.0
        defects = list[float]()  # of this rank, in the sweeps whose residual no decision has asked for yet
        while True:
            if done >= minimum or done == checked + rules.INTERVAL:
                for defect in self._largest(island, np.array(defects)).tolist() if defects else ():
                    before, residual = residual, defect / stats[names.F_REF]
                    stalled = stalled or (residual > rules.STALLED * before and residual <= stats[names.ROUNDING])
                defects.clear()
            if (
                done >= minimum
                and (done >= settings[names.POLISHING_SWEEPS] or residual <= aim or stalled)
                and (done >= maximum or residual <= accepted)
            ):
                break
            if done == checked + rules.INTERVAL:
                if not accelerated and done > rules.INTERVAL and residual > max(aim, rules.SLOW * mark):
                    accelerated, relaxation = True, 1.0
                if accelerated and residual < mark:
                    maximum = min(max(maximum, done + rules.EXTENSION), settings[names.MAXIMUM_IN_ALL])
                checked, mark = done, residual
            if accelerated and not backward:
                self._do(arguments, phases.EXTRAPOLATE, number, factor=factor)
                island.everyone.pass_on(increments)
            defects.append(self._sweep_once(island, relaxation, backward))
            done += 1.0
            if accelerated:
                if backward:
                    advance = self._do(arguments, phases.ADVANCE, number, begin_at=island.own[0], end_at=island.own[1])
                    total = float(advance[0]) if island.team is None else island.team.total(float(advance[0]))
                    straight = 0.0 if total < 0.0 else straight + 1.0
                    factor = straight / (straight + 3.0)
                backward = not backward
        self._do(arguments, phases.END, number)
        self._share_result(island)
        stats[names.SWEEPS] += done
        if settings[names.LINEAR] == 1.0:
            stats[names.BEFORE], stats[names.RESIDUAL] = stats[names.RESIDUAL], residual

    def _sweep_once(self, island: SharedIsland, relaxation: float, backward: bool) -> float:
        """Update every node of an island once; return the largest defect [N] of this rank."""
        increments, defect = self.contact.static_solve.system["increment"], 0.0
        control, at, parts = self._scratch[0], self.phases, self._parts[1]
        control[at.FACTOR], control[at.BACKWARD] = relaxation, backward
        order = range(len(island.colours))
        for colour in reversed(order) if backward else order:
            begin, end = island.colours[colour]
            if begin < end:
                control[at.BEGIN_AT], control[at.END_AT] = begin, end
                self._launch_sweep(*parts)
                defect = max(defect, float(control[at.RESULT]))
            island.increments[colour].pass_on(increments)
        return defect

    def _share_result(self, island: SharedIsland) -> None:
        """Give the copies what the sweeps have left at their owners: active rows, friction and pressing force."""
        active = self.contact.active.astype(np.float64)
        island.active.pass_on(active)
        self.contact.active[:] = active
        if island.friction is not None and self.contact.rows is not None:
            island.friction.pass_on(self.contact.rows.values)

    def _move(self, arguments: tuple, island: SharedIsland) -> None:
        """Move the nodes of an island, as `move` of kernels/static/sweeps.py."""
        reach, part = float(self.settings[island.number, self.names.REACH]), 1.0
        if reach < 1e300:  # of a linear law it is that large, and no step is cut
            length = float(self._largest(island, self._do(arguments, self.phases.LENGTH, island.number)[:1])[0])
            part = min(1.0, reach / max(length, 1e-300))
        self._do(arguments, self.phases.MOVE, island.number, factor=part)

    def owned(self) -> list[arrays.Array]:
        """Return the arrays of the phases."""
        return [*self._scratch]
