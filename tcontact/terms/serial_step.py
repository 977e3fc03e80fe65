"""What a step does beside the parallel force pass, and whole steps of small bodies: one launch on one thread."""

from __future__ import annotations

import numpy as np

from .. import arrays
from ..launch import Prepared
from ..plan import BodyPlan
from .boundary_nodes import BoundaryNodes, Supports
from .contact import ContactTerm
from .images import PeriodicImages
from .internal_force import InternalForce

MOST_ROWS = 256  # in one launch


class SerialStep:
    """The launch and its arrays; terms that the body does not have are not compiled and share two dummies."""

    def __init__(
        self,
        plan: BodyPlan,
        force: InternalForce,
        listed: BoundaryNodes | None,
        supports: Supports | None,
        contact: ContactTerm | None,
        images: PeriodicImages | None = None,
    ) -> None:
        from ..kernels import serial_step as kernels

        self.names = kernels
        self.force = force
        self.rows_at_once = MOST_ROWS if plan.small else 1
        real, whole = arrays.zeros(16), arrays.put(np.zeros(1, dtype=np.int32))
        own = None if contact is None else contact.arguments()
        none = _dummies(real, whole)
        parts: list[arrays.Array] = []
        parts += (whole, real, real, real, real) if listed is None else listed.arguments()
        parts += (whole, whole, real, real) if supports is None else supports.arguments()
        parts += none if own is None else (*own, *none[len(own) :])
        parts.append(whole if images is None else images.pairs)
        self.control = arrays.zeros(kernels.CONTROL)
        self.width = kernels.row_width(plan.viscosity is not None)
        self.raw = arrays.zeros(self.rows_at_once * self.width)
        self._parts = (*parts, self.control, self.raw)
        self.kernel = kernels.make_serial_step(
            plan.variant,
            plan.body.material.law,
            None if contact is None else contact.kernel,
            1 if contact is None else contact.block,
            1 if contact is None else contact.slots,
            contact is not None and contact.plain,
            listed is not None,
            supports is not None,
            plan.small,
            tied=images is not None,
            **plan.options,
        )
        self._launch = Prepared(self.kernel)
        self._planes = 0 if contact is None else contact.plane_count
        self._exact = 1.0 if contact is None or contact.exact else 0.0

    def run(
        self,
        start: int,
        u: arrays.Array,
        v: arrays.Array,
        before: float,
        after: float,
        rows: int = 1,
        jacobian: float = -np.inf,
        energy: float = np.inf,
        viscous_rate: float = np.inf,
    ) -> int:
        """Rows that were done, of at most `rows`; start: PASS, BOUNDARY or PLACE of the kernel file.

        before, after [s]: the steps that end and start at the present level. It stops after a row with a det F of at
        most `jacobian`, an energy above `energy` [J], a viscous rate above `viscous_rate` [1/s] or a static solve that
        did not converge.
        """
        names = self.names
        control = np.zeros(names.CONTROL)
        control[: names.ROWS_DONE] = start, rows, before, after, self._planes, self._exact, jacobian, energy
        control[names.FIRST], control[names.RATE_LIMIT] = 1.0, viscous_rate
        arrays.set_values(self.control, control)
        self._launch(*self.force.arguments(u, v), *self._parts)
        control = arrays.get(self.control)
        done = int(control[names.ROWS_DONE])
        while control[names.WANTS_MEASURE] == 1.0:
            self.force.measure_surface(u, v)
            control[names.START] = names.MEASURED
            arrays.set_values(self.control, control)
            self._launch(*self.force.arguments(u, v), *self._parts)
            control = arrays.get(self.control)
        return done

    def rows(self, count: int) -> np.ndarray:
        """Raw rows [count, width] of the last run."""
        return arrays.get(self.raw).reshape(-1, self.width)[:count]

    def use_for_products(self) -> None:
        """Let the force pass of the body go through this kernel, so that no other one is compiled."""
        control = np.zeros(self.names.CONTROL)
        control[self.names.START] = self.names.PRODUCT
        parts = (*self._parts[:-2], arrays.put(control), self.raw)
        launch = Prepared(self.kernel)
        self.force.kernel = lambda _first, _end, _ranges, *body: launch(*body, *parts)

    def owned(self) -> list[arrays.Array]:
        """Arrays of the launch itself."""
        return [self.raw, self.control]


def _dummies(real: arrays.Array, whole: arrays.Array) -> tuple[arrays.Array, ...]:
    """Stand-ins for the arrays of Touching, Pairs and System."""
    touching = (whole, real, whole, real, whole, real, real, real, real, real, whole, real, whole, whole)
    pairs = (whole, real, real, whole, whole, whole, real, whole, whole, whole, whole)
    system = (whole, whole, whole, whole, whole, *(real,) * 10)
    return (*touching, *pairs, *system)
