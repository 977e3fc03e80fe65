"""Find the stable step with viscous contact cells, where dt^2 K + 2 dt C reaches 4 M, by Lanczos (METHOD 2).

The viscous force takes the rate before the kick; a mode then alternates in sign from step to step where

    4 M - dt^2 K - 2 dt C    is singular:   dt^2 a = 4,   a = largest eigenvalue of M^-1 (K + 2/dt C)

C is the viscosity of the contact cells, M the mass after redistribution. Massless components are at rest in the modes:
their static solve only makes the body softer (K_JJ - K_JK K_KK^-1 K_KJ <= K_JJ, and so for K + 2/dt C), so the estimate
is on the safe side.

A momentum on a massless or supported component moves nothing and takes no energy, so it belongs to no mode. The force
of a product has such components, and the recursion of Lanczos would let them grow: they are taken off every vector.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from typing import Any

import numpy as np

from ...planning.body_plan import BodyPlan
from .lanczos_matrix import top_mode
from .start_vectors import random_vector

Search = Generator[bool, None, Any]  # yields when a displacement [3n] needs its acceleration -M^-1 f
Product = Callable[[np.ndarray, np.ndarray, np.ndarray], Search]
ViscousForce = Callable[[np.ndarray, np.ndarray], np.ndarray]
ROUNDS = 6  # searches at most
CLOSE = 1e-3  # two steps that differ by this share are the same
NO_INVERSE = 1e-9  # a component with this share of the largest inverse mass of its node does not move


class DampedStep:
    """Estimates the stable step with viscous contact cells.

    stiffness(u, -M^-1 f(u), x) = K(u) x; viscous_force(u, x) = C(u) x for a small x, at most `small` [m]; all [3n].
    """

    def __init__(self, plan: BodyPlan, stiffness: Product, viscous_force: ViscousForce, small: float) -> None:
        self.plan, self.stiffness, self.viscous_force, self.small = plan, stiffness, viscous_force, small
        total = plan.lumped if plan.images is None else plan.images.total(plan.lumped)
        self.inverse = np.where(total > 0.0, 1.0 / np.where(total > 0.0, total, 1.0), 0.0)
        self.moving = moving_parts(plan.inverses)
        self.start: np.ndarray | None = None  # momenta [3n] of the mode found last
        self.count = 3 * len(plan.lumped)  # components of the body

    def _sum(self, value: float) -> float:
        """Return the sum of a number over all parts of the body; here there is one."""
        return value

    def _most(self, value: float) -> float:
        """Return the largest value of a number over all parts of the body; here there is one."""
        return value

    def _summed(self, force: np.ndarray) -> np.ndarray:
        """Sum a force [3n] of images at their masters."""
        images = self.plan.images
        return np.array(force) if images is None else images.total(force.reshape(-1, 3)).reshape(-1)

    def _moved(self, p: np.ndarray) -> np.ndarray:
        """Return M^-1 p [3n]; 0 where there is no mass or a support."""
        images, nodes, rows = self.plan.images, self.plan.boundary, p.reshape(-1, 3)
        x = self.inverse[:, None] * rows
        x[nodes] = np.einsum("sij,sj->si", self.plan.inverses, rows[nodes])
        return np.asarray(x if images is None else images.follow(x)).reshape(-1)

    def _within(self, p: np.ndarray) -> np.ndarray:
        """Return the part [3n] of momenta that moves anything: without massless and supported components."""
        nodes, rows = self.plan.boundary, p.reshape(-1, 3)
        found = np.where(self.inverse[:, None] > 0.0, rows, 0.0)
        found[nodes] = np.einsum("sij,sj->si", self.moving, rows[nodes])
        return found.reshape(-1)

    def _products(self, u: np.ndarray, here: np.ndarray, x: np.ndarray) -> Search:
        """Return K x and C x."""
        scale = self.small / self._most(float(np.abs(x).max(initial=0.0)))
        stiff = yield from self.stiffness(u, here, x)
        return stiff, self.viscous_force(u, scale * x) / scale

    def _mode(self, u: np.ndarray, here: np.ndarray, rate: float, products: int) -> Search:
        """Search the fastest mode of M^-1 (K + rate C): return 1 + residual/eigenvalue, 0 if no mode has a stiffness.

        Lanczos with momenta p and displacements x = M^-1 p, normalised to a kinetic energy p.x/2 = 1/2, needs M^-1
        only.
        """
        start = random_vector(u.size) if self.start is None else self.start
        p = self._within(self._summed(start))
        x = self._moved(p)
        length = np.sqrt(self._sum(dot(p, x)))
        p, x, before, beta = p / length, x / length, np.zeros_like(p), 0.0
        keep, alphas, betas = [], [], []
        for _ in range(min(products, self.count)):
            keep.append(p)
            stiff, resisting = yield from self._products(u, here, x)
            following = self._summed(stiff + rate * resisting) - beta * before
            alphas.append(self._sum(dot(x, following)))
            following = self._within(following - alphas[-1] * p)
            moved = self._moved(following)
            beta = float(np.sqrt(max(self._sum(dot(following, moved)), 0.0)))
            betas.append(beta)
            if beta <= 1e-9 * max(abs(alphas[-1]), abs(alphas[0])):
                break
            before, p, x = p, following / beta, moved / beta
        value, residual, top = top_mode(alphas, betas, self.plan)
        self.start = sum((weight * part for weight, part in zip(top, keep, strict=True)), np.zeros_like(p))
        return 1.0 + residual / value if value > 0.0 else 0.0

    def search(self, u: np.ndarray, here: np.ndarray, elastic: float, products: int) -> Search:
        """Search the stable step [s] at displacement u [3n]; here: -M^-1 f(u); elastic [s]: step to begin with.

        The mode x found for a step has the limit dt^2 k + 2 dt c = 4 with k = x.K x, c = x.C x for x.M x = 1, where the
        next search begins. An error of the mode changes the limit in second order only, so that a few are enough. Where
        no mode has a stiffness, the step stays what it was.
        """
        dt = elastic
        for _ in range(ROUNDS):
            over = yield from self._mode(u, here, 2.0 / dt, products)
            assert self.start is not None
            x = self._moved(self.start)
            parts = yield from self._products(u, here, x)
            unit = self._sum(dot(x, self.start))
            k, c = (over * self._sum(dot(x, part)) / unit for part in parts)
            before, dt = dt, limit_of(k, c, dt)
            if abs(dt - before) <= CLOSE * dt:
                break
        return float(dt)


def limit_of(k: float, c: float, dt: float) -> float:
    """Return the limit [s] of a mode, dt^2 k + 2 dt c = 4; dt [s]: what stands where it has none."""
    below = np.sqrt(max(c * c + 4.0 * k, 0.0)) + c
    return float(4.0 / below) if below > 0.0 else dt


def moving_parts(inverses: np.ndarray) -> np.ndarray:
    """Return the projectors [s, 3, 3] on the components that move, from inverse mass tensors [s, 3, 3]."""
    values, vectors = np.linalg.eigh(inverses)
    moves = values > NO_INVERSE * np.abs(values).max(axis=1, initial=0.0, keepdims=True)
    return np.asarray(np.einsum("sia,sa,sja->sij", vectors, moves.astype(np.float64), vectors))


def dot(a: np.ndarray, b: np.ndarray) -> float:
    """Return a.b without BLAS, whose idle threads would occupy cores that the kernels need."""
    return float((a * b).sum())
