"""The state of the part of a domain that one rank has, which steps together with those of the other ranks.

The ranks add up the forces of shared nodes between the force pass and the motion of the boundary nodes; each copy of a
node then moves itself. Rows of the history are gathered from all ranks, so that every rank has the row of the domain
and takes the same decisions. Where several ranks share the contact, they solve for its nodes together
(contact/shared_solve.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...base.errors import FunctionError
from ...cells.shared_volumes import SharedVolumes
from ...contact.copied_solve import CopiedSolve
from ...contact.massless_contact import MasslessContactTerm
from ...contact.residual_shares import ResidualShares
from ...contact.shared_solve import SharedSolve
from ...device import arrays
from ...device.team import Team
from ...planning.measured import Layout, combined
from ...planning.node_order import inverse
from ...planning.partition.domain_part import DomainPart
from ...scene.contact_models import MasslessContact
from ...scene.scene import Scene
from .device_step import DeviceSteps, steps_on_device
from .rank_stable_step import RankSteps
from .rank_view import RankView
from .rewind import Rewind
from .row_limits import RowLimits
from .stable_step import StableStep, StableSteps
from .state import DomainState, Kicks


class RankState(DomainState):
    """`DomainState` of the part of this rank; its views are those of whole bodies.

    displacement, velocity: start of every whole body of the domain [n, 3], in the user's numbering.
    """

    def __init__(
        self,
        scene: Scene,
        part: DomainPart,
        displacement: Sequence[np.ndarray],
        velocity: Sequence[np.ndarray],
        layout: Layout,
        team: Team,
    ) -> None:
        self.part, self.team = part, team
        domain, on_device = part.domain, steps_on_device(scene, part.domain)
        if on_device:
            self._share_on_device()
        else:
            self.halo = team.exchange(part.rows_shared())
        u, v = (
            [values[number][part.bodies[number].part.nodes] for number in part.there]
            for values in (displacement, velocity)
        )
        if part.domain.held is not None:
            self.shared_volumes = SharedVolumes(team, part)
        super().__init__(scene, part.domain, u, v, layout)
        self._unmeasured = layout.numbers(  # shares of means over sets of which this rank has nothing
            scene.probe_column(number, place.probe)
            for number, body in zip(part.whole.numbers, part.bodies, strict=True)
            for place in body.plan.probes
            if not len(place.items)
        )
        self._guests = rows = part.guests() if domain.counted is None else np.zeros(0, dtype=np.int64)
        self._guest_nodes = domain.boundary[rows]
        self._guest_start = domain.reference[self._guest_nodes]
        self._guest_mass = domain.tensors[rows, 0, :1]  # what acts on nodes acts on those of the first rank alone
        self._guest_inverse = np.diagonal(domain.inverses[rows], axis1=1, axis2=2).copy()
        self._rate = 0.0 if scene.damping is None else float(scene.damping.constants[0])
        places, sizes = self._places.shared, {"kinetic": 1, "load_work": 1, "momentum": 3, "angular_momentum": 3}
        firsts = [getattr(places, name) for name in sizes]
        spans = [np.arange(first, first + size) for first, size in zip(firsts, sizes.values(), strict=True)]
        self._kick, self._before, self._counted_at = 0.0, 0.0, np.concatenate(spans)
        self._counted = np.zeros(len(self._counted_at))
        self.exchange = self._add
        self._trouble: tuple[int, str] | None = None
        self.asks_to_end, self.ending = False, True  # this rank has a signal; some rank may have one
        self._block: list[Sequence[float]] | None = None  # what is watched, of the rows of a block so far
        self._lost = False  # this rank has failed in a row of the block
        self._stopped: int | None = None  # number of this row, where a GPU takes the block
        self._table: np.ndarray | None = None  # rows of the last block
        self.counts = team.gathered(np.array(len(part.owned))).astype(np.int64)
        contact = self.contact
        self.residual_shares = self._shared_contact()
        self._asks = team.any(bool(self.timed) or (contact is not None and contact.obstacles.asks))
        self._rows = 1 if self._asks else int(team.smallest(len(self._raw)))
        # of other bodies, on other ranks too; a GPU can take a block with metals again
        copied = domain.shared is not None and domain.shared.copied
        one_by_one = team.any(bool(domain.pairs) or copied or (domain.plastic and not on_device))
        self._rows = 1 if one_by_one and on_device else self._rows
        self._kept: Rewind | DeviceSteps | None = None
        if not one_by_one and self._rows > 1:
            self._kept = self.device or Rewind(self)
        self.touching, self.frees = team.any(self.touching), team.any(self.frees)
        self.views = [RankView(self, number) for number in range(len(part.bodies))]

    def _share_on_device(self) -> None:
        """Prepare for steps on a GPU, whose kernels count the copies of nodes, see `DomainState.shared_on_device`."""
        part, guests, shared = self.part, self.part.guests(), self.part.rows_shared()
        if len(guests):
            part.domain.counted = np.ones(len(part.domain.boundary))
            part.domain.counted[guests] = 0.0
        if shared:
            rows = np.unique(np.concatenate([own for _, own in shared]))
            places = [(other, np.searchsorted(rows, own)) for other, own in shared]
            self.shared_on_device = self.team.exchange(places), rows

    def _shared_contact(self) -> ResidualShares | None:
        """Make what solves for contact nodes together with other ranks; return what hands over what is left.

        None where the first rank has the whole contact, or contact nodes have mass.
        """
        domain, team, contact = self.part.domain, self.team, self.contact
        shared = domain.shared
        if shared is None:
            return None
        self.contact_counts = team.gathered(np.array(shared.owned.sum())).astype(np.int64)
        owned = shared.nodes[shared.owned].astype(float)
        self.contact_place = np.argsort(team.joined(owned, self.contact_counts))
        if not isinstance(self.scene.contact, MasslessContact):
            return None
        shares, teams = ResidualShares(team, shared), []
        for number, ranks in enumerate(shared.ranks):
            group = team.group(ranks) if len(ranks) > 1 else None
            if number in shared.islands:
                teams.append(group)
        if isinstance(contact, MasslessContactTerm) and self.serial is not None and self.boundary_nodes is not None:
            parts = team, domain, self.internal_force, self.boundary_nodes, contact, self.serial.sums, shares
            if not shared.copied:
                self.serial.copies = SharedSolve(*parts, teams)
            else:
                others = [other for other in shared.ranks[0] if other != team.rank]
                self.serial.copies = CopiedSolve(*parts, teams[0], others)
        return shares

    def _add(self, special_force: arrays.Array) -> None:
        """Add the forces of the other ranks at shared nodes, and note what the kernel will count of guests."""
        if self.serial is not None and self.serial.copies is not None:
            self.serial.add_viscosity(self.u, self.v, self._before)
        force = arrays.rows(special_force, len(self.part.domain.boundary))
        self.halo.add(force)
        if len(self._guests):
            self._counted[:] = self._sums(force)

    def _sums(self, force: np.ndarray) -> np.ndarray:
        """Return kinetic energy, momenta and work of loads of the nodes that a lower rank counts, at level n."""
        rows, mass, kick, rate = self._guests, self._guest_mass, self._kick, self._rate
        u, v = (arrays.get(values).reshape(-1, 3)[self._guest_nodes] for values in (self.u, self.v))
        loads = self._present_loads()[rows]
        net = loads - force[rows] - rate * mass * v
        velocity = v + kick / (1.0 + rate * kick) * self._guest_inverse * net
        momentum = mass * velocity
        # no products of BLAS, whose threads would wait for each other on cores that other ranks use
        moments = np.einsum("ni,nj->ij", self._guest_start + u, momentum)
        spin = [moments[one, other] - moments[other, one] for one, other in ((1, 2), (2, 0), (0, 1))]
        energies = 0.5 * np.einsum("ni,ni->", momentum, velocity), np.einsum("ni,ni->", loads, u)
        return np.array([*energies, *momentum.sum(axis=0), *spin])

    def _present_loads(self) -> np.ndarray:
        """Return the loads [s, 3] of the boundary nodes at level n."""
        assert self.boundary_nodes is not None
        return arrays.rows(self.boundary_nodes.load, len(self.part.domain.loads))

    def whole_contact(self, values: np.ndarray) -> np.ndarray:
        """Return values [k, ..] of the contact nodes of the whole domain from those of the ranks that share them."""
        shared = self.part.domain.shared
        assert shared is not None
        own = values[shared.owned] if len(shared.nodes) else values[:0]
        return self.team.joined(own, self.contact_counts)[self.contact_place]

    def advance(
        self, kick_before: float, kick_after: float, drift: float, time: float, steps: tuple[float, float],
        rows: int = 1, **stop_at: Any,
    ) -> int:  # fmt: skip
        """Advance, see `DomainState.advance`; the ledger counts every node once.

        The ranks look at the rows of a block behind it. If one of them is beyond the limits, the block is done again
        up to that row.
        """
        self._kick, self._before, self._table = kick_before, steps[0], None
        given = kick_before, kick_after, drift, time, steps
        if rows == 1 or self._kept is None:
            return super().advance(*given, rows, **stop_at)
        self._kept.keep()
        done, watched = self._advance_block(*given, rows, **stop_at)
        found = self._whole_rows(np.cumsum([time, *[steps[1]] * (done - 1)]), watched)
        limits = RowLimits(**stop_at)
        calm = [self._within(of_all_ranks(row), limits) for row in np.moveaxis(found, 0, 1)]
        if not all(calm):
            self._kept.put_back()
            self._before, self._table = steps[0], None
            done, _ = self._advance_block(*given, calm.index(False) + 1, **stop_at)
        return done

    def _advance_block(self, *given: Any, **stop_at: Any) -> tuple[int, np.ndarray]:
        """Advance without a look between the rows; return the rows done, and what is watched [w, n] of all but one."""
        self._block, self._lost = [], False
        done = super().advance(*given, **stop_at)
        if self.device is not None:
            of_rows = [self._watched(raw) for raw in self._raw[: done - 1]]
            self._block = [(*one[:-1], float(row == self._stopped)) for row, one in enumerate(of_rows)]
        watched, self._block, self._lost = np.array(self._block), None, False
        self._pass_over_failed(False)
        return done, watched

    def _pass_over_failed(self, yes: bool) -> None:
        """Let shared solves pass over islands whose last one failed, or not."""
        if self.serial is not None and isinstance(self.serial.copies, SharedSolve):
            self.serial.copies.passes_over_failed = yes

    def _rows_on_device(self, kicks: Kicks, steps: tuple[float, float], rows: int, limits: RowLimits) -> np.ndarray:
        """Take steps on a GPU; all ranks look at the rows of a block behind it, which are NaN from a failed one on."""
        if self._block is None or self.device is None:
            return super()._rows_on_device(kicks, steps, rows, limits)
        found = self.device.take(kicks, steps, rows)
        self._stopped = len(found) - 1 if len(found) < rows else None
        return np.concatenate([found, np.full((rows - len(found), found.shape[1]), np.nan)])

    def _take_row(self, raw: np.ndarray, time: float, steps: tuple[float, float]) -> None:
        """Move the boundary nodes, and note the sums of the row without those of guests."""
        self._before = steps[1]  # the step that ends at the next row
        if self._lost and self.residual_shares is None:
            raw[:] = np.nan  # the block is done again up to a row before this one: no solve that cannot end well
            return
        if self.residual_shares is not None and self.contact is None:  # with contact the serial step does it
            special = arrays.rows(self.internal_force.special_force, len(self.part.domain.boundary))
            self.residual_shares.add(special, np.zeros((1, 3)))
        super()._take_row(raw, time, steps)
        if len(self._guests):
            raw[self._counted_at] -= self._counted

    def _calm(self, raw: np.ndarray, limits: RowLimits) -> bool:
        """Return whether the steps may go on behind a row; within a block they do, and all ranks look behind it."""
        if self._block is None:
            return self._within(of_all_ranks(self.team.gathered(np.array(self._watched(raw)))), limits)
        watched = self._watched(raw)
        self._block.append(watched)
        self._lost = self._lost or bool(watched[-1]) or not np.isfinite(watched[0])
        self._pass_over_failed(True)
        return True

    def started_with(self, values: list[np.ndarray]) -> np.ndarray:
        """Return values [n, ..] of whole bodies, in the user's numbering, at the nodes of the part."""
        part = self.part
        return self._started([values[number][part.bodies[number].part.nodes] for number in part.there])

    @property
    def whole_domain(self) -> Any:
        """The domain of all ranks, or its outline."""
        return self.part.whole

    def whole_nodes(self, nodes: np.ndarray) -> np.ndarray:
        """Return the numbers in it of nodes [k] of the part."""
        return self.part.nodes[nodes]

    def forget(self) -> None:
        """Forget all arrays after the last step, when nothing is asked of the state any more."""
        self.__dict__.clear()

    def whole(self, values: np.ndarray) -> np.ndarray:
        """Return values [n, ..] of the nodes of the whole domain on the first rank, and none on the others."""
        lead, owned = self.team.lead, self.part.owned
        places = lead.collected(self.part.nodes[owned].__getitem__, self.counts).astype(np.int32)
        return lead.collected(lambda rows: values[owned[rows]], self.counts, places.__getitem__)

    def whole_on_all(self, values: np.ndarray) -> np.ndarray:
        """Return values [n, ..] of the nodes of the whole domain on all ranks."""
        owned = self.part.owned
        numbers = self.team.joined(self.part.nodes[owned].astype(float), self.counts).astype(np.int64)
        return self.team.joined(values[owned], self.counts)[inverse(numbers)]

    @property
    def rows_at_once(self) -> int:
        """Return the largest number of rows of one call of `advance` on all ranks: 1 with functions of time."""
        return self._rows

    def ask(self, time: float, steps: tuple[float, float], rows: int) -> int:
        """Ask the functions of time for a row. Raises `FunctionError` on all ranks where one of them fails."""
        if not self._asks:
            return super().ask(time, steps, rows)
        error: FunctionError | None = None
        try:
            super().ask(time, steps, 1)
        except FunctionError as found:
            error = found
        self.team.agree(error)
        return 1

    def rows(self, times: np.ndarray) -> np.ndarray:
        """Return the measured rows of the whole domain."""
        if self._table is None:
            self._whole_rows(times, np.zeros((0, 0)))
        assert self._table is not None
        return self._table

    def _whole_rows(self, times: np.ndarray, watched: np.ndarray) -> np.ndarray:
        """Put the measured rows of all ranks together; return what is watched [w, n] on each of them [ranks, w, n]."""
        table = super().rows(times)
        table[:, self._unmeasured] = 0.0
        if self.part.domain.shared is not None and self.contact is not None and self.contact.pairs is not None:
            place = self.layout.place["pair_rebuilds"]
            table[:, place] *= float(self.part.domain.shared.owned.any())  # all ranks of the contact build the rows
        found = None if self.contact is None else self.contact.trouble
        flags = [float(found is not None), float(self.asks_to_end)]
        all_rows = self.team.gathered(np.concatenate([table.ravel(), watched.ravel(), flags]))
        self._trouble, self.ending = None, bool(all_rows[:, -1].any())
        if all_rows[:, -2].any():
            own = None if found is None else (self._number_of(found[0]), found[1])
            self._trouble = self.team.first_of(own)
        tables = [row[: table.size].reshape(table.shape) for row in all_rows]
        self._table = combined(tables, self.layout, parts=True)
        return all_rows[:, table.size : -2].reshape(self.team.size, *watched.shape)

    def _number_of(self, plan: object) -> int:
        return next(number for number, body in enumerate(self.part.bodies) if body.plan is plan)

    def trouble_of(self, number: int) -> str | None:
        """Return why the static solve of a body did not converge in the last row, or None."""
        return self._trouble[1] if self._trouble is not None and self._trouble[0] == number else None

    def searches(self, steps: Sequence[StableStep | None]) -> StableSteps:
        """Return the search for the stable step; steps: those of the whole bodies, of which the first rank knows."""
        return RankSteps(self.internal_force.without_boundary(), steps, self.part, self.own_views, self.team)

    def over_ranks(self, values: np.ndarray) -> np.ndarray:
        """Return the largest values [.., bodies] over the ranks, for the bodies of the whole domain."""
        result = np.zeros((*values.shape[:-1], len(self.part.bodies)))
        result[..., list(self.part.there)] = values
        return np.asarray(self.team.largest(result))

    def memory(self) -> dict[str, int]:
        """Return the bytes of the terms of all ranks."""
        found: dict[str, int] = {}
        for own in self.team.comm.allgather(super().memory()):
            for name, size in own.items():
                found[name] = found.get(name, 0) + size
        return found


def of_all_ranks(watched: np.ndarray) -> Sequence[float]:
    """Return what decides on all ranks alike whether the steps go on, from what each of them watches [ranks, 6]."""
    energy, lowest, rate, count, *others = watched.T
    sums = float(energy.sum()), float(lowest.min()), float(rate.max()), float(count.sum())
    return *sums, *(float(one.max()) for one in others)
