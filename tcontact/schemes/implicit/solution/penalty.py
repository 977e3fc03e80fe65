"""Penalty contact of a step: p = max(0, -g), potential p^2/(2 eps), 1/eps = stiffness of the node (METHOD 4).

The conserving force lambda nu*, nu*.dx = dg, is the difference quotient of the potential in every branch:

    both ends inside (p0 + p1)/(2 eps),  entering p1^2/[2 eps (g0 + p1)],  leaving p0^2/[2 eps (p0 + g1)],  else 0
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .surfaces import Curved, Flat, Round

Surfaces = Sequence[Flat | Round | Curved]


def conserving_pressure(before: np.ndarray, after: np.ndarray, stiffness: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return lambda [k] [N] for the gaps before and after a step, and its derivative with the gap after."""
    p0, p1 = np.maximum(0.0, -before), np.maximum(0.0, -after)
    half = 0.5 * stiffness
    inside = (before <= 0.0) & (after <= 0.0)
    entering = (before > 0.0) & (after < 0.0)
    leaving = (before < 0.0) & (after > 0.0)
    span = np.where(entering, before + p1, np.where(leaving, p0 + after, 1.0))
    force = np.where(inside, p0 + p1, np.where(entering, p1**2 / span, np.where(leaving, p0**2 / span, 0.0)))
    crossing = np.where(entering, (p1**2 / span - 2.0 * p1) / span, np.where(leaving, -((p0 / span) ** 2), 0.0))
    slope = np.where(inside, np.where(after < 0.0, -1.0, 0.0), crossing)
    return half * force, half * slope


class PenaltyForce:
    """Penalty contact of nodes: forces [p, k, 3] of every obstacle, tangents [k, 3, 3] of all; stiffness [k] [N/m]."""

    def __init__(self, surfaces: Surfaces, stiffness: np.ndarray) -> None:
        self.surfaces, self.stiffness = surfaces, stiffness

    def conserving(self, x0: np.ndarray, x1: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return forces of a step from x0 to x1 [k, 3] and their derivative with x1."""
        force, tangent = np.zeros((len(self.surfaces), len(x1), 3)), np.zeros((len(x1), 3, 3))
        for number, surface in enumerate(self.surfaces):
            past = surface.passage(x0, x1)
            pressure, slope = conserving_pressure(past.before, past.after, self.stiffness)
            force[number] = pressure[:, None] * past.normal
            tangent += slope[:, None, None] * past.normal[:, :, None] * past.gradient[:, None, :]
            tangent += pressure[:, None, None] * past.turning
        return force, tangent

    def at(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return forces at positions x [k, 3] and their derivative."""
        force, tangent = np.zeros((len(self.surfaces), len(x), 3)), np.zeros((len(x), 3, 3))
        for number, surface in enumerate(self.surfaces):
            here = surface.at(x)
            pressure = self.stiffness * np.maximum(0.0, -here.after)
            slope = np.where(here.after < 0.0, -self.stiffness, 0.0)
            force[number] = pressure[:, None] * here.normal
            tangent += slope[:, None, None] * here.normal[:, :, None] * here.gradient[:, None, :]
            tangent += pressure[:, None, None] * here.turning
        return force, tangent

    def energy(self, x: np.ndarray) -> tuple[float, int]:
        """Return the energy [J] and the number of nodes inside an obstacle at positions x [k, 3]."""
        energy, closed = 0.0, np.zeros(len(x), dtype=bool)
        for surface in self.surfaces:
            depth = np.maximum(0.0, -surface.gap(x))
            energy += 0.5 * float(self.stiffness @ depth**2)
            closed |= depth > 0.0
        return energy, int(closed.sum())
