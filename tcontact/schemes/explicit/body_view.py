"""One body of a domain, as frames, results, guards and watches read it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np

from ...cells.cell_stress import CellStress
from ...cells.internal_force import InternalForce
from ...cells.point_state import PointState
from ...cells.shared_volumes import SharedVolumes
from ...device import arrays
from ...friction_layer import LayerState
from ...nodes.rigid_bodies import RigidBodies
from ...planning.body_plan import held_nodes
from ...planning.domain import Domain
from ...planning.rotation import moves_as_one
from ...results.smoothness import PressureRecord
from ...scene.friction_models import FrictionLayer
from ...scene.obstacles import Obstacle
from ...scene.scene import Scene
from ..chosen_nodes import ChosenNodes

NO_MASTERS = np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros(0)  # nodes, forces and areas of `held_masters`
COVERED = 0.05  # least area of a contact pressure between bodies over the weight of its node


class Stepped(Protocol):
    """The parts of a domain's state that a view reads: displacement u, velocity v (flat [3n]) and terms."""

    scene: Scene
    domain: Domain
    u: arrays.Array
    v: arrays.Array
    start_velocity: np.ndarray
    internal_force: InternalForce
    shared_volumes: SharedVolumes | None
    contact: Any
    serial: Any
    rigid: RigidBodies | None
    views: list[BodyView]

    @property
    def layered(self) -> Any:
        """The friction layers; None without any."""
        ...

    @property
    def whole_domain(self) -> Any:
        """The domain of all ranks."""
        ...

    def whole_nodes(self, nodes: np.ndarray) -> np.ndarray:
        """Return the numbers in it of nodes [k] of this domain."""
        ...

    @property
    def viscous_force(self) -> Callable[[np.ndarray, np.ndarray], np.ndarray] | None:
        """Function for the viscous force of contact cells [3n]; None without any."""
        ...


class BodyView(ChosenNodes):
    """Values of body `number` of a domain's state, in the numbering that each method names."""

    def __init__(self, state: Stepped, number: int) -> None:
        domain = state.domain
        self.state, self.plan = state, domain.bodies[number]
        self._number = number
        self._nodes = slice(int(domain.node_start[number]), int(domain.node_start[number + 1]))
        self._contact = slice(int(domain.contact_start[number]), int(domain.contact_start[number + 1]))

    @property
    def trouble(self) -> str | None:
        """Reason why the static solve of the body did not converge, or None."""
        found = None if self.state.contact is None else self.state.contact.trouble
        return found[1] if found is not None and found[0] is self.plan else None

    def cell_stress(self) -> CellStress:
        """Return what computes the stress of its cells; ranks that share averages of it call that alike."""
        shared = self.state.shared_volumes
        return CellStress(self.plan.body, 1, None if shared is None else shared.of_body(self._number))

    @property
    def viscous_force(self) -> Callable[[np.ndarray, np.ndarray], np.ndarray] | None:
        """Function for the viscous force [3n] of a small step [3n] from u [3n] times its duration; None without."""
        of_domain = self.state.viscous_force
        if of_domain is None or not self.plan.viscous_cells:
            return None
        if len(self.state.views) == 1:
            return of_domain
        nodes, size = slice(3 * self._nodes.start, 3 * self._nodes.stop), 3 * len(self.state.domain.reference)

        def force(u: np.ndarray, step: np.ndarray) -> np.ndarray:
            whole = np.zeros((2, size))
            whole[0, nodes], whole[1, nodes] = u, step
            return of_domain(*whole)[nodes]

        return force

    @property
    def start_velocity(self) -> np.ndarray:
        """Velocity [n, 3] [m/s] at the start, in the numbering of the plan."""
        return self.state.start_velocity[self._nodes]

    def starts_as_one(self) -> bool:
        """Return whether all its nodes start with one velocity."""
        return moves_as_one(self.start_velocity)

    def strains(self) -> np.ndarray:
        """Return the largest plastic strain [cells] of the points of every cell, in the user's numbering."""
        return PointState(self.state.domain, self.state.internal_force).strains_of_body(self._number)

    def points(self) -> tuple[np.ndarray, ...]:
        """Return the state of the points of every block of the body, see `PointState.blocks_of_body`."""
        return PointState(self.state.domain, self.state.internal_force).blocks_of_body(self._number)

    def start_points(self, states: tuple[np.ndarray, ...]) -> None:
        """Start from the state of the points that `points` returned."""
        PointState(self.state.domain, self.state.internal_force).put_blocks_of_body(self._number, states)
        if states:
            self.state.internal_force.rest()

    def latest(self) -> np.ndarray:
        """Return the present displacement [n, 3] [m], internal numbering: after a step that at its end."""
        return arrays.get(self.state.u).reshape(-1, 3)[self._nodes]

    def displacement(self) -> np.ndarray:
        """Return the displacement [n, 3] in the user's numbering."""
        return self.plan.to_user(self.latest())

    def displacement_before(self, step: float) -> np.ndarray:
        """Return the displacement [n, 3] [m] at the last row; step [s]: the step since that row."""
        if step == 0.0:
            return self.displacement()
        return self.displacement() - step * self.velocity(self.half_step_velocity(), self.massless_velocity(step))

    def half_step_velocity(self) -> np.ndarray:
        """Return the present velocity [n, 3] of the components with mass, internal numbering: it changes, copy it."""
        return arrays.get(self.state.v).reshape(-1, 3)[self._nodes]

    def massless_velocity(self, dt: float) -> np.ndarray | None:
        """Return the position difference over dt of the massless components [k, 3]; None without any."""
        contact = self.state.contact
        velocity = None if contact is None else contact.velocity(self.state.u, dt)
        return None if velocity is None else velocity[self._contact]

    def velocity(self, massive: np.ndarray, massless: np.ndarray | None) -> np.ndarray:
        """Join both parts of the velocity [n, 3], in the user's numbering."""
        result = massive.copy()
        if massless is not None and self.plan.contact is not None:
            result[self.plan.contact.nodes] += massless
        if self.plan.images is not None:
            result = self.plan.images.follow(result)
        return self.plan.to_user(result)

    def pose(self, obstacle: Obstacle) -> tuple[np.ndarray, np.ndarray]:
        """Return centre [3] [m] and axes (rows) [3, 3] of an obstacle that moves freely, like `latest`."""
        assert self.state.rigid is not None
        return self.state.rigid.pose(self.state.scene.obstacles.index(obstacle))

    def contact_force(self) -> np.ndarray:
        """Return the contact force on every node [n, 3] [N] of the last row, in the user's numbering."""
        result, contact = np.zeros((len(self.plan.reference), 3)), self.plan.contact
        if contact is None:
            return result
        nodes, force, _ = self.held_masters()
        result[nodes] = force
        if self.plan.images is None:
            result[self.plan.node_order[contact.nodes]] = self.contact_node_force()
            return result
        own = np.zeros_like(result)
        own[contact.nodes] = self.contact_node_force()
        return result + self.plan.to_user(self.plan.images.shared(own))

    def held_masters(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the nodes [h] that supports hold and other bodies touch, with the force [h, 3] [N] of the last row.

        They are no contact nodes; numbers of the user. Third the area [h] [m^2] that the force acts on, at least
        COVERED of the mean weight of a contact node.
        """
        term, contact = self.state.contact, self.plan.contact
        held = np.zeros(0, np.int64) if contact is None else held_nodes(contact)
        if term is None or contact is None or term.pairs is None or not len(held):
            return NO_MASTERS
        places = term.pairs.places_of(self._nodes.start + held)
        least = COVERED * float(contact.areas.mean()) if len(contact.areas) else 0.0
        areas = np.maximum(term.pairs.covered_areas()[places], least)
        return self.plan.node_order[held], arrays.get(term.contact_force).reshape(-1, 3)[places], areas

    def contact_areas(self) -> np.ndarray:
        """Return the area [n] [m^2] that the contact force on every node acts on, in the user's numbering; else 0.

        It is the weight of the node, or with other bodies the part that they cover, at least COVERED of the weight.
        """
        result, contact = self.plan.contact_areas(), self.plan.contact
        held, _, areas = self.held_masters()
        result[held] = areas
        pairs = None if self.state.contact is None else self.state.contact.pairs
        if pairs is not None and contact is not None:
            covered = pairs.covered_areas()[self._contact]
            there = covered > 0.0
            nodes = self.plan.node_order[contact.nodes[there]]
            result[nodes] = np.maximum(covered[there], COVERED * result[nodes])
        return result

    def contact_node_force(self) -> np.ndarray:
        """Return the contact force [k, 3] [N] of the last row on the contact nodes alone, in the order of the plan."""
        if self.state.contact is None or self.plan.contact is None:
            return np.zeros((0, 3))
        count = 3 * int(self.state.domain.contact_start[-1])
        return arrays.get(self.state.contact.contact_force)[:count].reshape(-1, 3)[self._contact]

    def pressure_record(self) -> PressureRecord | None:
        """Return an empty record for the pressures of the contact nodes; None without any."""
        contact = self.plan.contact
        if self.state.contact is None or contact is None or not len(contact.nodes):
            return None
        return PressureRecord(self.plan.node_order[contact.nodes], contact.areas, self.plan.body.contact_faces)

    def layer_fields(self) -> dict[str, np.ndarray]:
        """Return surface temperature [n] [K] and shear stress [n] [Pa] of the layers; elsewhere the start and 0."""
        model, nodes, layered = self.state.scene.friction, len(self.plan.reference), self.state.layered
        if not isinstance(model, FrictionLayer):
            return {}
        fields = {"layer_temperature": np.full(nodes, model.initial_temperature), "layer_shear": np.zeros(nodes)}
        if layered is not None and self.plan.contact is not None:
            temperature, shear = layered.fields()
            fields["layer_temperature"][self.plan.contact.nodes] = temperature[self._contact]
            fields["layer_shear"][self.plan.contact.nodes] = shear[self._contact]
        if self.plan.images is not None:
            fields = {name: self.plan.images.follow(values) for name, values in fields.items()}
        return {name: self.plan.to_user(values) for name, values in fields.items()}

    def friction_fields(self) -> dict[str, np.ndarray]:
        """Return slip path [n] [m] and friction work [n] [J/m^2] of the nodes up to the last row; elsewhere 0.

        The work is that on a node over its area weight (`BodyPlan.contact_areas`), also between bodies.
        """
        fields = {name: np.zeros(len(self.plan.reference)) for name in ("slip_distance", "friction_work")}
        friction, contact = None if self.state.contact is None else self.state.contact.friction, self.plan.contact
        if friction is not None and contact is not None:
            slip, work = (values[self._contact] for values in friction.record())
            fields["slip_distance"][contact.nodes], fields["friction_work"][contact.nodes] = slip, work / contact.areas
        if self.plan.images is not None:
            fields = {name: self.plan.images.follow(values) for name, values in fields.items()}
        return {name: self.plan.to_user(values) for name, values in fields.items()}

    def layers(self) -> LayerState | None:
        """Return the present friction layers; None without any."""
        layered, contact = self.state.layered, self.plan.contact
        if layered is None or contact is None or not len(contact.nodes):
            return None
        return layered.state(self.plan.node_order[contact.nodes], self._contact)

    def start_layers(self, layers: LayerState) -> None:
        """Start from the friction layers of another run."""
        layered, contact = self.state.layered, self.plan.contact
        if layered is not None and contact is not None:
            layered.start_from(self.plan.node_order[contact.nodes], layers, self._contact)
