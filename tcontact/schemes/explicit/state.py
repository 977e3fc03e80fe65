"""The state of a domain during a run: its arrays and its terms, in the numbering of the domain."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ...cells.device_force import DeviceForce
from ...cells.internal_force import InternalForce
from ...cells.shared_volumes import ForceVolumes, SharedVolumes
from ...contact.contact_terms import make_contact
from ...contact.device_layers import DeviceLayers
from ...contact.layered_friction import LayeredFriction
from ...contact.massless_contact import MasslessContactTerm
from ...device import arrays
from ...device.joint import Joint
from ...kernels.columns import RIGID, group_size, raw_places
from ...kernels.lanes import MAXIMUM_ROWS
from ...nodes.applied_loads import AppliedLoads
from ...nodes.boundary_nodes import BoundaryNodes, Supports
from ...nodes.driven_supports import DrivenSupports
from ...nodes.images import PeriodicImages
from ...nodes.rigid_bodies import RigidBodies
from ...nodes.springs import spring_numbers
from ...planning.applied_loads import pack_loads
from ...planning.domain import Domain
from ...planning.measured import Layout, RawRows, raw_groups
from ...planning.rigid import names_of
from ...scene.contact_models import MasslessContact
from ...scene.scene import Scene
from ..sensors import Sensors, sensed
from .body_view import BodyView
from .device_boundary import DeviceBoundarySteps
from .device_contact import DeviceContactSteps
from .device_stable_step import stable_steps
from .device_step import DeviceSteps, steps_on_device
from .device_terms import DeviceTermSteps, Shared
from .row_limits import RowLimits
from .serial_step import SerialStep
from .stable_step import StableStep, StableSteps
from .timed import Timed

AT_ONCE = 60  # passes of SMALL cells in one call of `advance` of a larger domain: 20 ms on a thread
MAXIMUM_AT_ONCE = 32  # rows in such a call
Kicks = tuple[float, float, float]  # [s]: before, after, drift


class DomainState:
    """Displacement u and velocity v (flat [3n]) of a domain, and its terms.

    displacement, velocity: start of every body [n, 3], in the user's numbering; views: one for each body.
    exchange: where another process holds copies of boundary nodes, it is called between the force pass of a large
    domain and the motion of its boundary nodes, and adds the parts of their force [3*s+c, N] that stand there;
    shared_on_device: what does that in the steps of a GPU, see `DeviceTermSteps`; shared_volumes: averages of volume
    changes at such nodes, None where there are none.
    """

    exchange: Callable[[arrays.Array], None] | None = None
    shared_on_device: Shared | None = None
    shared_volumes: SharedVolumes | None = None

    def __init__(
        self,
        scene: Scene,
        domain: Domain,
        displacement: list[np.ndarray],
        velocity: list[np.ndarray],
        layout: Layout | None = None,
    ) -> None:
        self.scene, self.domain = scene, domain
        self.layout = layout or Layout()
        self.groups = raw_groups(scene, domain)
        self._reader = RawRows(self.groups, self.layout, [pair.name for pair in domain.pairs], names_of(domain.rigid))
        self._places = raw_places(domain.dissipates, domain.plastic)
        self._mass = domain.mass
        if domain.rigid:
            self._rate_place = group_size(*self.groups[: self.groups.index("rigid")]) + RIGID.rigid_rate
        self.u = arrays.share(self._started(displacement))
        self.start_velocity = self._started(velocity)
        on_device = steps_on_device(scene, domain)
        self.internal_force: InternalForce = DeviceForce(domain) if on_device else InternalForce(domain)
        if self.shared_volumes is not None and self.shared_volumes.blocks:
            self.internal_force.average = ForceVolumes(self.internal_force, self.shared_volumes).average
        # a static solve has many launches; without one arrays stand alone, whose kernels keep less in local memory
        solves = domain.contact is not None and isinstance(scene.contact, MasslessContact)
        joint = Joint() if on_device and solves else None
        with arrays.standing_in(joint):
            self._make_terms(displacement)
        self.sensors: Sensors | None = None
        if sensed(scene, domain.bodies, self.shared_volumes is not None):
            parts = scene, domain.bodies, domain.numbers, domain.node_start[:-1], self.layout
            rows = MAXIMUM_ROWS if domain.small else 1
            self.sensors = Sensors(*parts, rows, domain.massless, self.start_velocity, self.shared_volumes)
        self.serial: SerialStep | None = None
        parts_of_step = self.boundary_nodes, self.contact, self.rigid
        if not on_device and (any(part is not None for part in parts_of_step) or domain.small):
            terms = self.internal_force, self.boundary_nodes, self.supports, self.contact, self.images
            self.serial = SerialStep(domain, self.groups, *terms, self.loads, self.sensors, self.rigid)
            if domain.small:
                self.serial.use_for_products()
        self.v = arrays.share(self._massive(self.start_velocity))
        self.device: DeviceSteps | None = None
        if isinstance(self.internal_force, DeviceForce):
            with arrays.standing_in(joint):
                self.device = self._device_steps(self.internal_force)
        self.timed: list[Timed] = [] if self.driven is None else [self.driven]
        self.timed += [self.loads] if self.loads is not None and self.loads.varies else []
        self.timed += [self.rigid] if self.rigid is not None and self.rigid.driven else []
        several = 1
        if not domain.small and self.layered is None and self.sensors is None:
            several = int(np.clip(AT_ONCE / domain.several, 1, MAXIMUM_AT_ONCE))
        several = several if self.device is None else self.device.rows_at_once
        self._raw = np.zeros((several, group_size(*self.groups)))
        self._builds = np.zeros(several)  # times that rows of pairs were built, up to each of these rows
        self.own_views = [BodyView(self, number) for number in range(len(domain.bodies))]
        self.views = self.own_views

    def _make_terms(self, displacement: list[np.ndarray]) -> None:
        """Make boundary nodes, loads, supports, contact and rigid bodies; displacement: as of this class."""
        scene, domain = self.scene, self.domain
        self.boundary_nodes: BoundaryNodes | None = None
        self.loads: AppliedLoads | None = None
        if len(domain.boundary):
            packed = pack_loads(domain)
            data = None if packed is None else packed.data
            springs = spring_numbers(domain, self.groups) if domain.springs else None
            self.boundary_nodes = BoundaryNodes(domain, self.internal_force.special_force, data, springs)
            if packed is not None:
                before = self.groups[self.groups.index("boundary") : self.groups.index("applied")]
                load, gravity = self.boundary_nodes.load, scene.gravity_function
                self.loads = AppliedLoads(domain, packed, load, gravity, group_size(*before))
        self.supports: Supports | None = None
        if len(domain.support_rows):
            self.supports = Supports(domain, self._started(displacement), domain.table_rows)
        self.driven = DrivenSupports(domain, self.supports) if self.supports is not None and domain.driven else None
        self.contact = make_contact(scene, domain, self.internal_force)
        self.touching = self.contact is not None
        self.rebuilds_before = 0  # of rows of pairs, up to the last launch
        self.frees = False  # whether obstacles move freely that something can touch
        if self.contact is not None and self.contact.kernel != "gaps":
            self.frees = bool(self.contact.obstacles.free)
        self.images = None if domain.images is None else PeriodicImages(domain, domain.images)
        self.rigid = self._rigid_bodies()

    def _device_steps(self, force: DeviceForce) -> DeviceSteps:
        """Make the steps on a GPU."""
        if self.boundary_nodes is None:
            return DeviceSteps(force, self.u, self.v)
        parts = self.domain, self.groups, force, self.u, self.v, self.boundary_nodes
        others = self.supports, self.rigid, self.shared_on_device
        if isinstance(self.contact, MasslessContactTerm):
            return DeviceContactSteps(*parts, self.contact, *others)
        return DeviceBoundarySteps(*parts, self.contact, *others)

    def _rigid_bodies(self) -> RigidBodies | None:
        """Make the rigid bodies, and place the obstacles among them."""
        if not self.domain.rigid:
            return None
        before = self.groups[self.groups.index("boundary") : self.groups.index("rigid")]
        obstacles = None if self.contact is None else self.contact.obstacles
        centre = np.zeros(3) if obstacles is None else obstacles.centre
        rows_at_once = MAXIMUM_ROWS if self.domain.small else 1
        found = RigidBodies(self.domain.rigid, centre, group_size(*before), rows_at_once)
        if found.ties is not None:
            places, velocity = found.start_velocity()
            self.start_velocity[self.domain.boundary[places]] = velocity
        return found

    def _started(self, values: list[np.ndarray]) -> np.ndarray:
        """Return values [n, 3] of the bodies in the numbering of the domain; images take those of their masters."""
        parts = [part[body.node_order] for body, part in zip(self.domain.bodies, values, strict=True)]
        joined = parts[0] if len(parts) == 1 else np.concatenate(parts)
        return joined if self.domain.images is None else joined[self.domain.images.master]

    def started_with(self, values: list[np.ndarray]) -> np.ndarray:
        """Return values [n, ..] of its bodies, in the user's numbering, at the nodes of the domain."""
        return self._started(values)

    @property
    def whole_domain(self) -> Domain:
        """The domain of all ranks."""
        return self.domain

    def whole_nodes(self, nodes: np.ndarray) -> np.ndarray:
        """Return the numbers in it of nodes [k] of this domain."""
        return nodes

    @property
    def layered(self) -> LayeredFriction | DeviceLayers | None:
        """The friction layers; None without any."""
        if isinstance(self.device, DeviceTermSteps) and self.device.layers is not None:
            return self.device.layers
        friction = None if self.contact is None else self.contact.friction
        return friction if isinstance(friction, LayeredFriction) else None

    def _massive(self, velocity: np.ndarray) -> np.ndarray:
        """Return the velocity without its massless components."""
        result = velocity.copy()
        contact = self.domain.contact
        if contact is not None and contact.basis is not None:
            along = np.einsum("kic,ki->kc", contact.basis, velocity[contact.nodes])
            result[contact.nodes] -= np.einsum("kic,kc->ki", contact.basis, along)
        return result if self.domain.images is None else self.domain.images.follow(result)

    def begin_contact(self, dt: float) -> None:
        """Bring massless nodes to equilibrium at the start, or build the rows of a penalty; dt [s]: the first step.

        Supports that functions of time drive get their velocity there, and loads are applied before.
        """
        if self.driven is not None:
            self.driven.begin(dt)
            self._start_driven(self.driven.start_speeds)
        if self.loads is not None:
            self.loads.start(self.u, self.start_velocity)
        if isinstance(self.device, DeviceTermSteps) and self.loads is not None:
            self.device.loads.start()
        if self.serial is not None and self.loads is not None:
            self.internal_force.set_steps(0.0, 0.0, 0.0)
            self.serial.run(self.serial.names.LOADS, self.u, self.v, 0.0, 0.0, 0.0)
        if isinstance(self.device, DeviceBoundarySteps) and self.device.pairs is not None:
            self.device.build_rows()
        if isinstance(self.device, DeviceContactSteps):
            self._place(self.device.begin, dt)
        if self.serial is None or self.contact is None:
            return
        if self.contact.kernel == "penalty" and self.contact.pairs is not None:
            self.serial.build_rows(self.u)
        if self.contact.kernel == "massless":
            run, place = self.serial.run, self.serial.names.PLACE
            self._place(lambda: run(place, self.u, self.v, 0.0, 0.0, dt), dt)

    def _place(self, solve: Callable[[], object], dt: float) -> None:
        """Bring massless nodes to equilibrium by the solve of the start, and give them their start velocity.

        Friction that depends on the slip speed takes it from velocities: in this solve from those of the start, which
        the massless components have no other place for before it. dt [s]: the first step.
        """
        assert self.contact is not None
        assert self.domain.contact is not None
        if self.contact.options.static_friction and self.contact.options.varied:
            massive = np.array(arrays.get(self.v))
            arrays.set_values(self.v, self.start_velocity)
            solve()
            arrays.set_values(self.v, massive)
        else:
            solve()
        self.contact.start_velocity(self.u, self.start_velocity[self.domain.contact.nodes], dt)

    def _start_driven(self, speeds: np.ndarray) -> None:
        """Set the velocities of driven components to those of their axes [axes] [m/s] at the start."""
        domain, here = self.domain, self.domain.driven_axes >= 0
        nodes, axes = domain.boundary[domain.support_rows[here]], domain.support_axes[here]
        velocity = np.array(arrays.get(self.v)).reshape(-1, 3)
        for values in (velocity, self.start_velocity):
            values[nodes, axes] = speeds[domain.driven_axes[here]]
        arrays.set_values(self.v, velocity.reshape(-1))

    @property
    def rows_at_once(self) -> int:
        """Largest number of rows of one call of `advance`."""
        if self.domain.small and self.serial is not None:
            return self.serial.rows_at_once
        return len(self._raw)

    def prepare(self, time: float, before: float, after: float, rows: int) -> int:
        """Compute what functions of time give for the rows of a launch, see `Timed`; return how many there may be."""
        for term in self.timed:
            rows = min(rows, term.rows_at_once(self.domain.small or self.device is not None))
        for term in self.timed:
            term.prepare(time, before, after, rows)
        return rows

    def ask(self, time: float, steps: tuple[float, float], rows: int) -> int:
        """Ask the functions of time for the rows of a call of `advance`; return how many there may be.

        Raises `FunctionError`, before anything moves.
        """
        rows = self.prepare(time, *steps, rows)
        apart = self.serial is not None and not self.domain.small and self.device is None
        if apart and self.contact is not None and steps[1] > 0.0:
            rows = self.contact.obstacles.ask(time, steps[1], rows)
        return rows

    @property
    def viscous_force(self) -> Callable[[np.ndarray, np.ndarray], np.ndarray] | None:
        """Function for the viscous force [3n] of a small step [3n] from u [3n] times its duration."""
        if isinstance(self.device, DeviceContactSteps):
            return self.device.viscous_force
        return None if self.serial is None else self.serial.viscous_force

    def searches(self, steps: Sequence[StableStep]) -> StableSteps:
        """Return the search for the stable step of its bodies together."""
        device = self.device
        viscous = device if isinstance(device, DeviceContactSteps) and self.domain.viscous_cells else None
        return stable_steps(self.internal_force.without_boundary(), steps, viscous)

    def over_ranks(self, values: np.ndarray) -> np.ndarray:
        """Return the largest values [.., bodies] over all ranks that have parts of the bodies; here there is one."""
        return values

    def advance(
        self,
        kick_before: float,
        kick_after: float,
        drift: float,
        time: float,
        steps: tuple[float, float],
        rows: int = 1,
        **stop_at: float,
    ) -> int:
        """Advance: v^n = v + kick_before a, row n, v = v^n + kick_after a, u += drift v, static solve.

        time [s]: that of level n; steps [s]: those that end and start there; rows: the most to be done; stop_at: fields
        of `RowLimits`, beyond which no further row follows. Returns the rows done. Raises `FunctionError`, before
        anything moves, if a function of time fails within the first row.
        """
        force, serial = self.internal_force, self.serial
        limits = RowLimits(**stop_at)
        rows = self.ask(time, steps, rows)
        if self.device is not None:
            if self.contact is not None and steps[1] > 0.0:
                self.contact.obstacles.move(np.cumsum([time, *[steps[1]] * rows]))
            found = self._rows_on_device((kick_before, kick_after, drift), steps, rows, limits)
            self._raw[: len(found), : found.shape[1]] = found
            return len(found)
        if self.domain.small and serial is not None:
            force.set_steps(kick_before, kick_after, drift, before=steps[0])
            if self.sensors is not None:
                self.sensors.take(0, self.u, self.v)
            done = serial.run(serial.names.PASS, self.u, self.v, time, *steps, rows, limits)
            self._measure(done, steps)
            return done
        for number in range(rows):
            before = steps[0] if number == 0 else steps[1]
            if self.sensors is not None:
                self.sensors.take(number, self.u, self.v)
            if self.exchange is not None:  # nodes that another process has a copy of may have moved
                force.surface_known = False
            force.advance(self.u, self.v, kick_before, kick_after, drift, before=before)
            if self.exchange is not None:
                self.exchange(force.special_force)
            raw = self._raw[number]
            self._take_row(raw, time + number * steps[1], steps)
            if self.contact is not None and self.contact.pairs is not None:
                self._builds[number] = self.contact.pairs.rebuilds
            if number + 1 < rows and not self._calm(raw, limits):
                break
        self._measure(number + 1, steps)
        return number + 1

    def _rows_on_device(self, kicks: Kicks, steps: tuple[float, float], rows: int, limits: RowLimits) -> np.ndarray:
        """Let a GPU take steps, see `DeviceSteps.advance`; return the sums of their rows."""
        assert self.device is not None
        return self.device.advance(kicks, steps, rows, limits)

    def _take_row(self, raw: np.ndarray, time: float, steps: tuple[float, float]) -> None:
        """Move the boundary nodes of a large domain behind the force pass, and note the sums of the row."""
        serial = self.serial
        if serial is None:
            raw[:] = self.internal_force.sums()
        else:
            serial.run(serial.names.BOUNDARY, self.u, self.v, time, *steps)
            raw[:] = serial.rows(1)[0]

    def _calm(self, raw: np.ndarray, limits: RowLimits) -> bool:
        """Return whether the steps may go on behind a row: it is within the limits, and its static solve converged."""
        return self._within(self._watched(raw), limits)

    @staticmethod
    def _within(watched: Sequence[float], limits: RowLimits) -> bool:
        """Return whether what is watched of a row is within the limits."""
        total, lowest, rate, count, turn, trouble = watched
        within = total <= limits.energy and lowest > limits.jacobian
        within = within and not count > limits.contact_nodes and not rate > limits.viscous_rate
        return bool(within and turn <= limits.rigid_rate and not trouble)

    def _watched(self, raw: np.ndarray) -> Sequence[float]:
        """Return what decides it: energy [J], least det F, viscous rate, contact nodes, rigid rate, 1 for a trouble."""
        places, contact = self._places, self.contact
        energy = raw[places.nodes.kinetic] + raw[places.cells.elastic]
        if self.serial is not None or isinstance(self.device, DeviceTermSteps):
            energy += raw[places.shared.kinetic]
        rate = 0.0 if self.domain.viscosity is None else raw[places.cells.viscous_rate]
        touching, trouble = (0.0, 0.0) if contact is None else (raw[places.shared.contact_nodes], bool(contact.trouble))
        turn = 0.0 if self.rigid is None else raw[self._rate_place]
        return energy, raw[places.cells.jacobian_min], rate, touching, turn, trouble

    def _measure(self, done: int, steps: tuple[float, float]) -> None:
        """Let the sensors measure the rows that were done; steps [s]: as in `advance`."""
        if self.sensors is None:
            return
        samples = None if self.serial is None else self.serial.samples()
        if samples is not None:
            self.sensors.take_rows(done, samples)
        self.sensors.take(done, self.u, self.v)
        own = self.own_views
        self.sensors.measure(done, *steps, lambda i: own[i].points(), lambda i: own[i].strains())

    def rows(self, times: np.ndarray) -> np.ndarray:
        """Return the measured rows [n, width] (measured.Layout) of the last `advance`, at these times [s]."""
        small = self.domain.small and self.serial is not None
        raw = self.serial.rows(len(times)) if small and self.serial is not None else self._raw[: len(times)]
        rows = self._reader.measured(raw, times, self.domain.gravity, self._mass)
        if self.contact is not None and self.contact.pairs is not None:
            place, before = self.layout.place["pair_rebuilds"], self.rebuilds_before
            self.rebuilds_before = self.contact.pairs.rebuilds  # at the end of the launch of these rows
            rows[:-1, place], rows[-1, place] = before, self.rebuilds_before
            if not small and self.device is None:
                rows[:, place] = self._builds[: len(rows), None]
            rows[:, self.layout.place["solver_products"]] = rows[:, self.layout.place["sweeps"]]
        if self.sensors is not None:
            self.sensors.put(rows, times)
        if self.layered is not None:
            late = float(rows[-1, self.layout.place["friction_after"]][0])
            for name, value in self.layered.row(late).items():
                found = np.atleast_1d(value)  # on a GPU of every row
                rows[-len(found) :, self.layout.place[name]] = found[:, None]
        return rows

    def memory(self) -> dict[str, int]:
        """Return the bytes of the terms."""
        result = {"state": arrays.size_in_bytes([self.u, self.v])}
        if self.serial is not None:
            result["internal-force"] = arrays.size_in_bytes(self.serial.owned())
        if self.sensors is not None:
            result["sensors"] = arrays.size_in_bytes(self.sensors.owned())
        friction = None if self.contact is None else self.contact.friction
        cells = self.contact.cell_viscosity if isinstance(self.contact, MasslessContactTerm) else None
        for term in (
            self.internal_force,
            self.boundary_nodes,
            self.supports,
            self.contact,
            friction,
            cells,
            self.images,
            self.rigid,
            self.device,
        ):
            if term is not None:
                result[term.name] = result.get(term.name, 0) + arrays.size_in_bytes(term.owned())
        return result
