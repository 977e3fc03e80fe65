"""A whole body of a run on several ranks, as frames, results, guards and watches read it.

Either all ranks call a method, or the first one does while it acts alone (device/lead.py). It gets the values of the
whole body: those of nodes and cells are collected from all ranks, and the others get none. Values of the contact come
from the first rank, or from all that share it; where all ranks ask for them, all get them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np

from ...cells.point_state import shape_of
from ...device import arrays
from ...device.lead import collective
from ...device.team import Team
from ...friction_layer import LayerState
from ...planning.partition.domain_part import DomainPart
from ...planning.partition.outline import BodyOutline
from ...planning.rotation import moves_as_one
from ...results.smoothness import PressureRecord
from ...scene.contact_models import MasslessContact
from ...scene.friction_models import FrictionLayer
from ...scene.obstacles import Obstacle
from ..chosen_nodes import Chosen
from .body_view import COVERED, NO_MASTERS, BodyView, Stepped


@dataclass(frozen=True, eq=False)
class ChosenHere:
    """What a rank owns of the chosen nodes of a body.

    rows [r]: their rows in the state; counts [ranks]: how many each rank has; places [k]: of those of all ranks, one
    rank after the other, among the chosen ones; on the first rank.
    """

    rows: np.ndarray
    counts: np.ndarray
    places: np.ndarray


class Shared(Stepped, Protocol):
    """The parts of a rank's state that a view reads beside those of a domain on one rank."""

    part: DomainPart
    team: Team
    own_views: list[BodyView]
    touching: bool

    def whole_contact(self, values: np.ndarray) -> np.ndarray:
        """Return values [k, ..] of the contact nodes of the whole domain from those of the ranks that share them."""
        ...

    def whole(self, values: np.ndarray) -> np.ndarray:
        """Return values [n, ..] of the nodes of the whole domain on the first rank, and none on the others."""
        ...

    def trouble_of(self, number: int) -> str | None:
        """Return why the static solve of a body did not converge in the last row, or None."""
        ...


class RankView(BodyView):
    """Values of a whole body; number: of the body in the whole domain.

    plan: that of the whole body, of which ranks other than the first may have the outline alone; lead_number: as in
    `device.lead.collective`.
    """

    state: Shared
    plan: Any

    def __init__(self, state: Shared, number: int) -> None:
        whole, self.state, self._number = state.part.whole, state, number
        self.plan, self.part, self.team = whole.bodies[number], state.part.bodies[number], state.team
        self.lead = state.team.lead
        self.lead_number = self.lead.register(self)
        self._nodes = slice(int(whole.node_start[number]), int(whole.node_start[number + 1]))
        self._contact = slice(int(whole.contact_start[number]), int(whole.contact_start[number + 1]))
        there = state.part.there
        has_cells = len(self.part.part.cells) > 0
        self.own = state.own_views[there.index(number)] if number in there and has_cells else None
        self._shared = state.part.domain.shared is not None  # ranks share the contact
        self._chosen: list[ChosenHere] = []

    @property
    def trouble(self) -> str | None:
        """Reason why the static solve of the body did not converge, or None."""
        return self.state.trouble_of(self._number)

    @property
    def viscous_force(self) -> None:
        """Return None: the ranks search the stable step together (`RankSteps`)."""
        return

    def _whole(self, values: np.ndarray) -> np.ndarray:
        """Return the values of the body from those of the nodes of the ranks, in an array of its own."""
        found = self.state.whole(values)
        own = found[self._nodes]
        return found if len(own) == len(found) else own.copy()

    @property
    def start_velocity(self) -> np.ndarray:
        """Velocity [n, 3] [m/s] at the start, in the numbering of the plan."""
        return self.first_velocity()

    @collective
    def first_velocity(self) -> np.ndarray:
        """Return `start_velocity`."""
        return self._whole(self.state.start_velocity)

    @collective
    def starts_as_one(self) -> bool:
        """Return whether all its nodes start with one velocity."""
        own = np.zeros((0, 3)) if self.own is None else self.own.start_velocity
        first = own[0] if len(own) else np.zeros(3)
        found = self.team.gathered(np.array([float(len(own) > 0), float(moves_as_one(own)), *first]))
        return bool(found[:, 1].all()) and moves_as_one(found[found[:, 0] > 0.0, 2:])

    @collective
    def latest(self) -> np.ndarray:
        """Return the present displacement [n, 3] [m], internal numbering."""
        return self._whole(arrays.get(self.state.u).reshape(-1, 3))

    def chosen(self, nodes: np.ndarray) -> Chosen:
        """Return what `start_of` and `latest_of` take for some nodes [k], each once: they alone come from others."""
        self.choose(nodes)
        return Chosen(nodes, len(self._chosen) - 1)

    @collective
    def choose(self, nodes: np.ndarray) -> None:
        """Note which of some nodes [k] every rank owns."""
        part, wanted = self.state.part, np.asarray(nodes) + self._nodes.start
        owned, order = part.nodes[part.owned], np.argsort(wanted)
        there = np.flatnonzero(np.isin(owned, wanted))
        places = order[np.searchsorted(wanted, owned[there], sorter=order)]
        counts = self.team.gathered(np.array(len(there))).astype(np.int64)
        every = self.lead.collected(places.__getitem__, counts).astype(np.int64)
        self._chosen.append(ChosenHere(part.owned[there], counts, every))

    def start_of(self, chosen: Chosen) -> np.ndarray:
        """Return the positions [k, 3] [m] of chosen nodes before anything moves."""
        return self.start_here(chosen.number)

    def latest_of(self, chosen: Chosen) -> np.ndarray:
        """Return the present displacement [k, 3] [m] of chosen nodes, see `latest`."""
        return self.latest_here(chosen.number)

    @collective
    def start_here(self, number: int) -> np.ndarray:
        """Return `start_of` nodes of a number in `chosen`."""
        return self._of_chosen(number, self.state.part.domain.reference)

    @collective
    def latest_here(self, number: int) -> np.ndarray:
        """Return `latest_of` nodes of a number in `chosen`."""
        return self._of_chosen(number, arrays.get(self.state.u).reshape(-1, 3))

    def _of_chosen(self, number: int, values: np.ndarray) -> np.ndarray:
        """Return the values of chosen nodes on the first rank; values [n, 3]: of the nodes of this rank."""
        here = self._chosen[number]
        return self.lead.collected(lambda some: values[here.rows[some]], here.counts, here.places.__getitem__)

    @collective
    def half_step_velocity(self) -> np.ndarray:
        """Return the present velocity [n, 3] of the components with mass, internal numbering."""
        return self._whole(arrays.get(self.state.v).reshape(-1, 3))

    def massless_velocity(self, dt: float) -> np.ndarray | None:
        """Return the position difference over dt of the massless components [k, 3]; None without any."""
        if not self._shared:
            return self._of_first(lambda own: own.massless_velocity(dt))
        if not isinstance(self.state.scene.contact, MasslessContact):
            return None
        return self.shared_velocity(dt)

    @collective
    def shared_velocity(self, dt: float) -> np.ndarray:
        """Return `massless_velocity` from the ranks that share the contact."""
        contact = self.state.contact
        return self._of_contact(np.zeros((0, 3)) if contact is None else contact.velocity(self.state.u, dt))

    def _of_contact(self, values: np.ndarray) -> np.ndarray:
        """Return values [k, ..] of the contact nodes of the body from those of the ranks that share them."""
        return self.state.whole_contact(values)[self._contact]

    def _of_first(self, read: Callable[[BodyView], Any]) -> Any:
        """Return what the first rank reads from its part; None if it has no part of the body.

        Where it does not act alone, all ranks get it.
        """
        found = read(self.own) if self.team.leads and self.own is not None else None
        return found if self.lead.acting else self.team.from_first(found)

    def _nodal(self, read: Callable[[BodyView], np.ndarray], elsewhere: float) -> np.ndarray:
        """Return values [n] that the first rank reads, in the user's numbering, and a value at all other nodes."""
        result = np.full(self.plan.node_count if self.team.leads else 0, elsewhere)
        if self.team.leads and self.own is not None:
            result[self.part.part.nodes] = read(self.own)
        return result

    def pose(self, obstacle: Obstacle) -> tuple[np.ndarray, np.ndarray]:
        """Return centre [3] [m] and axes (rows) [3, 3] of an obstacle that moves freely, like `latest`."""
        found: tuple[np.ndarray, np.ndarray] = self._of_first(lambda own: own.pose(obstacle))
        return found

    def contact_areas(self) -> np.ndarray:
        """Return the area [n] [m^2] that the contact force on every node acts on, in the user's numbering; else 0."""
        if self._shared:
            contact = self.plan.contact
            paired = contact is not None and bool(self.state.part.whole.pairs)
            covered = self.shared_cover() if paired else np.zeros(0)
            held, _, areas = self.shared_held_masters() if paired else NO_MASTERS
            if not self.team.leads:
                return np.zeros(0)
            result = self.plan.contact_areas()
            if paired:
                there = covered > 0.0
                nodes = self.plan.node_order[contact.nodes[there]]
                result[nodes] = np.maximum(covered[there], COVERED * result[nodes])
            result[held] = areas
            return result
        return self._nodal(lambda own: own.contact_areas(), 0.0)

    @collective
    def shared_cover(self) -> np.ndarray:
        """Return the areas [k] [m^2] of contact nodes that partners cover, from the ranks that share the contact."""
        own = self.state.contact
        pairs = None if own is None else own.pairs
        if pairs is None or own is None:
            return self._of_contact(np.zeros(0))
        return self._of_contact(pairs.covered_areas()[: len(own.contact_node_forces())])

    def held_masters(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the nodes that supports hold and other bodies touch, see `BodyView.held_masters`."""
        if self._shared:
            return self.shared_held_masters()
        found = self._of_first(self._of_whole)
        return NO_MASTERS if found is None else found

    @collective
    def shared_held_masters(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return `held_masters` from the lowest rank that knows of any: each has all nodes of the contact set."""
        mine = None if self.own is None else self._of_whole(self.own)
        found = self.team.first_of(mine if mine is not None and len(mine[0]) else None)
        return NO_MASTERS if found is None else found

    def _of_whole(self, own: BodyView) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return `held_masters` of the part, with their numbers in the body."""
        nodes, force, areas = own.held_masters()
        return self.part.part.nodes[nodes], force, areas

    def contact_node_force(self) -> np.ndarray:
        """Return the contact force [k, 3] [N] of the last row on the contact nodes alone, in the order of the plan."""
        if self._shared:
            return self.shared_force()
        found = self._of_first(lambda own: own.contact_node_force())
        count = 0 if self.plan.contact is None else len(self.plan.contact.nodes)
        return np.zeros((count, 3)) if found is None else np.asarray(found)

    @collective
    def shared_force(self) -> np.ndarray:
        """Return `contact_node_force` from the ranks that share the contact."""
        contact = self.state.contact
        return self._of_contact(np.zeros((0, 3)) if contact is None else contact.contact_node_forces())

    def pressure_record(self) -> PressureRecord | None:
        """Return an empty record for the pressures of the contact nodes; None without any."""
        contact = self.plan.contact
        if not self.state.touching or contact is None or not len(contact.nodes):
            return None
        nodes = contact.nodes if isinstance(self.plan, BodyOutline) else self.plan.node_order[contact.nodes]
        return PressureRecord(nodes, contact.areas, self.plan.body.contact_faces)

    def layer_fields(self) -> dict[str, np.ndarray]:
        """Return surface temperature [n] [K] and shear stress [n] [Pa] of the layers; elsewhere the start and 0."""
        model = self.state.scene.friction
        if not isinstance(model, FrictionLayer):
            return {}
        start = {"layer_temperature": model.initial_temperature, "layer_shear": 0.0}
        return {name: self._nodal(lambda own, n=name: own.layer_fields()[n], value) for name, value in start.items()}  # type: ignore[misc]

    def friction_fields(self) -> dict[str, np.ndarray]:
        """Return slip path [n] [m] and friction work [n] [J/m^2] of the nodes up to the last row; elsewhere 0."""
        names = ("slip_distance", "friction_work")
        if self._shared:
            slip, work = self.shared_friction().T
            if not self.team.leads:
                return {name: np.zeros(0) for name in names}
            fields = {name: np.zeros(self.plan.node_count) for name in names}
            if self.plan.contact is not None:
                nodes = self.plan.contact.nodes
                fields["slip_distance"][nodes], fields["friction_work"][nodes] = slip, work / self.plan.contact.areas
            return {name: self.plan.to_user(values) for name, values in fields.items()}
        return {name: self._nodal(lambda own, n=name: own.friction_fields()[n], 0.0) for name in names}  # type: ignore[misc]

    @collective
    def shared_friction(self) -> np.ndarray:
        """Return slip path [m] and friction work [J] of the contact nodes [k, 2] from the ranks that share them."""
        contact = self.state.contact
        record = None if contact is None or contact.friction is None else np.stack(contact.friction.record(), axis=1)
        return self._of_contact(np.zeros((0, 2)) if record is None else record)

    def layers(self) -> LayerState | None:
        """Return the present friction layers; None without any."""

        def placed(own: BodyView) -> LayerState | None:
            found = own.layers()
            return None if found is None else replace(found, nodes=self.part.part.nodes[found.nodes])

        found: LayerState | None = self._of_first(placed)
        return found

    def start_layers(self, layers: LayerState) -> None:
        """Start from the friction layers of another run."""
        if self.team.leads and self.own is not None:
            nodes = np.searchsorted(self.part.part.nodes, layers.nodes)
            self.own.start_layers(replace(layers, nodes=nodes))

    def _cells(self, own: np.ndarray, numbers: np.ndarray, count: int) -> np.ndarray:
        """Return values [count, ..] of all cells from those of each rank, which have these numbers, else 0."""
        counts = self.team.gathered(np.array(len(numbers))).astype(np.int64)
        everyone = self.lead.collected(numbers.__getitem__, counts).astype(np.int64)
        values = self.lead.collected(own.__getitem__, counts)
        result = np.zeros((count if self.team.leads else 0, *own.shape[1:]))
        result[everyone] = values
        return result

    def _shapes(self) -> list[list[tuple[int, int]]]:
        """Return for every block of every body of the domain `shape_of` its cells, on all ranks."""
        whole = self.state.part.whole
        if not self.team.leads:
            return self.team.from_first([])
        return self.team.from_first(
            [[shape_of(block) for block in whole.blocks if block.body is body] for body in whole.bodies]
        )

    @collective
    def strains(self) -> np.ndarray:
        """Return the largest plastic strain [cells] of the points of every cell, in the user's numbering."""
        own = np.zeros(0) if self.own is None else self.own.strains()
        return self._cells(own, self.part.part.cells, self.plan.body.mesh.cell_count)

    @collective
    def points(self) -> tuple[np.ndarray, ...]:
        """Return the state of the points of every block of the body, see `PointState.blocks_of_body`."""
        found = []
        mine = {} if self.own is None else dict(zip(self._kinds(self.own), self.own.points(), strict=True))
        everyone = np.arange(self.plan.body.mesh.cell_count)
        for block, shape in zip(self.plan.body.blocks, self._shapes()[self._number], strict=True):
            numbers = everyone[block.numbers]
            here = np.flatnonzero(np.isin(numbers, self.part.part.cells, assume_unique=True))
            own = mine.get((block.kind, block.region), np.zeros((0, *shape)))
            found.append(self._cells(own, here, len(numbers)))
        return tuple(found)

    def points_on_all(self) -> tuple[np.ndarray, ...]:
        """Return `points` on all ranks, which call it."""
        found: tuple[np.ndarray, ...] = self.team.from_first(self.points())
        return found

    @staticmethod
    def _kinds(view: BodyView) -> list[tuple[str, str | None]]:
        """Return what names each block of a body among its others."""
        return [(block.kind, block.region) for block in view.plan.body.blocks]

    def start_points(self, states: tuple[np.ndarray, ...]) -> None:
        """Start from the state of the points that `points` returned."""
        if self.own is None:
            return
        everyone, mine = np.arange(self.plan.body.mesh.cell_count), {}
        for block, state in zip(self.plan.body.blocks, states, strict=True):
            here = np.isin(everyone[block.numbers], self.part.part.cells, assume_unique=True)
            mine[block.kind, block.region] = state[here]
        self.own.start_points(tuple(mine[kind] for kind in self._kinds(self.own)))
