"""The state of one body during a run: its arrays and its terms, in the internal numbering."""

from __future__ import annotations

import numpy as np

from . import arrays
from .friction_layer import LayerState
from .friction_models import FrictionLayer
from .kernels.columns import group_size, raw_places
from .measured import Layout, RawRows, raw_groups
from .plan import SMALL, BodyPlan
from .scene import Scene
from .smoothness import PressureRecord
from .terms.boundary_nodes import BoundaryNodes, Supports
from .terms.contact import make_contact
from .terms.friction_layer import LayeredFriction
from .terms.images import PeriodicImages
from .terms.internal_force import InternalForce
from .terms.serial_step import SerialStep

AT_ONCE, MOST_AT_ONCE = 60, 32  # passes of SMALL cells (20 ms on a thread), and rows, between looks at a larger body


class BodyState:
    """Displacement u and velocity v (flat [3n]) of a body, and the terms it has.

    displacement, velocity [n, 3]: where the body starts, in the user's numbering.
    """

    def __init__(
        self, scene: Scene, plan: BodyPlan, displacement: np.ndarray, velocity: np.ndarray, layout: Layout | None = None
    ) -> None:
        self.scene, self.plan = scene, plan
        self.layout = layout or Layout()
        order, images = plan.node_order, plan.images
        if images is not None:
            order = order[images.master]  # they start together, whatever is handed in
        self.u = arrays.put(displacement[order])
        self.start_velocity = velocity[order]
        self.internal_force = InternalForce(plan)
        self.listed = BoundaryNodes(plan, self.internal_force.special_force) if len(plan.boundary) else None
        self.supports = Supports(plan) if len(plan.support_rows) else None
        self.groups = raw_groups(scene, plan)
        self._reader, self._places = RawRows(self.groups, self.layout), raw_places(plan.dissipates)
        self.contact = make_contact(scene, plan, self.listed, self.internal_force)
        self.images = None if images is None else PeriodicImages(plan, images)
        self.serial: SerialStep | None = None
        if self.listed is not None or self.contact is not None or plan.small:
            parts = self.internal_force, self.listed, self.supports, self.contact, self.images
            self.serial = SerialStep(plan, self.groups, *parts)
            if plan.small:
                self.serial.use_for_products()
        self.v = arrays.put(self._massive(self.start_velocity))
        several = (
            1
            if plan.small or self._layered
            else int(np.clip(AT_ONCE * SMALL[plan.element] // len(plan.cells), 1, MOST_AT_ONCE))
        )
        self._raw = np.zeros((several, group_size(*self.groups)))

    @property
    def _layered(self) -> bool:
        return self.contact is not None and isinstance(self.contact.friction, LayeredFriction)

    def _massive(self, velocity: np.ndarray) -> np.ndarray:
        """The velocity without its massless components."""
        result = velocity.copy()
        contact = self.plan.contact
        if contact is not None and contact.basis is not None:
            along = np.einsum("kic,ki->kc", contact.basis, velocity[contact.nodes])
            result[contact.nodes] -= np.einsum("kic,kc->ki", contact.basis, along)
        return result if self.plan.images is None else self.plan.images.follow(result)

    def begin_contact(self, dt: float) -> None:
        """Bring massless nodes to equilibrium at the start; dt [s]: the first step."""
        if self.serial is not None and self.contact is not None and self.contact.kernel == "massless":
            assert self.plan.contact is not None
            self.serial.run(self.serial.names.PLACE, self.u, self.v, 0.0, 0.0, dt)
            self.contact.start_velocity(self.u, self.start_velocity[self.plan.contact.nodes], dt)

    @property
    def rows_at_once(self) -> int:
        """Most rows that one call of `advance` does."""
        if self.plan.small and self.serial is not None:
            return self.serial.rows_at_once
        return len(self._raw)

    def advance(
        self,
        kick_before: float,
        kick_after: float,
        drift: float,
        time: float,
        steps: tuple[float, float],
        rows: int = 1,
        jacobian: float = -np.inf,
        energy: float = np.inf,
        viscous_rate: float = np.inf,
    ) -> int:
        """v^n = v + kick_before a,  row n,  v = v^n + kick_after a,  u += drift v, then what has no mass is placed.

        time [s]: of level n; steps [s]: before and after it; rows and what follows: see `SerialStep.run`. Returns the
        rows done. Raises `FunctionError`, with nothing moved yet, if a function of time fails within the first row.
        """
        force, serial, places = self.internal_force, self.serial, self._places
        if self.plan.small and serial is not None:
            force.set_steps(kick_before, kick_after, drift)
            return serial.run(serial.names.PASS, self.u, self.v, time, *steps, rows, jacobian, energy, viscous_rate)
        if serial is not None and self.contact is not None and steps[1] > 0.0:
            rows = self.contact.obstacles.ask(time, steps[1], rows)
        for number in range(rows):
            force.advance(self.u, self.v, kick_before, kick_after, drift)
            raw = self._raw[number]
            if serial is None:
                raw[:] = force.sums()
            else:
                serial.run(serial.names.BOUNDARY, self.u, self.v, time + number * steps[1], *steps)
                raw[:] = serial.rows(1)[0]
            total = raw[places.nodes.kinetic] + raw[places.cells.elastic]
            if serial is not None:
                total += raw[places.shared.kinetic]
            calm = total <= energy and raw[places.cells.jacobian_min] > jacobian
            calm = calm and (self.plan.viscosity is None or not raw[places.cells.viscous_rate] > viscous_rate)
            if not calm or (self.contact is not None and self.contact.trouble):
                break
        return number + 1

    def rows(self, times: np.ndarray) -> np.ndarray:
        """The measured rows [n, width] (measured.Layout) of the last `advance`, at the given times [s]."""
        small = self.plan.small and self.serial is not None
        raw = self.serial.rows(len(times)) if small and self.serial is not None else self._raw[: len(times)]
        rows = self._reader.measured(raw, times, self.plan.gravity)
        if self.contact is not None and isinstance(self.contact.friction, LayeredFriction):
            late = float(rows[-1, self.layout.place["friction_after"]][0])
            for name, value in self.contact.friction.row(late).items():
                rows[-1, self.layout.place[name]] = value
        return rows

    def displacement(self) -> np.ndarray:
        """Displacement [n, 3] in the user's numbering."""
        return self.plan.to_user(arrays.get(self.u).reshape(-1, 3))

    def latest(self) -> np.ndarray:
        """Displacement [n, 3] [m] as it stands, internal numbering: after a step that of the level where it ends."""
        return arrays.get(self.u).reshape(-1, 3)

    def displacement_before(self, step: float) -> np.ndarray:
        """Displacement [n, 3] [m] at the level of the last row, where a step [s] has been made since."""
        if step == 0.0:
            return self.displacement()
        return self.displacement() - step * self.velocity(self.half_step_velocity(), self.massless_velocity(step))

    def half_step_velocity(self) -> np.ndarray:
        """Velocity [n, 3] of the components with mass, internal numbering, as it stands."""
        return np.array(arrays.get(self.v)).reshape(-1, 3)

    def massless_velocity(self, dt: float) -> np.ndarray | None:
        """Position difference over dt of the massless components [k, 3]; None without any."""
        return None if self.contact is None else self.contact.velocity(self.u, dt)

    def velocity(self, massive: np.ndarray, massless: np.ndarray | None) -> np.ndarray:
        """Velocity [n, 3] in the user's numbering from both parts."""
        result = massive.copy()
        if massless is not None and self.plan.contact is not None:
            result[self.plan.contact.nodes] += massless
        if self.plan.images is not None:
            result = self.plan.images.follow(result)
        return self.plan.to_user(result)

    def contact_force(self) -> np.ndarray:
        """Contact force on every node [n, 3] [N] of the last row, in the user's numbering."""
        result, contact = np.zeros((len(self.plan.reference), 3)), self.plan.contact
        if contact is None:
            return result
        if self.plan.images is None:
            result[self.plan.node_order[contact.nodes]] = self.contact_node_force()
            return result
        result[contact.nodes] = self.contact_node_force()
        return self.plan.to_user(self.plan.images.shared(result))

    def contact_node_force(self) -> np.ndarray:
        """Contact force [k, 3] [N] of the last row on the contact nodes alone, in the order of the plan."""
        if self.contact is None or self.plan.contact is None:
            return np.zeros((0, 3))
        return arrays.get(self.contact.contact_force)[: 3 * len(self.plan.contact.nodes)].reshape(-1, 3)

    def pressure_record(self) -> PressureRecord | None:
        """An empty record for the pressures of the contact nodes; None without any."""
        contact = self.plan.contact
        if self.contact is None or contact is None or not len(contact.nodes):
            return None
        return PressureRecord(self.plan.node_order[contact.nodes], contact.areas, self.plan.body.contact_faces)

    def layer_fields(self) -> dict[str, np.ndarray]:
        """Surface temperature [n] [K] and shear stress [n] [Pa] of the friction layers; off them the start, and 0."""
        model, nodes = self.scene.friction, len(self.plan.reference)
        if not isinstance(model, FrictionLayer):
            return {}
        fields = {"layer_temperature": np.full(nodes, model.initial_temperature), "layer_shear": np.zeros(nodes)}
        if self.contact is not None and isinstance(self.contact.friction, LayeredFriction):
            assert self.plan.contact is not None
            temperature, shear = self.contact.friction.fields()
            fields["layer_temperature"][self.plan.contact.nodes] = temperature
            fields["layer_shear"][self.plan.contact.nodes] = shear
        if self.plan.images is not None:
            fields = {name: self.plan.images.follow(values) for name, values in fields.items()}
        return {name: self.plan.to_user(values) for name, values in fields.items()}

    def layers(self) -> LayerState | None:
        """The friction layers as they are now; None without any."""
        friction, contact = None if self.contact is None else self.contact.friction, self.plan.contact
        if not isinstance(friction, LayeredFriction) or contact is None:
            return None
        return friction.state(self.plan.node_order[contact.nodes])

    def take_over_layers(self, layers: LayerState) -> None:
        """Begin with the friction layers that another run has left."""
        friction, contact = None if self.contact is None else self.contact.friction, self.plan.contact
        if isinstance(friction, LayeredFriction) and contact is not None:
            friction.take_over(self.plan.node_order[contact.nodes], layers)

    def contact_areas(self) -> np.ndarray:
        """Area weight [n] [m^2] of every node; 0 off the contact set."""
        result = np.zeros(len(self.plan.reference))
        if self.plan.contact is not None:
            result[self.plan.contact.nodes] = self.plan.contact.areas
        if self.plan.images is not None:
            result = self.plan.images.shared(result)
        return self.plan.to_user(result)

    def memory(self) -> dict[str, int]:
        """Bytes by term."""
        result = {"state": arrays.size_in_bytes([self.u, self.v])}
        if self.serial is not None:
            result["internal-force"] = arrays.size_in_bytes(self.serial.owned())
        friction = None if self.contact is None else self.contact.friction
        cells = None if self.serial is None else self.serial.cells
        for term in (self.internal_force, self.listed, self.supports, self.contact, friction, cells, self.images):
            if term is not None:
                result[term.name] = result.get(term.name, 0) + arrays.size_in_bytes(term.owned())
        return result
