"""Sensors of a domain: what its probes and maxima measure at every row of the history (tcontact/scene/probes.py)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ..cells.cell_stress import VON_MISES, CellStress, pressure_of
from ..cells.point_state import metal_field
from ..cells.shared_volumes import SharedVolumes
from ..cells.stress import States
from ..device import arrays
from ..planning.body_plan import BodyPlan
from ..planning.measured import Layout
from ..planning.probe_places import ProbePlace
from ..scene.scene import Scene
from .motion import Motion

STRESSES = frozenset({"stress", "von_mises", "pressure"})
ROOM = 2**20  # numbers that the rows between two calls of `measure` may take
Kept = Callable[[int], tuple[np.ndarray, ...]]  # number of a body in the domain -> state of points of its blocks
Strains = Callable[[int], np.ndarray]  # the same -> largest plastic strain of its cells


class Sensors:
    """Probes and maxima of the bodies of a domain.

    numbers: of the bodies in the scene; starts: first node of each in the domain; rows: largest number of rows between
    two calls of `measure`, 1 where a law keeps a state; massless [n, 3, 3]: projector on the components of every node
    that have no mass, or None; velocity [n, 3] [m/s]: at the start; shared: volume nodes that ranks share, or None.
    nodes [k]: nodes of the domain that it reads.
    """

    def __init__(
        self,
        scene: Scene,
        bodies: Sequence[BodyPlan],
        numbers: Sequence[int],
        starts: np.ndarray,
        layout: Layout,
        rows: int,
        massless: np.ndarray | None,
        velocity: np.ndarray,
        shared: SharedVolumes | None = None,
    ) -> None:
        self.scene, self.bodies, self.layout = scene, tuple(bodies), layout
        self._starts = [int(start) for start in starts]
        self.stateful = needs_state(scene, bodies)
        self._probes = [
            _Place(index, scene.probe_column(number, place.probe), place, body)
            for index, (number, body) in enumerate(zip(numbers, bodies, strict=True))
            for place in body.probes
            if len(place.items)
        ]
        self._with_cells = [index for index, body in enumerate(bodies) if len(body.cell_order)]  # not on every rank
        of_stress = {own.index for own in self._probes if own.probe.quantity in STRESSES}
        if shared is not None:  # ranks whose cells no probe measures have a share of the averages of those that do
            of_stress |= {index for index in self._with_cells if _measures_stress(bodies[index])}
        if not STRESSES.isdisjoint(scene.maxima):
            of_stress = set(self._with_cells)
        self._moving = moving_nodes(bodies, starts)
        self.nodes = np.arange(len(velocity)) if of_stress else self._moving
        numbers_a_row = 15 * len(self.nodes) + sum(7 * len(bodies[index].cell_order) for index in of_stress)
        self.rows = 1 if self.stateful else min(rows, max(1, ROOM // max(numbers_a_row, 1)))
        self._stress = [
            CellStress(body.body, self.rows, None if shared is None else shared.of_body(index))
            if index in of_stress
            else None
            for index, body in enumerate(bodies)
        ]
        self.motion = Motion(None if massless is None else massless[self._moving], velocity[self._moving])
        self.maxima: dict[str, list[Any]] = {}  # by quantity: largest value so far, its time [s], body, cell
        counts = len(self.nodes), len(self._moving)
        self._scratch = tuple(np.zeros((self.rows + 1, count, 3)) for count in counts)  # u of nodes, v of moving ones
        self._measured: dict[str, np.ndarray] = {}
        self._cells: dict[str, tuple[np.ndarray, np.ndarray, np.ndarray]] = {}

    def take(self, row: int, u: arrays.Array, v: arrays.Array) -> None:
        """Read the motion at the start of row `row` of the next `measure`: u [3n], v [3n] of the domain."""
        for stored, values, nodes in zip(self._scratch, (u, v), (self.nodes, self._moving), strict=True):
            there = arrays.get(values).reshape(-1, 3)
            stored[row] = there if len(nodes) == len(there) else there[nodes]

    def take_rows(self, count: int, samples: np.ndarray) -> None:
        """Read the first `count` rows from the samples [rows, k, 6] of a kernel (kernels/step/samples.py)."""
        moved, speeds = self._scratch
        moved[:count], speeds[:count] = samples[:count, :, :3], self._of_moving(samples[:count, :, 3:])

    def _of_moving(self, values: np.ndarray) -> np.ndarray:
        """Return values [rows, k, 3] of `nodes` for those of probes."""
        return values[:, np.searchsorted(self.nodes, self._moving)]

    def measure(self, count: int, before: float, after: float, kept: Kept, strains: Strains) -> None:
        """Measure `count` rows; before, after [s]: the steps round the first one, those of the others are `after`.

        kept, strains: give the state and the largest plastic strain of the points of the cells of a body.
        """
        u, v = (stored[: count + 1] for stored in self._scratch)
        motion = self.motion.explicit(self._of_moving(u), v, before, after) if len(self._moving) else {}
        self._fill(motion, u[:count], kept, strains)

    def measure_level(self, u: np.ndarray, velocity: np.ndarray, before: float) -> None:
        """Measure the row of a level of an implicit scheme: u, velocity [n, 3]; before [s]: the step before it."""
        motion = self.motion.implicit(u[self._moving][None], velocity[self._moving][None], before)
        self._fill(motion, u[None], None, None)

    def _fill(self, motion: dict[str, np.ndarray], u: np.ndarray, kept: Kept | None, strains: Strains | None) -> None:
        self._measured, fields = {}, []
        for index, body in enumerate(self.bodies):
            stateful = self.stateful and index in self._with_cells
            state = kept(index) if stateful and kept is not None else None
            fields.append(self._fields(index, body, u, state))
        for own in self._probes:
            quantity = own.probe.quantity
            if own.probe.facts.of_cells:
                self._measured[own.column] = own.place.mean(fields[own.index][quantity][:, own.place.items])
                continue
            node = np.searchsorted(self._moving, self._starts[own.index] + own.nodes)
            moved = motion["displacement" if quantity == "position" else quantity][:, node]
            self._measured[own.column] = own.centre + own.place.mean(moved)
        self._cells = {}
        for quantity in self.scene.maxima:
            if quantity == "plastic_strain" and strains is not None:
                parts = [strains(index)[None] for index in self._with_cells]
            else:
                parts = [fields[index][quantity] for index in self._with_cells]
            cells = np.array([_largest(part) for part in parts])
            largest = np.array([part[np.arange(len(part)), cell] for part, cell in zip(parts, cells, strict=True)])
            owner = _largest(largest.T)
            row = np.arange(len(owner))
            self._cells[quantity] = largest[owner, row], np.array(self._with_cells)[owner], cells[owner, row]

    def _fields(self, index: int, body: BodyPlan, u: np.ndarray, state: States) -> dict[str, np.ndarray]:
        """Return the quantities [rows, cells] of a body that probes or maxima ask for."""
        found: dict[str, np.ndarray] = {}
        stress = self._stress[index]
        if stress is not None:
            start = self._starts[index]
            whole = np.take(u[:, start : start + len(body.place)], body.place, axis=1)
            numbers = stress(whole, state)
            found = {"stress": numbers[..., :6], "von_mises": numbers[..., VON_MISES], "pressure": pressure_of(numbers)}
        if state is not None:
            for name in ("plastic_strain", "temperature"):
                found[name] = metal_field(body.body, name, state)[None]
        return found

    def put(self, table: np.ndarray, times: np.ndarray) -> None:
        """Write what was measured into the measured rows [m, width] at these times [s], and follow the maxima."""
        for name, values in self._measured.items():
            table[:, self.layout.place[name]] = values.reshape(len(table), -1)
        for quantity, (values, body, cell) in self._cells.items():
            if quantity != "plastic_strain":  # the cells measure that
                table[:, self.layout.place[f"{quantity}_max"].start] = values
            row = int(_largest(values[None])[0])
            known = self.maxima[quantity][0] if quantity in self.maxima else -np.inf
            if values[row] > known:  # NaN without a metal has no place
                label = self.bodies[int(body[row])].label
                self.maxima[quantity] = [float(values[row]), float(times[row]), label, int(cell[row])]

    def checkpoint(self) -> dict[str, Any]:
        """Return what it keeps from row to row."""
        return self.motion.kept() | {f"maximum.{name}": found for name, found in self.maxima.items()}

    def restore(self, saved: dict[str, Any]) -> None:
        """Set what `checkpoint` returned."""
        self.motion.put(saved)
        found = {name.partition(".")[2]: value for name, value in saved.items() if name.startswith("maximum.")}
        self.maxima = {name: list(value) for name, value in found.items()}

    def owned(self) -> list[arrays.Array]:
        """Return its arrays."""
        return [*self._scratch, *(array for stress in self._stress if stress is not None for array in stress.owned())]


class _Place:
    """A probe of a body of a domain; nodes [k]: in the numbering of the plan; centre [m]: what adds to its mean."""

    def __init__(self, index: int, column: str, place: ProbePlace, body: BodyPlan) -> None:
        self.index, self.column, self.place, self.probe = index, column, place, place.probe
        self.nodes, self.centre = np.zeros(0, dtype=np.int64), np.zeros(3)
        if not self.probe.facts.of_cells:
            self.nodes = body.place[place.items]
        if self.probe.quantity == "position":
            self.centre = place.mean(body.reference[self.nodes][None])[0]


def moving_nodes(bodies: Sequence[BodyPlan], starts: np.ndarray) -> np.ndarray:
    """Return the nodes [k] of a domain, ascending, whose motion probes measure; starts: see `Sensors`."""
    found = [
        int(start) + body.place[place.items]
        for body, start in zip(bodies, starts, strict=False)
        for place in body.probes
        if not place.probe.facts.of_cells
    ]
    return np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *found]))


def needs_state(scene: Scene, bodies: Sequence[BodyPlan]) -> bool:
    """Return whether a row needs the state of points: quantities of cells where some law keeps one."""
    places = [place for body in bodies for place in body.probes]
    wanted = bool(scene.maxima) or any(place.probe.facts.of_cells and len(place.items) for place in places)
    return wanted and any(material.plastic for body in bodies for material in body.body.materials)


def _measures_stress(body: BodyPlan) -> bool:
    """Return whether a probe of a body measures stress, in cells of this rank or of others."""
    return any(place.probe.quantity in STRESSES for place in body.probes)


def sensed(scene: Scene, bodies: Sequence[BodyPlan], shared: bool = False) -> bool:
    """Return whether a scene has probes or maxima in these bodies; shared: ranks share averages for stresses."""
    found = bool(scene.maxima) or any(len(place.items) for body in bodies for place in body.probes)
    return found or (shared and any(map(_measures_stress, bodies)))


def _largest(values: np.ndarray) -> np.ndarray:
    """Return the place of the largest of values [rows, m] in every row; NaN counts as lowest."""
    return np.argmax(np.where(np.isnan(values), -np.inf, values), axis=1)
