"""What a step does beside the parallel force pass, and whole steps of small domains: one launch on one thread."""

from __future__ import annotations

import numpy as np

from ...cells.internal_force import InternalForce
from ...contact.bundles import (
    behind_body,
    boundary_bundle,
    contact_bundles,
    place_behind_body,
    rigid_bundle,
    solve_bundles,
    support_bundle,
    within_limit,
)
from ...contact.copied_solve import CopiedSolve
from ...contact.layered_friction import LayeredFriction
from ...contact.massless_contact import MasslessContactTerm
from ...contact.pairs.pair_contact import PairContact
from ...contact.shared_solve import SharedSolve
from ...contact.term import ContactTerm
from ...device import arrays
from ...device.launch import Prepared
from ...kernels.columns import group_size
from ...kernels.lanes import MAXIMUM_ROWS
from ...nodes.applied_loads import AppliedLoads
from ...nodes.boundary_nodes import BoundaryNodes, Supports
from ...nodes.images import PeriodicImages
from ...nodes.rigid_bodies import RigidBodies
from ...planning.domain import Domain
from ..sensors import Sensors
from .row_limits import NO_LIMITS, RowLimits


class SerialStep:
    """The launch and its arrays; what the bodies do not have is neither compiled nor handed over.

    groups: of the columns in its raw rows (`measured.raw_groups`).
    """

    def __init__(
        self,
        domain: Domain,
        groups: tuple[str, ...],
        force: InternalForce,
        boundary: BoundaryNodes | None,
        supports: Supports | None,
        contact: ContactTerm | None,
        images: PeriodicImages | None = None,
        loads: AppliedLoads | None = None,
        sensors: Sensors | None = None,
        rigid: RigidBodies | None = None,
    ) -> None:
        from ...kernels.language.bundles import ContactOptions, Coupling, Launch
        from ...kernels.language.signatures import MAXIMUM_ARGUMENTS, arguments, signature_of
        from ...kernels.step import launch_control
        from ...kernels.step import serial_step as kernels

        self.names = launch_control
        self.force = force
        self.contact, self.loads, self.rigid = contact, loads, rigid
        self.copies: SharedSolve | CopiedSolve | None = None  # where ranks share the contact
        self.counted = None if domain.counted is None else arrays.put(domain.counted)
        self.kinds = ContactOptions() if contact is None else contact.options
        self.sums = arrays.zeros(group_size(*groups[groups.index("boundary") :]))
        solve = contact.static_solve if isinstance(contact, MasslessContactTerm) else None
        self.cells = contact.cell_viscosity if isinstance(contact, MasslessContactTerm) else None
        self.pairs: PairContact | None = None if contact is None else contact.pairs
        pairs = self.pairs
        self._scratch: arrays.Array | None = None
        self.rows_at_once = MAXIMUM_ROWS if domain.small and not self.kinds.layered else 1
        if sensors is not None:
            self.rows_at_once = min(self.rows_at_once, sensors.rows)
        self.control = arrays.zeros(launch_control.CONTROL + (loads is not None))
        self.width = group_size(*groups)
        self.raw = arrays.zeros(self.rows_at_once * self.width)
        bundles = {
            "body": force.bundle(),
            "boundary": boundary_bundle(boundary, self.sums),
            "supports": support_bundle(supports, self.sums),
            **contact_bundles(contact, self.sums, counted=self.counted),
            "coupling": Coupling() if pairs is None else Coupling(pairs.lists, pairs.values),
            **solve_bundles(solve),
            "rigid": rigid_bundle(rigid, self.sums),
            "launch": Launch(
                None if self.cells is None else self.cells.data,
                None if images is None else images.pairs,
                self._samples(sensors),
                self.control,
                self.raw,
            ),
        }
        bundles = within_limit(bundles, solve)
        if self._scratch is not None and len(arguments(bundles)) > MAXIMUM_ARGUMENTS:
            # the host samples every row instead
            self.rows_at_once, self._scratch = 1, None
            bundles["launch"] = bundles["launch"]._replace(samples=None)
        self._parts = behind_body(bundles)
        self.kernel = kernels.make_serial_step(
            signature_of(bundles),
            domain.kinds,
            None if contact is None else contact.kernel,
            self.kinds,
            contact is not None and contact.plain,
            boundary is not None,
            supports is not None,
            domain.small,
            domain.few_contact_cells,
            tied=images is not None,
            loaded="" if loads is None else "loads",
            driven=supports is not None and supports.driven,
            has_springs=bool(domain.springs),
            rigid_bodies=rigid is not None,
            **domain.options,
        )
        self._first_row = place_behind_body(bundles, "coupling")
        self._launch = Prepared(self.kernel)
        self._exact = 1.0 if contact is None or contact.exact else 0.0

    def run(
        self,
        start: int,
        u: arrays.Array,
        v: arrays.Array,
        time: float,
        before: float,
        after: float,
        rows: int = 1,
        limits: RowLimits = NO_LIMITS,
    ) -> int:
        """Do up to `rows` rows and return how many were done; start: PASS, BOUNDARY or PLACE of the kernel file.

        time [s]: of the present level; before, after [s]: the steps that end and start there. It stops after a row
        beyond the limits, or with a static solve that did not converge.
        """
        names = self.names
        contact = self.contact
        if self.pairs is not None:
            self.pairs.begin_step()
        if contact is not None and after > 0.0 and start != names.PLACE:
            contact.obstacles.move(np.cumsum([time, *[after] * rows]))
        if self.rigid is not None:
            self.rigid.set_limit(limits.rigid_rate)
        control = np.zeros(names.CONTROL + (self.loads is not None))
        control[: names.ROWS_DONE] = start, rows, before, after, self._exact, limits.jacobian, limits.energy
        control[names.KNOWN] = float(self.force.surface_known)
        control[names.FIRST] = 1.0
        control[names.RATE_LIMIT], control[names.CONTACT_LIMIT] = limits.viscous_rate, limits.contact_nodes
        if start == names.BOUNDARY and self.copies is None:
            self._measure_viscosity(u, v, before)
        control = self._go(control, u, v)
        if control[names.WANTS_LAYERS] == 1.0:
            assert contact is not None
            if self.copies is not None:
                self.copies.share_residual()
            else:
                assert isinstance(contact.friction, LayeredFriction)
                contact.friction.step(before, after)
            control[names.START] = names.KICK
            control = self._go(control, u, v)
        done = int(control[names.ROWS_DONE])
        if self.pairs is not None:
            self.pairs.steps += done
        if self.loads is not None and control[names.WANTS_LOADS] == 1.0:
            self.loads.ask(u, time + after, after)
            stale = control[names.WANTS_ROWS]
            control[names.START], control[names.WANTS_LOADS] = names.LOADS, 0.0
            control = self._go(control, u, v)
            control[names.WANTS_ROWS] = max(stale, control[names.WANTS_ROWS])
        if self.copies is not None and control[names.WANTS_MEASURE] == 1.0:
            if control[names.WANTS_ROWS] == 1.0:
                self.build_rows(u)
            self.copies.solve(u, v)
            return done
        while control[names.WANTS_ROWS] == 1.0 or control[names.WANTS_MEASURE] == 1.0:
            if control[names.WANTS_ROWS] == 1.0:
                self.build_rows(u)
                if self.kinds.model != "massless":
                    break
            if control[names.WANTS_MEASURE] == 1.0:
                self.force.measure_surface(u, v)
                if self.cells is not None and self.cells.launch is not None:
                    self.cells.measure(u, v)
            control[names.START] = names.MEASURED
            control = self._go(control, u, v)
        return done

    def _measure_viscosity(self, u: arrays.Array, v: arrays.Array, before: float) -> None:
        """Compute the viscous forces of many contact cells at a level; before [s]: the step that ends there."""
        if self.cells is not None and self.cells.launch is not None:
            self.cells.set_rate(1.0 / before if before > 0.0 else 0.0)
            self.cells.measure(u, v)

    def add_viscosity(self, u: arrays.Array, v: arrays.Array, before: float) -> None:
        """Add the viscous force of the contact cells of this rank to its forces, which ranks then add up.

        before [s]: the step that ends at the present level.
        """
        if self.cells is None:
            return
        self._measure_viscosity(u, v, before)
        control = np.zeros(self.names.CONTROL + (self.loads is not None))
        control[self.names.START], control[self.names.BEFORE] = self.names.VISCOUS, before
        self._go(control, u, v)

    def build_rows(self, u: arrays.Array) -> None:
        """Build the rows of pairs of bodies anew."""
        assert self.pairs is not None
        self.pairs.rebuild(arrays.get(u).reshape(-1, 3))

    def _go(self, control: np.ndarray, u: arrays.Array, v: arrays.Array) -> np.ndarray:
        """Launch the kernel once; return `control` as it left it."""
        if self.pairs is not None:
            rows = self.pairs.owned()  # larger ones may have taken their place
            first = self._first_row
            if any(part is not row for part, row in zip(self._parts[first:], rows, strict=False)):
                self._parts = (*self._parts[:first], *rows, *self._parts[first + len(rows) :])
        arrays.set_values(self.control, control)
        self._launch(*self.force.arguments(u, v), *self._parts)
        left = arrays.get(self.control)
        self.force.surface_known = bool(left[self.names.KNOWN] == 1.0)
        return left

    def _samples(self, sensors: Sensors | None) -> arrays.Array | None:
        """Return the array of samples (kernels/step/samples.py); None where the host samples single rows."""
        if sensors is not None and self.rows_at_once > 1:
            head = np.array([len(sensors.nodes), *sensors.nodes], dtype=np.float64)
            room = np.zeros(6 * len(sensors.nodes) * self.rows_at_once)
            self._scratch = arrays.put(np.concatenate([head, room]))
        return self._scratch

    def samples(self) -> np.ndarray | None:
        """Return the samples [rows, k, 6] of the last run; None if it took none."""
        if self._scratch is None:
            return None
        values = arrays.get(self._scratch)
        count = int(values[0])
        return values[1 + count :].reshape(self.rows_at_once, count, 6)

    def rows(self, count: int) -> np.ndarray:
        """Return the raw rows [count, width] of the last run."""
        return arrays.get(self.raw).reshape(-1, self.width)[:count]

    def viscous_force(self, u: np.ndarray, step: np.ndarray) -> np.ndarray:
        """Return the viscous force [3n] of a small step [3n] to u [3n] times its duration; 0 without viscous cells."""
        if self.cells is None:
            return np.zeros_like(u)
        cells = self.cells

        def measure(present: arrays.Array) -> None:
            velocity = arrays.zeros(len(u))
            if cells.launch is not None:
                cells.measure(present, velocity)
                return
            control = np.zeros(self.names.CONTROL)
            control[self.names.START] = self.names.VISCOUS
            self._go(control, present, velocity)

        return cells.product(u, step, measure)

    def use_for_products(self) -> None:
        """Let the force pass of the body go through this kernel, so that no other one is compiled."""
        control = np.zeros(self.names.CONTROL)
        control[self.names.START] = self.names.PRODUCT
        parts = (*self._parts[:-2], arrays.put(control), self.raw)
        launch = Prepared(self.kernel)
        numbers = 3 if self.force.memory is None else 4  # that come before the arrays: chunks, ranges, commit
        self.force.kernel = lambda *given: launch(*given[numbers:], *parts)

    def owned(self) -> list[arrays.Array]:
        """Return the arrays of the launch itself."""
        return [self.raw, self.control, self.sums, *([] if self._scratch is None else [self._scratch])]
