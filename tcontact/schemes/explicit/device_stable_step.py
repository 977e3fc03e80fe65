"""The search for the stable step on a GPU: the vectors stay there, the host reads a few numbers at the end.

It does what `StableSteps` does for bodies without penalties and periodic images, with the same products and the same
first vector; that with viscous contact cells follows in `device_damped_step`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...cells.device_force import DeviceForce
from ...device import arrays
from ...device.launch import Prepared
from .device_damped_step import DeviceDampedStep, ViscousPass
from .stable_step import DIFFERENCE, PRODUCTS, StableStep, StableSteps, has_next, least

if TYPE_CHECKING:
    from .stable_step import ForcePass


def stable_steps(force: ForcePass, bodies: Sequence[StableStep], viscous: ViscousPass | None = None) -> StableSteps:
    """Return the search of a domain: on the GPU if its force pass is there and the bodies are plain.

    viscous: pass over viscous contact cells there, if there are any.
    """
    plain = all(body.penalty is None and body.plan.images is None for body in bodies)
    plain = plain and all(body.plan.viscosity is None for body in bodies)
    plain = plain and (viscous is not None or all(body.damping is None for body in bodies))
    if isinstance(force, DeviceForce) and plain:
        return DeviceStableSteps(force, bodies, viscous)
    return StableSteps(force, bodies)


class DeviceStableSteps(StableSteps):
    """`StableSteps` whose vectors are arrays of the device.

    start: the mode found last, or the first vector; searched: whether there was a search.
    """

    def __init__(self, force: DeviceForce, bodies: Sequence[StableStep], viscous: ViscousPass | None = None) -> None:
        from ...kernels.step.device_lanczos import ENTRY, SUMS, make_lanczos

        self.force, self.bodies, self._mass = force, bodies, force.mass
        self._ends = np.cumsum([3 * len(body.plan.lumped) for body in bodies])
        size, self._entry = int(self._ends[-1]), ENTRY
        self.trial, self.answer, here, current = (arrays.zeros(size) for _ in range(4))
        vectors = [body.first_vector() for body in bodies]
        self.start = arrays.put(np.concatenate(vectors))
        self._largest = [float(np.abs(vector).max()) for vector in vectors]
        self.searched = False
        counts = [min(PRODUCTS, body_size) for body_size in np.diff(self._ends, prepend=0)]
        self._kept = [
            [arrays.whole_numbers((int(end - first) + 1) // 2) for _ in range(count)]
            for (first, end), count in zip(self._ranges(), counts, strict=True)
        ]
        self._width = ENTRY * (PRODUCTS + 1) + SUMS
        partial, numbers = arrays.zeros(SUMS * force.threads), arrays.zeros(len(bodies) * self._width)
        self._scratch = [here, current, partial, numbers]
        self._damped: DeviceDampedStep | None = None
        if viscous is not None and any(body.damping is not None for body in bodies):
            self._damped = DeviceDampedStep(force, viscous, self.trial, self.answer, PRODUCTS)
        self._kernels = {name: Prepared(kernel) for name, kernel in make_lanczos(force.threads).items()}

    def _ranges(self) -> list[tuple[int, int]]:
        """Return the first number and the end of every body in a vector."""
        sizes = [3 * len(body.plan.lumped) for body in self.bodies]
        return [(int(end) - size, int(end)) for end, size in zip(self._ends, sizes, strict=True)]

    def estimate(self, u: arrays.Array, products: int = PRODUCTS) -> float:
        """Estimate the stable step [s] at displacement u [3n]; the next call starts from the modes found."""
        if any(body.pressure is not None for body in self.bodies):
            self.press(np.split(arrays.get(u), self._ends[:-1]))
        here, current, _partial, _numbers = self._scratch
        for first, end in self._ranges():
            self._kernels["begin"](u, first, end, self.trial, self.answer)
        self.force.minus_force(self.trial, self.answer)
        arrays.copy(self.answer, here)
        self._first_vectors(here, current)
        before, counts = self.start, [min(products, len(kept)) for kept in self._kept]
        for k in range(max(counts)):
            left = [number for number, count in enumerate(counts) if k < count]
            for number in left:
                self._displace(number, k, u, current)
            self.force.minus_force(self.trial, self.answer)
            for number in left:
                self._respond(number, k, here, current, before)
            before, current = current, before
        self._take(counts)
        self.searched = True
        for body, (first, end) in zip(self.bodies, self._ranges(), strict=True):
            if self._damped is not None and body.damping is not None:
                nodes = first // 3, end // 3
                body.take_damped(self._damped.search(body.damping, nodes, u, here, body.elastic, products))
        return least(self.bodies, 0.0)

    def _first_vectors(self, here: arrays.Array, current: arrays.Array) -> None:
        """Put the first vectors into `current`; here: -M^-1 f(u)."""
        partial, numbers = self._scratch[2:]
        if not self.searched:
            arrays.copy(self.start, current)
            found = np.zeros(len(self.bodies) * self._width)
            found[2 :: self._width] = self._largest
            arrays.set_values(numbers, found)
            return
        run, mass = self._kernels, self._mass
        for number, (first, end) in enumerate(self._ranges()):
            base = number * self._width
            sums_at = base + self._width - 3
            run["norms"](self.start, here, mass, first, end, partial)
            run["fold_norms"](partial, numbers, sums_at)
            run["join"](self.start, here, numbers, sums_at, first, end, current, partial)
            run["fold_largest"](partial, numbers, base + 2)

    def _displace(self, number: int, k: int, u: arrays.Array, current: arrays.Array) -> None:
        """Prepare product k of a body."""
        numbers, (first, end) = self._scratch[3], self._ranges()[number]
        at, difference = number * self._width + self._entry * k, DIFFERENCE * self.bodies[number].size
        results = self.trial, self.answer, self._kept[number][k]
        self._kernels["displace"](u, current, numbers, at, int(k > 0), difference, first, end, *results)

    def _respond(self, number: int, k: int, here: arrays.Array, current: arrays.Array, before: arrays.Array) -> None:
        """Make the next vector of a body, in `before`, and the numbers alpha and beta from product k."""
        run, mass, (partial, numbers) = self._kernels, self._mass, self._scratch[2:]
        at, difference = number * self._width + self._entry * k, DIFFERENCE * self.bodies[number].size
        first, end = self._ranges()[number]
        state = here, self.answer, current, before, mass, numbers
        run["respond"](*state, at, int(k > 0), difference, first, end, partial)
        run["fold_alpha"](partial, numbers, at)
        run["reduce"](current, before, mass, numbers, at, first, end, partial)
        run["fold_length"](partial, numbers, at)

    def _take(self, counts: Sequence[int]) -> None:
        """Read the numbers, estimate the steps of the bodies and sum up the modes for the next search."""
        found = arrays.get(self._scratch[3]).reshape(len(self.bodies), self._width)
        for number, (body, count, (first, end)) in enumerate(zip(self.bodies, counts, self._ranges(), strict=True)):
            alphas, betas, largest = found[number, : self._entry * count].reshape(count, self._entry).T
            top = body.conclude(*until_exhausted(alphas, betas))
            for k, weight in enumerate(top):
                scaled = float(weight * largest[k])
                self._kernels["add_kept"](self._kept[number][k], scaled, int(k == 0), first, end, self.start)


def until_exhausted(alphas: np.ndarray, betas: np.ndarray) -> tuple[list[float], list[float]]:
    """Return alpha and beta of the vectors up to the one after which nothing is left."""
    for k, (alpha, beta) in enumerate(zip(alphas, betas, strict=True)):
        if not has_next(alpha, alphas[0], beta):
            return list(alphas[: k + 1]), list(betas[: k + 1])
    return list(alphas), list(betas)
