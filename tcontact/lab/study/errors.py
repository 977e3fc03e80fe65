"""Errors of a run: force, energy, displacement. Plain numpy, relative numbers, 0 = exact."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ...mesh.elements import shape_functions
from ...results.result import Result


def centred_mean(impulse: Callable[[np.ndarray], np.ndarray], time: np.ndarray) -> np.ndarray:
    """Return the force averaged over [t - dt/2, t + dt/2] from its running integral; dt: the spacing of the times."""
    middle = 0.5 * (time[1:] + time[:-1])
    edges = np.concatenate([[1.5 * time[0] - 0.5 * time[1]], middle, [1.5 * time[-1] - 0.5 * time[-2]]])
    return np.diff(impulse(edges)) / np.diff(edges)


def relative_l2(found: np.ndarray, wanted: np.ndarray) -> float:
    """Return |found - wanted| / |wanted| over the rows."""
    return float(np.linalg.norm(found - wanted) / np.linalg.norm(wanted))


def plateau(found: np.ndarray, value: float) -> float:
    """Return the error of the mean of the rows against the value of the plateau."""
    return float(abs(np.mean(found) / value - 1.0)) if len(found) else float("nan")


def ripple(found: np.ndarray, value: float) -> float:
    """Return the root mean square of the rows around the value of the plateau, relative to it."""
    return float(np.sqrt(np.mean((found / value - 1.0) ** 2))) if len(found) else float("nan")


def energy(result: Result) -> float:
    """Return the largest energy error of the run (METHOD 2)."""
    return float(np.max(np.abs(result.history["energy_error"])))


def normal_force(result: Result) -> np.ndarray:
    """Return the contact force [rows] along the normal of the first obstacle [N]."""
    return np.asarray(result.history["contact_force"] @ result.scene.obstacles[0].frame[2])


def hex_quadrature(mesh: Any, displacement: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return points [q, 3], weights [q] [m^3], displacement and its gradient at the 2x2x2 points of hexes."""
    parts: list[list[np.ndarray]] = [[], [], [], []]
    nodes, moved = mesh.nodes[mesh.cells], displacement[mesh.cells]
    for shape, slope, weight in zip(*shape_functions("hex8"), strict=True):
        jacobian = np.einsum("mai,ad->mid", nodes, slope)
        parts[0].append(np.einsum("a,mai->mi", shape, nodes))
        parts[1].append(weight * np.linalg.det(jacobian))
        parts[2].append(np.einsum("a,mai->mi", shape, moved))
        parts[3].append(np.einsum("mai,ad,mdj->mij", moved, slope, np.linalg.inv(jacobian)))
    points, weights, values, gradients = (np.concatenate(part) for part in parts)
    return points, weights, values, gradients


def elastic_norm(gradient: np.ndarray, weights: np.ndarray, material: Any) -> float:
    """Return sqrt of 2 x the linear elastic energy of a displacement gradient [q, 3, 3]."""
    strain = 0.5 * (gradient + np.swapaxes(gradient, 1, 2))
    trace = np.trace(strain, axis1=1, axis2=2)
    density = 2.0 * material.lame_mu * np.einsum("qij,qij->q", strain, strain) + material.lame_lambda * trace**2
    return float(np.sqrt(weights @ density))
