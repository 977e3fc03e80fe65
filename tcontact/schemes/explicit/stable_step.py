"""Estimate the stable step 2/omega_max of the free body with its ordinary lumped mass by Lanczos.

Force products M^-1 K w come from the force pass itself, as differences about the present state; the estimate is
0.98 * 2/sqrt(ritz value + residual), on the safe side of the true limit and at least 90 % of it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Protocol

import numpy as np

from ...base.errors import InputError
from ...device import arrays
from ...mesh.geometry import chunks_of, spanned_heights
from ...planning.body_plan import BodyPlan
from ...planning.pressure_rates import PressureRate
from ...scene.obstacles import Obstacle
from .damped_step import DampedStep, Search, ViscousForce
from .lanczos_matrix import top_mode
from .long_vectors import Vectors, dot, nodes_of, portions
from .start_vectors import random_vector

PRODUCTS = 20
SAFETY = 0.98
DIGITS = 14  # binary ones of a step that was shortened
DIFFERENCE = 1e-6  # largest displacement of a product, over the size of the smallest cell


class ForcePass(Protocol):
    """The force pass over several bodies in one numbering that the estimate needs."""

    def minus_force(self, u: arrays.Array, out: arrays.Array) -> None:
        """Add -f(u)/mass to out; both [3n]."""
        ...

    def sum_of(self, name: str) -> float:
        """Return a sum over the cells of the last pass by the name of its column."""
        ...


class StableSteps:
    """Estimates the stable step of every body of a domain; one pass does a product of all searches."""

    def __init__(self, force: ForcePass, bodies: Sequence[StableStep]) -> None:
        self.force, self.bodies = force, bodies
        self._ends = np.cumsum([3 * len(body.plan.lumped) for body in bodies])
        self.trial, self.answer = arrays.zeros(int(self._ends[-1])), arrays.zeros(int(self._ends[-1]))
        # the searches write and read these: the arrays of the pass themselves on the CPU
        self._raw = [np.array(host) if host is not device else host
                     for device, host in ((part, arrays.get(part)) for part in (self.trial, self.answer))]  # fmt: skip
        for body, trial, answer in zip(bodies, *(np.split(part, self._ends[:-1]) for part in self._raw), strict=True):
            body.trial, body.answer = trial, answer

    @np.errstate(over="ignore", invalid="ignore")  # what overflows is refused by name (`forces overflow`)
    def estimate(self, u: arrays.Array, products: int = PRODUCTS) -> float:
        """Estimate the stable step [s] at displacement u [3n]; the next call starts from the modes found."""
        parts = np.split(arrays.get(u), self._ends[:-1])
        self.press(parts)
        searches = [body.search(part, products) for body, part in zip(self.bodies, parts, strict=True)]
        left = {number: search for number, search in enumerate(searches) if next(search, True)}
        while left:
            self._accelerate()
            for number in [number for number, search in left.items() if not next(search, False)]:
                del left[number]
                self.bodies[number].trial[:] = parts[number]
        rate = 0.0 if self.bodies[0].plan.viscosity is None else self._rate()
        return least(self.bodies, rate)

    def press(self, parts: Sequence[np.ndarray]) -> None:
        """Let every body take the stiffness of its pressures at its displacement [3n]."""
        for body, part in zip(self.bodies, parts, strict=True):
            body.press(part)

    def _rate(self) -> float:
        """Return the largest rate of bulk viscosity [1/s] in the last pass."""
        return self.force.sum_of("viscous_rate")

    @property
    def elastic(self) -> float:
        """The last estimate [s] without viscosity."""
        return min(body.elastic for body in self.bodies)

    @property
    def damped(self) -> float:
        """The last estimate [s] with the viscosity of the contact cells alone."""
        return min(body.damped for body in self.bodies)

    def _accelerate(self) -> None:
        """Put -M^-1 f(u) of the displacement in `trial` into `answer`."""
        trial, answer = self._raw
        answer[:] = 0.0
        if trial is not self.trial:
            arrays.set_values(self.trial, trial)
            arrays.set_values(self.answer, answer)
        self.force.minus_force(self.trial, self.answer)
        if trial is not self.trial:
            answer[:] = arrays.get(self.answer)


class StableStep:
    """The search for the stable step of one body; `StableSteps` supplies the force products.

    stiffness [N/m^3]: penalty per area of contact nodes with mass, taken as closed: along the normals of planes that do
    not turn, along all directions for other obstacles and bodies; viscous_force: force of viscous contact cells;
    springs [k] [m^2]: areas with which it acts on a body in contact with others (planning/closed_springs.py);
    spring_rate [1/s^2]: bound of omega^2 of the springs between sets of nodes alone, which adds to that of the body;
    pressure: the same of the pressures on it, None without.
    """

    def __init__(
        self,
        plan: BodyPlan,
        obstacles: Sequence[Obstacle],
        stiffness: float | None,
        viscous_force: ViscousForce | None = None,
        springs: np.ndarray | None = None,
        spring_rate: float = 0.0,
        pressure: PressureRate | None = None,
    ) -> None:
        self.plan, self.spring_rate, self.pressure = plan, spring_rate, pressure
        self.added_rate = spring_rate  # [1/s^2] of springs and pressures at the last estimate
        self.mass = plan.lumped  # [n] [kg] of the whole nodes
        self.trial = self.answer = np.zeros(0)
        self.count = 3 * len(plan.lumped)  # components, and so modes, of the body
        self.bound, self.size = self._cell_bounds()
        contact = plan.contact
        self.penalty = None
        if stiffness is not None and contact is not None:
            self.penalty = stiffness * (contact.areas if springs is None else springs)
        fixed = all(obstacle.shape == "plane" and not obstacle.turns for obstacle in obstacles) and springs is None
        self.normals = np.array([obstacle.frame[2] for obstacle in obstacles]) if fixed else np.eye(3)
        self.start: np.ndarray | None = None
        self.elastic = np.inf  # last estimate without viscosity [s]
        self.damped = np.inf  # last estimate with the viscosity of the contact cells alone [s]
        self.damping = None
        if plan.viscous_cells and viscous_force is not None:
            self.damping = DampedStep(plan, self.stiffness_product, viscous_force, DIFFERENCE * self.size)

    def _cell_bounds(self) -> tuple[np.ndarray | None, float]:
        """Return (wave speed over height)^2 of the stiffest cell at every node [1/s^2], and the smallest height [m]."""
        bound, smallest = np.zeros(self.plan.node_count), np.inf
        for block in self.plan.blocks:
            height = spanned_heights(block.own.kind, self.plan.places, block.rows)
            with np.errstate(over="ignore"):  # as in `estimate`
                rate = (block.own.material.wave_speed / height) ** 2
            for part in chunks_of(len(rate)):
                np.maximum.at(bound, block.rows[part], rate[part, None])
            smallest = min(smallest, float(height.min()))
        return bound, smallest

    def press(self, u: np.ndarray) -> None:
        """Take the stiffness of the pressures at displacement u [3n]."""
        if self.pressure is not None:
            self.added_rate = self.spring_rate + self.pressure.bound(u.reshape(-1, 3)[self.pressure.rows])

    def stiffness_product(self, u: np.ndarray, here: np.ndarray, vector: np.ndarray) -> Search:
        """Return K(u) vector [N] of the free body; here: -M^-1 f(u)."""
        scale = DIFFERENCE * self.size / self._most(float(np.abs(vector).max(initial=0.0)))
        self.trial[:] = u + scale * vector
        yield True
        return np.repeat(self.plan.lumped, 3) * (here - self.answer) / scale

    def _corrected(self, product: np.ndarray, vector: np.ndarray) -> np.ndarray:
        """Return M^-1 K vector with penalties and images; product [3n]: without, changed in place."""
        if self.penalty is not None and self.plan.contact is not None:
            nodes = self.plan.contact.nodes
            part = vector.reshape(-1, 3)[nodes]
            for normal in self.normals:
                stiff = (self.penalty * (part @ normal) / self.mass[nodes])[:, None] * normal
                product.reshape(-1, 3)[nodes] += stiff
        return self._tied(product)

    def _tied(self, acceleration: np.ndarray) -> np.ndarray:
        """Average the acceleration [3n] over images of a periodic body; its modes are among those of the free body."""
        if self.plan.images is None:
            return acceleration
        return self.plan.images.mean(acceleration.reshape(-1, 3), self.plan.lumped).reshape(-1)

    def _first(self, here: np.ndarray) -> np.ndarray:
        """Return a start vector of length 1: the mode found last plus the acceleration [3n], which is large where
        the body has stiffened since; in the first search a random one, large where cells are small."""
        if self.start is not None:
            found = self._unit(self.start) + self._unit(self._tied(here))
            return self._unit(found if self._most(float(found.any())) > 0.0 else self.start)
        found = random_vector(here.size)
        found.reshape(-1, 3)[:] *= self.first_sizes()[:, None]
        if self.plan.images is not None:
            found = self.plan.images.follow(found.reshape(-1, 3)).reshape(-1)
        return self._unit(found, found)

    def first_sizes(self) -> np.ndarray:
        """Return the size [n] of the random vector of the first search at every node, and forget it."""
        assert self.bound is not None
        found, self.bound = self.bound, None
        np.divide(found, found.max(), out=found)
        return np.power(found, 4, out=found)

    def _unit(self, vector: np.ndarray, room: np.ndarray | None = None) -> np.ndarray:
        """Scale a vector to a kinetic energy of 1/2, in `room` if given; one without energy is not changed."""
        length = np.sqrt(self._sum(dot(vector, self.plan.lumped, vector)))
        return np.divide(vector, length, out=room) if length > 0.0 else vector

    def _sum(self, value: float) -> float:
        """Return the sum of a number over all parts of the body; here there is one."""
        return value

    def _most(self, value: float) -> float:
        """Return the largest value of a number over all parts of the body; here there is one."""
        return value

    def first_vector(self) -> np.ndarray:
        """Return the start vector of the first search."""
        return self._first(np.broadcast_to(0.0, 3 * len(self.plan.lumped)))

    def conclude(self, alphas: list[float], betas: list[float]) -> np.ndarray:
        """Estimate `elastic` from the Lanczos matrix; return the parts of its vectors in the mode found.

        Where no mode has a stiffness, as in a body crushed beyond the limit of its law, the last estimate stays.
        """
        ritz, residual, top = top_mode(alphas, betas, self.plan)
        stiffest = ritz + residual + self.added_rate
        if stiffest > 0.0:
            self.elastic = SAFETY * 2.0 / np.sqrt(stiffest)
        return top

    def search(self, u: np.ndarray, products: int = PRODUCTS) -> Search:
        """Estimate `elastic` and `damped` at displacement u [3n]; the next search starts from the mode found."""
        mass, answer = self.plan.lumped, self.answer
        self.trial[:] = u
        yield True
        here = answer.copy()
        current = self._first(here)
        before = np.zeros_like(current)
        keep = Vectors()  # for the start of the next estimate
        plain = self.penalty is None and self.plan.images is None
        alphas: list[float] = []
        betas: list[float] = []
        beta, largest = 0.0, self._most(float(np.abs(current).max(initial=0.0)))
        for _ in range(min(products, self.count)):
            keep.add(current, largest)
            scale = DIFFERENCE * self.size / largest
            for part in portions(u):
                np.add(u[part], scale * current[part], out=self.trial[part])
            yield True
            if not plain:
                answer[:] = self._corrected((here - answer) / scale, current)
            alpha = 0.0
            for part in portions(u):  # the product less beta times the vector before, in its place
                following = (here[part] - answer[part]) / scale if plain else answer[part].copy()
                following -= beta * before[part]
                before[part] = following
                alpha += dot(current[part], mass[nodes_of(part)], following)
            alpha, square, largest = self._sum(alpha), 0.0, 0.0
            for part in portions(u):
                following = before[part]
                following -= alpha * current[part]
                square += dot(following, mass[nodes_of(part)], following)
                largest = max(largest, float(following.max()), -float(following.min()))
            largest, beta = self._most(largest), float(np.sqrt(max(self._sum(square), 0.0)))
            alphas.append(alpha)
            betas.append(beta)
            if not has_next(alpha, alphas[0], beta):
                break
            before, current = current, before
            current /= beta
            largest /= beta
        self.start = keep.sum(self.conclude(alphas, betas), before)
        if self.damping is not None:
            self.take_damped((yield from self.damping.search(u, here, self.elastic, products)))

    def take_damped(self, limit: float) -> None:
        """Set `damped`; limit [s]: with viscous contact cells, without the rates of springs and pressures."""
        self.damped = SAFETY * limit
        if self.added_rate > 0.0:  # 4 dt/damped + dt^2 added_rate = 4
            rate = 1.0 / self.damped
            self.damped = 2.0 / (rate + np.sqrt(rate**2 + self.added_rate))


def least(bodies: Sequence[StableStep], rate: float) -> float:
    """Return the stable step [s] of bodies that have been searched; rate [1/s]: of bulk viscosity.

    Raises `InputError` with the body where a step is not above 0, as time cannot go on with it.
    """
    for body in bodies:
        for step in (body.elastic, body.damped):
            if not step > 0.0:
                raise InputError(
                    f"material of {body.plan.label}",
                    body.plan.body.material,
                    f"no stable step is found, {step:.6g} s is none; look at the units of stiffness, density and sizes",
                )
    return min(with_viscosity(body.elastic, rate, body.damped) for body in bodies)


def has_next(alpha: float, first: float, beta: float) -> bool:
    """Return whether there is another Lanczos vector; first: the first alpha."""
    return bool(1e-9 * max(abs(alpha), abs(first)) < beta < np.inf)


def coarse(step: float) -> float:
    """Return a step [s] rounded down to 14 binary digits.

    Estimates of the stable step are quotients of small differences: a CPU, a GPU and several ranks find them equal to
    nine digits only. With a rounded step they go on at the same times.
    """
    part, power = math.frexp(step)
    return math.ldexp(math.floor(part * 2.0**DIGITS), power - DIGITS) if math.isfinite(step) else step


def with_viscosity(elastic: float, rate: float, damped: float = np.inf) -> float:
    """Return the stable step [s] with an explicit viscosity of rate 2 xi omega [1/s]: elastic (sqrt(1 + xi^2) - xi).

    Where 4 M - dt^2 K - 2 dt C is positive definite, with the largest eigenvalues of both parts: the safe side.
    damped [s]: the limit with the viscosity of the contact cells alone; up to it dt^2 K + 2 dt C <= 4 M dt/damped.
    """
    xi = 0.25 * rate * elastic
    undamped = elastic / (np.sqrt(1.0 + xi * xi) + xi)
    return undamped if np.isinf(damped) else min(undamped, damped / (1.0 + 0.5 * rate * damped))


def with_rigid(limit: float, rate: float) -> float:
    """Return the stable step [s] beside rigid bodies of a rate w^2 [1/s^2]; limit [s]: that of the nodes alone.

    The largest eigenvalue of a positive semidefinite matrix is at most the sum of those of its diagonal blocks.
    """
    return float(1.0 / np.sqrt(1.0 / limit**2 + 0.25 * rate))


def largest_rate(elastic: float, dt: float, damped: float = np.inf) -> float:
    """Return the rate [1/s] with which dt [s] is the stable step; the inverse of `with_viscosity`."""
    return min(2.0 / dt - 2.0 * dt / elastic**2, 2.0 / dt - 2.0 / damped)
