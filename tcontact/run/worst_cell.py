"""Find the most compressed cell, for the message of a run that stops."""

from __future__ import annotations

import numpy as np

from ..mesh.elements import shape_functions
from ..mesh.mesh import Mesh


def _mean_gradient(mesh: Mesh, displacement: np.ndarray) -> np.ndarray:
    """Return the mean displacement gradient [m, 3, 3] over every cell, exact with 2x2x2 points."""
    corners, moved = mesh.nodes[mesh.cells], displacement[mesh.cells]
    moved = moved - moved[:, :1]
    total, volume = np.zeros((mesh.cell_count, 3, 3)), np.zeros(mesh.cell_count)
    _values, gradients, weights = shape_functions(mesh.kind)
    for gradient, weight in zip(gradients, weights, strict=True):
        jacobian = np.einsum("mad,ac->mdc", corners, gradient, optimize=True)
        here = weight * np.linalg.det(jacobian)
        slope = np.einsum("mad,ac->mdc", moved, gradient, optimize=True)
        total += here[:, None, None] * (slope @ np.linalg.inv(jacobian))
        volume += here
    return total / volume[:, None, None]


def worst_cell(mesh: Mesh, displacement: np.ndarray, formulation: str = "full") -> tuple[int, float]:
    """Return the cell with the smallest det F at its integration points, and that value; displacement [n, 3] [m]."""
    if formulation == "reduced":
        with np.errstate(all="ignore"):
            found = np.linalg.det(np.eye(3) + _mean_gradient(mesh, displacement))
        return _smallest(np.where(np.isfinite(found), found, -np.inf))
    _values, gradients, _weights = shape_functions(mesh.kind)
    smallest = np.full(mesh.cell_count, np.inf)
    moved = displacement[mesh.cells]
    for gradient in gradients:
        jacobian = np.einsum("mad,ac->mdc", mesh.nodes[mesh.cells], gradient, optimize=True)
        slope = np.einsum("mad,ac->mdc", moved - moved[:, :1], gradient, optimize=True)
        with np.errstate(all="ignore"):
            here = np.linalg.det(jacobian + slope) / np.linalg.det(jacobian)
        smallest = np.fmin(smallest, np.where(np.isfinite(here), here, -np.inf))
    return _smallest(smallest)


def _smallest(values: np.ndarray) -> tuple[int, float]:
    cell = int(np.argmin(values))
    return cell, float(values[cell])
