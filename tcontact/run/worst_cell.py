"""Find the most compressed cell, for the message of a run that stops."""

from __future__ import annotations

import numpy as np

from ..mesh.elements import shape_functions
from ..scene.body import Body


def _mean_gradient(kind: str, corners: np.ndarray, moved: np.ndarray) -> np.ndarray:
    """Return the mean displacement gradient [m, 3, 3] over every cell, exact with 2x2x2 points."""
    moved = moved - moved[:, :1]
    total, volume = np.zeros((len(corners), 3, 3)), np.zeros(len(corners))
    _values, gradients, weights = shape_functions(kind)
    for gradient, weight in zip(gradients, weights, strict=True):
        jacobian = np.einsum("mad,ac->mdc", corners, gradient, optimize=True)
        here = weight * np.linalg.det(jacobian)
        slope = np.einsum("mad,ac->mdc", moved, gradient, optimize=True)
        total += here[:, None, None] * (slope @ np.linalg.inv(jacobian))
        volume += here
    return total / volume[:, None, None]


def worst_cell_of(body: Body, displacement: np.ndarray, failing: bool = False) -> tuple[int, float]:
    """Return the cell of a body with the smallest det F, and that value; displacement [n, 3] [m] of the user.

    failing: leave out the cells of linear laws, which have no limit on det F.
    """
    smallest = np.full(body.mesh.cell_count, np.inf)
    for block in body.blocks:
        if failing and block.material.linear:
            continue
        corners, moved = body.mesh.nodes[block.cells], displacement[block.cells]
        smallest[block.numbers] = _compression(block.kind, corners, moved, block.formulation)
    cell = int(np.argmin(smallest))
    return cell, float(smallest[cell])


def _compression(kind: str, corners: np.ndarray, moved: np.ndarray, formulation: str) -> np.ndarray:
    """Return the smallest det F [m] of every cell; corners, moved [m, a, 3] [m]: positions and displacements."""
    if formulation == "reduced":
        with np.errstate(all="ignore"):
            found = np.linalg.det(np.eye(3) + _mean_gradient(kind, corners, moved))
        return np.where(np.isfinite(found), found, -np.inf)
    _values, gradients, _weights = shape_functions(kind)
    smallest = np.full(len(corners), np.inf)
    for gradient in gradients:
        jacobian = np.einsum("mad,ac->mdc", corners, gradient, optimize=True)
        slope = np.einsum("mad,ac->mdc", moved - moved[:, :1], gradient, optimize=True)
        with np.errstate(all="ignore"):
            here = np.linalg.det(jacobian + slope) / np.linalg.det(jacobian)
        smallest = np.fmin(smallest, np.where(np.isfinite(here), here, -np.inf))
    return smallest
