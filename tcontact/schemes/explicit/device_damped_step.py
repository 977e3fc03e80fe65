"""The search for the stable step with viscous contact cells on a GPU: the vectors stay there, sums come to the host."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from ...cells.device_force import DeviceForce
from ...cells.device_viscosity import DeviceCellViscosity
from ...device import arrays
from ...device.launch import Prepared
from ...nodes.boundary_nodes import flat_tensors, tensors_of
from .damped_step import CLOSE, ROUNDS, DampedStep, limit_of, moving_parts
from .lanczos_matrix import top_mode
from .start_vectors import random_vector


class ViscousPass(Protocol):
    """What the search needs of the steps on a GPU."""

    boundary_nodes: arrays.Array
    inverse_mass: arrays.Array

    @property
    def cells(self) -> DeviceCellViscosity:
        """The viscous contact cells."""
        ...

    @property
    def corner_rows(self) -> arrays.Array:
        """Corners of the contact cells at every boundary node."""
        ...

    def measure_viscous(self, present: arrays.Array) -> None:
        """Put the viscous corner forces of a step that ends at the displacement `present` into the data of `cells`."""
        ...


class DeviceDampedStep:
    """What `DampedStep.search` does, for the bodies of a domain, with the products and the first vector of the CPU.

    trial, answer: arrays of the search without viscosity; products: most of a search. In `_product` and `_reduce` p, q
    and x are those of kernels/step/device_damped.py.
    """

    def __init__(
        self, force: DeviceForce, viscous: ViscousPass, trial: arrays.Array, answer: arrays.Array, products: int
    ) -> None:
        from ...kernels.contact.cell_viscosity import RATE
        from ...kernels.step.device_damped import LARGEST, SUMS, make_damped_lanczos

        self.force, self.viscous, self.trial, self.answer = force, viscous, trial, answer
        size = int(np.prod(trial.shape))
        self.start, self._p, self._q, self._x = (arrays.zeros(size) for _ in range(4))
        self._searched: set[int] = set()
        self._partial, self._numbers = arrays.zeros((SUMS + 1) * force.threads), arrays.zeros(SUMS + 1)
        self._kept = [arrays.whole_numbers(size) for _ in range(products)]
        # what these launches take of the steps as it is, alone
        given = viscous.boundary_nodes, viscous.inverse_mass, viscous.corner_rows
        self._nodes, self._inverse_mass, self._corner_rows = map(arrays.alone, given)
        self._moving = arrays.put(flat_tensors(moving_parts(tensors_of(arrays.get(self._inverse_mass)))))
        self._saved = arrays.zeros(int(np.prod(viscous.cells.data.shape)))
        self._run = {name: Prepared(kernel) for name, kernel in make_damped_lanczos(force.threads).items()}
        self._rate_place, self._largest = RATE, LARGEST

    def search(
        self,
        body: DampedStep,
        nodes: tuple[int, int],
        u: arrays.Array,
        here: arrays.Array,
        elastic: float,
        products: int,
    ) -> float:
        """Search the stable step [s] of a body at displacement u, see `DampedStep.search`.

        nodes: its first node and the end; here: -M^-1 f(u); elastic [s]: step to begin with.
        """
        data = self.viscous.cells.data
        arrays.copy(data, self._saved)
        arrays.copy(u, self.trial)  # the other bodies stay where they are
        self._run["take_places"](u, self._nodes, data)
        arrays.set_values(data, np.ones(1), self._rate_place)
        dt = elastic
        for _ in range(ROUNDS):
            over = self._mode(body, nodes, u, here, 2.0 / dt, products)
            unit, largest = self._begin(nodes)
            sums = self._product(body, nodes, u, here, 1.0, largest, 0.0, 0.0, 0)
            k, c = (over * value / unit for value in sums[1:3])
            before, dt = dt, limit_of(k, c, dt)
            if abs(dt - before) <= CLOSE * dt:
                break
        arrays.copy(self._saved, data)
        return float(dt)

    def _begin(self, nodes: tuple[int, int]) -> tuple[float, float]:
        """Take the start vector as q; return q.M^-1 q and the largest number of M^-1 q."""
        arrays.copy(self.start, self._q)
        return self._reduce(nodes, 0.0)

    def _mode(
        self, body: DampedStep, nodes: tuple[int, int], u: arrays.Array, here: arrays.Array, rate: float, products: int
    ) -> float:
        """Search the fastest mode of M^-1 (K + rate C) as `DampedStep` does; its momenta are `start` then."""
        if nodes[0] not in self._searched:
            self._searched.add(nodes[0])
            first = random_vector(3 * (nodes[1] - nodes[0]))
            arrays.set_values(self.start, first, 3 * nodes[0])
        square, largest = self._begin(nodes)
        length, beta = float(np.sqrt(square)), 0.0
        alphas: list[float] = []
        betas: list[float] = []
        for k in range(min(products, body.count)):
            sums = self._product(body, nodes, u, here, 1.0 / length, largest, rate, beta, k)
            alphas.append(float(sums[0]))
            square, largest = self._reduce(nodes, alphas[-1])
            beta = length = float(np.sqrt(max(square, 0.0)))
            betas.append(beta)
            if beta <= 1e-9 * max(abs(alphas[-1]), abs(alphas[0])):
                break
        value, residual, top = top_mode(alphas, betas, body.plan)
        for k, weight in enumerate(top):
            self._run["add_kept"](self._kept[k], float(weight), int(k == 0), *nodes, self.start)
        return 1.0 + residual / value if value > 0.0 else 0.0

    def _product(
        self,
        body: DampedStep,
        nodes: tuple[int, int],
        u: arrays.Array,
        here: arrays.Array,
        by: float,
        largest: float,
        rate: float,
        beta: float,
        k: int,
    ) -> np.ndarray:
        """Multiply q and x by a number to make p and x of vector k; return x.q, x.K x and x.C x of the next q."""
        viscous, run, info = self.viscous, self._run, self.force.info
        self._p, self._q = self._q, self._p  # q of the vector before becomes p, and p makes room
        scale = body.small / (by * largest)
        data = viscous.cells.data
        run["displace"](u, info, self._p, self._x, by, scale, *nodes, self.trial, self.answer, data, self._kept[k])
        self.force.minus_force(self.trial, self.answer)
        viscous.measure_viscous(u)
        state = here, self.answer, self.force.mass, info, self._corner_rows, data, self._x, self._q
        run["respond"](*state, rate, beta, 1.0 / scale, *nodes, self._partial)
        return self._folded()

    def _reduce(self, nodes: tuple[int, int], alpha: float) -> tuple[float, float]:
        """Take alpha p and what moves nothing off q and set x; return q.x and the largest number of x."""
        mass = self.force.mass, self._inverse_mass, self._moving, self.force.info
        self._run["reduce"](self._q, self._p, self._x, *mass, alpha, *nodes, self._partial)
        sums = self._folded()
        return float(sums[0]), float(sums[self._largest])

    def _folded(self) -> np.ndarray:
        """Return the sums of the last launch and its largest number."""
        self._run["fold"](self._partial, self._numbers, 0)
        return np.array(arrays.get(self._numbers))

    def owned(self) -> list[arrays.Array]:
        """Return the arrays of the search."""
        vectors = [self.start, self._p, self._q, self._x, *self._kept]
        return [*vectors, self._partial, self._numbers, self._moving, self._saved]
