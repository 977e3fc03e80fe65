"""The state of a body under an implicit scheme, with the interface of `explicit.state.DomainState` and its views.

Row n holds the level n and the forces of the step that ended there, those of mid-step: the contact force of the step.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ....cells.cell_stress import CellStress
from ....device import arrays
from ....planning.body_plan import BodyPlan
from ....planning.measured import Layout
from ....planning.rotation import moves_as_one
from ....results.smoothness import PressureRecord
from ....scene.scene import Scene
from ...chosen_nodes import ChosenNodes
from ...explicit.stable_step import StableStep, StableSteps
from ...sensors import Sensors, sensed
from .body import ImplicitBody, Level, Taken
from .newton import NotConverged
from .rule import ImplicitRule


class ElasticForce:
    """Internal forces for estimates of the stable step, with the interface of cells/internal_force.py."""

    def __init__(self, body: ImplicitBody) -> None:
        self.body = body

    def without_boundary(self) -> ElasticForce:
        """Return this object: it treats every node as an ordinary one."""
        return self

    def minus_force(self, u: arrays.Array, out: arrays.Array) -> None:
        """Add -f(u)/lumped mass to out."""
        here = np.array(arrays.get(u)).reshape(-1, 3)
        self.body.cells.evaluate("end", here, np.zeros_like(here))
        change = -self.body.cells.force(1.0) / self.body.plan.lumped[:, None]
        arrays.set_values(out, arrays.get(out) + change.reshape(-1))

    def sum_of(self, name: str) -> float:
        """Raise `NotImplementedError`: only viscosity needs sums of cells, and there is none."""
        raise NotImplementedError(name)


class Contact:
    """The verdict on the last step, which the guards read."""

    def __init__(self) -> None:
        self.trouble: str | None = None


class ImplicitState(ChosenNodes):
    """Level and row of one body; displacement, velocity [n, 3]: its start, in the user's numbering."""

    rows_at_once = 1
    touching = True
    viscous_force = None  # no viscous contact cells

    def __init__(
        self,
        scene: Scene,
        plan: BodyPlan,
        displacement: np.ndarray,
        velocity: np.ndarray,
        layout: Layout,
        scheme: ImplicitRule,
    ) -> None:
        self.plan, self.layout = plan, layout
        order = plan.node_order
        self.body = ImplicitBody(scene, plan, scheme)
        self.u = arrays.put(displacement[order])
        self.start_velocity = velocity[order]
        self.internal_force = ElasticForce(self.body)
        self.contact = Contact()
        self.level: Level | None = None
        self._v = self.body.massive(self.start_velocity)
        self._taken = self.body.at_rest(0.0)
        self._shown = self._taken  # step that the last row shows
        self._massless: np.ndarray | None = None
        self._row = np.zeros(layout.width)
        self._work: float | None = None  # of constant loads from no displacement to the last row [J]
        self.sensors: Sensors | None = None
        if sensed(scene, [plan]):
            number = [scene.label(index) for index in range(len(scene.bodies))].index(plan.label)
            parts = scene, [plan], [number], np.zeros(1), layout, 1
            self.sensors = Sensors(*parts, None, self.start_velocity)
        self.views = [self]

    def searches(self, steps: Sequence[StableStep]) -> StableSteps:
        """Return the search for the stable step of an explicit scheme."""
        return StableSteps(self.internal_force, steps)

    @property
    def trouble(self) -> str | None:
        """Reason why the last step did not converge, or None."""
        return self.contact.trouble

    def begin_contact(self, dt: float) -> None:
        """Make the first level; dt [s]: the first step."""
        u = np.array(arrays.get(self.u)).reshape(-1, 3)
        try:
            self.level = self.body.start(u, self.start_velocity)
        except NotConverged as error:
            self.contact.trouble = (
                f"no equilibrium of the contact nodes at the start: {error}; {self.body.scheme.remedy}"
            )
            self.level = self.body._level(u, self.body.massive(self.start_velocity), np.zeros_like(u))
        self._show()
        if self.body.contact is not None and self.body.massless:
            self._massless = self._of_massless(self.start_velocity)

    def _of_massless(self, v: np.ndarray) -> np.ndarray:
        contact = self.plan.contact
        assert contact is not None
        return (v - self.body.massive(v))[contact.nodes]

    def _show(self) -> None:
        assert self.level is not None
        arrays.set_values(self.u, self.level.u)
        self._v = self.level.v

    def advance(self, dt: float) -> int:
        """Do row n, then a step of dt [s], 0 = none. Returns the rows done."""
        assert self.level is not None
        self._shown = self._taken
        self._row = self._measure(self.level, self._taken)
        self._show()
        if self.sensors is not None:
            velocity = self.level.v.copy()
            if self._massless is not None and self.plan.contact is not None:
                velocity[self.plan.contact.nodes] += self._massless
            self.sensors.measure_level(self.level.u, velocity, self._taken.dt)
        if dt <= 0.0:
            return 1
        try:
            level, taken = self.body.advance(self.level, dt)
        except NotConverged as error:
            remedy = self.body.scheme.remedy
            self.contact.trouble = f"Newton's method did not converge in the step from there: {error}; {remedy}"
            return 1
        if self.body.massless:
            self._massless = self._of_massless((level.u - self.level.u) / dt)
        self.level, self._taken = level, taken
        return 1

    def _measure(self, level: Level, taken: Taken) -> np.ndarray:
        row = self.layout.empty[0].copy()
        body, plan = self.body, self.plan

        def put(name: str, value: Any) -> None:
            row[self.layout.place[name]] = value

        body.cells.evaluate("end", level.u, np.zeros_like(level.u))
        elastic, jacobian, hourglass = body.cells.energy(level.u)
        momentum = body.mass.times(level.v)
        put("kinetic", 0.5 * float((level.v * momentum).sum()))
        put("elastic", elastic)
        if "hourglass" in self.layout.place:
            put("hourglass", hourglass)
        put("jacobian_min", jacobian)
        put("momentum", momentum.sum(axis=0))
        put("angular_momentum", np.cross(plan.reference + level.u, momentum).sum(axis=0))
        put("load_work", float((body.weight * level.u).sum()))
        if body.applied is not None:
            work = float((body.applied * level.u).sum())
            put("applied_force", body.applied.sum(axis=0))
            put("applied_step", 0.0 if self._work is None else work - self._work)
            self._work = work
        put("support_force", taken.reaction.sum(axis=0))
        if len(body.support_nodes):
            put("support_power", float(taken.reaction[body.support_nodes, plan.support_axes] @ plan.speeds))
        put("sweeps", taken.iterations)
        put("static_residual", taken.residual)
        contact = body.contact
        if contact is not None:
            force = taken.contact.sum(axis=0)
            put("contact_force", force.sum(axis=0))
            put("contact", contact.energy(level.u))
            put("contact_nodes", int((np.abs(force).max(axis=1) > 0.0).sum()) if len(contact.nodes) else 0)
            put("gap_min", contact.gap_min(level.u))
            for name, load in zip(self.layout.obstacles, taken.loads, strict=False):
                put(f"obstacle_force:{name}", load[:3])
                put(f"obstacle_moment:{name}", load[3:])
        return row

    def checkpoint(self) -> dict[str, Any]:
        """Return the values kept from step to step; the equations compute the others in every step."""
        assert self.level is not None
        found: dict[str, Any] = {f"level.{name}": value for name, value in vars(self.level).items()}
        for part, taken in (("taken", self._taken), ("shown", self._shown)):
            found |= {f"{part}.{name}": value for name, value in vars(taken).items()}
        found |= {"v": self._v, "row": self._row, "massless": self._massless, "work": self._work}
        found |= {f"before.{number}": array for number, array in enumerate(self.body.before)}
        found |= {"depth": self.body.depth, "good": self.body.good, "trouble": self.contact.trouble}
        contact = self.body.contact
        if contact is not None and contact.exact is not None:
            found["active"] = contact.exact.active
        if self.sensors is not None:
            found |= {f"sensors.{name}": value for name, value in self.sensors.checkpoint().items()}
        return found

    def restore(self, saved: dict[str, Any]) -> None:
        """Set the values that `checkpoint` returned."""

        def part(kind: type, name: str) -> Any:
            start = f"{name}."
            return kind(**{key[len(start) :]: value for key, value in saved.items() if key.startswith(start)})

        self.level, self._taken, self._shown = part(Level, "level"), part(Taken, "taken"), part(Taken, "shown")
        arrays.set_values(self.u, self.level.u)
        self._v, self._row, self._massless, self._work = (saved[key] for key in ("v", "row", "massless", "work"))
        self.body.before = saved["before.0"], saved["before.1"], saved["before.2"]
        self.body.depth, self.body.good, self.contact.trouble = saved["depth"], saved["good"], saved["trouble"]
        if self.body.contact is not None and self.body.contact.exact is not None:
            self.body.contact.exact.active = saved["active"]
        if self.sensors is not None:
            self.sensors.restore({key[8:]: value for key, value in saved.items() if key.startswith("sensors.")})

    def rows(self, times: np.ndarray) -> np.ndarray:
        """Return the measured row [1, width] of the last `advance`, at the given time [s]."""
        self._row[self.layout.place["time"]] = times[0]
        if self.sensors is not None:
            self.sensors.put(self._row[None], times)
        return self._row[None]

    def cell_stress(self) -> CellStress:
        """Return what computes the stress of its cells."""
        return CellStress(self.plan.body)

    def starts_as_one(self) -> bool:
        """Return whether all its nodes start with one velocity."""
        return moves_as_one(self.start_velocity)

    def displacement(self) -> np.ndarray:
        """Return the displacement [n, 3] in the user's numbering."""
        return self.plan.to_user(arrays.get(self.u).reshape(-1, 3) if self.level is None else self.level.u)

    def latest(self) -> np.ndarray:
        """Return the present displacement [n, 3] [m], internal numbering: after a step that at its end."""
        return np.asarray(arrays.get(self.u).reshape(-1, 3) if self.level is None else self.level.u)

    def displacement_before(self, step: float) -> np.ndarray:
        """Return the displacement [n, 3] [m] at the last row, or where a part of the step from it did not converge."""
        failed = self.body.failed
        return self.plan.to_user(arrays.get(self.u).reshape(-1, 3) if failed is None else failed.u)

    def half_step_velocity(self) -> np.ndarray:
        """Return the velocity [n, 3] of the level, internal numbering."""
        return self._v if self.level is None else self.level.v

    def massless_velocity(self, dt: float) -> np.ndarray | None:
        """Return the position difference over dt of the massless components [k, 3]; None without any."""
        return self._massless

    def velocity(self, massive: np.ndarray, massless: np.ndarray | None) -> np.ndarray:
        """Join both parts of the velocity [n, 3], in the user's numbering."""
        result = massive.copy()
        if massless is not None and self.plan.contact is not None:
            result[self.plan.contact.nodes] += massless
        return self.plan.to_user(result)

    def contact_force(self) -> np.ndarray:
        """Return the contact force on every node [n, 3] [N] of the last row, in the user's numbering."""
        result = np.zeros((len(self.plan.reference), 3))
        if self.plan.contact is not None:
            result[self.plan.contact.nodes] = self._shown.contact.sum(axis=0)
        return self.plan.to_user(result)

    def contact_node_force(self) -> np.ndarray:
        """Return the contact force [k, 3] [N] of the last row on the contact nodes alone."""
        return np.asarray(self._shown.contact.sum(axis=0))

    def layer_fields(self) -> dict[str, np.ndarray]:
        """Return nothing: implicit schemes have no friction layers."""
        return {}

    def layers(self) -> None:
        """Return nothing: implicit schemes have no friction layers."""

    def pressure_record(self) -> PressureRecord | None:
        """Return an empty record for the pressures of the contact nodes; None without any."""
        contact = self.plan.contact
        if contact is None or not len(contact.nodes):
            return None
        return PressureRecord(self.plan.node_order[contact.nodes], contact.areas, self.plan.body.contact_faces)

    def memory(self) -> dict[str, int]:
        """Return the bytes of the terms."""
        body = self.body
        result = {"state": 4 * 8 * self.level.u.size if self.level is not None else 0}
        result["internal-force"] = arrays.size_in_bytes(body.cells.owned())
        if body.statics is not None:
            result["massless-contact"] = arrays.size_in_bytes(body.statics[0].cells.owned())
        return result
