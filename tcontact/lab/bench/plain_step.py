"""The plain explicit step, the yardstick: force by atomic adds, then one loop over the nodes; no sums, no history.

v <- v - dt f/m,   u <- u + dt v,   f <- 0
"""

import functools
from typing import Any

import numpy as np

from ...device import arrays, runtime
from ...device.launch import Prepared
from ...kernels.lanes import MATERIALS
from ...planning.body_plan import BodyPlan


@functools.cache
def make_plain_update() -> Any:
    """Return the kernel plain_update(force, mass, dt, u, v), which moves the nodes and clears the force."""
    from ...kernels.language.arguments import ARRAY

    ti = runtime.load()

    @ti.kernel
    def plain_update(force: ARRAY, mass: ARRAY, dt: ti.f64, u: ARRAY, v: ARRAY):  # type: ignore[name-defined]
        for i in range(mass.shape[0]):
            scale = dt / mass[i]
            for c in ti.static(range(3)):
                speed = v[3 * i + c] - scale * force[3 * i + c]
                v[3 * i + c] = speed
                u[3 * i + c] = u[3 * i + c] + dt * speed
                force[3 * i + c] = 0.0

    return plain_update


@functools.cache
def make_copy() -> Any:
    """Return the kernel copy(source, target)."""
    from ...kernels.language.arguments import ARRAY

    ti = runtime.load()

    @ti.kernel
    def copy(source: ARRAY, target: ARRAY):
        for i in range(source.shape[0]):
            target[i] = source[i]

    return copy


class PlainStep:
    """The body of a plan, stepped plainly, on the same numbering and with prepared launches too."""

    def __init__(self, plan: BodyPlan, displacement: np.ndarray, velocity: np.ndarray, dt: float) -> None:
        from ...kernels.cells.plain_force import make_plain_force

        material = plan.body.material
        self.connectivity = arrays.put(plan.cells)
        self.position = arrays.put(plan.reference)
        self.mass = arrays.put(plan.lumped)
        self.parameters = arrays.put(np.array([0.0] * MATERIALS + [*material.parameters]))
        self.u, self.v = arrays.put(displacement), arrays.put(velocity)
        self.force = arrays.zeros(displacement.size)
        self.dt = dt
        self._add_force = Prepared(make_plain_force(plan.element, material.law))
        self._update = Prepared(make_plain_update())

    def step(self) -> None:
        """Do one step."""
        self.add_force()
        self._update(self.force, self.mass, self.dt, self.u, self.v)

    def add_force(self) -> None:
        """Add dW/du at u to the force."""
        self._add_force(self.connectivity, self.position, self.parameters, self.u, self.force)

    def size_in_bytes(self) -> int:
        """Return the bytes of its arrays."""
        own = [self.connectivity, self.position, self.mass, self.parameters, self.u, self.v, self.force]
        return arrays.size_in_bytes(own)
