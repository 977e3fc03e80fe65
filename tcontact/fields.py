"""Fields for pictures and files with numpy, one value a cell: at its centre, in one-point hexes the mean."""

from __future__ import annotations

import numpy as np

from .lumped_mass import HEX_CORNERS, shape_functions
from .materials import Material
from .mesh import Mesh


def deformation(mesh: Mesh, displacement: np.ndarray, formulation: str = "full") -> np.ndarray:
    """Displacement gradient [m, 3, 3] at the centre of every cell, its mean if reduced; displacement [n, 3] [m]."""
    if formulation == "reduced":
        return _mean_gradient(mesh, displacement)
    if mesh.kind == "tet4":
        gradient = np.array([[-1, -1, -1], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
    else:
        gradient = HEX_CORNERS / 8.0
    jacobian = np.einsum("mad,ac->mdc", mesh.nodes[mesh.cells], gradient, optimize=True)
    moved = displacement[mesh.cells]
    slope = np.einsum("mad,ac->mdc", moved - moved[:, :1], gradient, optimize=True)
    return slope @ np.linalg.inv(jacobian)


def _mean_gradient(mesh: Mesh, displacement: np.ndarray) -> np.ndarray:
    """Mean displacement gradient [m, 3, 3] over the volume of every cell, which 2x2x2 points integrate exactly."""
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


def von_mises(mesh: Mesh, material: Material, displacement: np.ndarray, formulation: str = "full") -> np.ndarray:
    """Von Mises stress [m] [Pa] of the Cauchy stress at the cell centres, or of the mean gradient if reduced."""
    slope = deformation(mesh, displacement, formulation)
    lam, mu = material.lame_lambda, material.lame_mu
    identity = np.eye(3)
    if material.law == "linear_elastic":
        strain = 0.5 * (slope + slope.transpose(0, 2, 1))
        stress = lam * np.trace(strain, axis1=1, axis2=2)[:, None, None] * identity + 2.0 * mu * strain
    else:
        f = identity + slope
        volume = np.linalg.det(f)[:, None, None]
        left = f @ f.transpose(0, 2, 1)
        with np.errstate(all="ignore"):
            if material.law == "neo_hookean":
                stress = mu * (left - identity) / volume + lam * (volume - 1.0) * identity
            elif material.law == "mooney_rivlin":
                bulk, first, second = material.moduli
                strain = 0.5 * (f.transpose(0, 2, 1) @ f - identity)
                strain = np.trace(strain, axis1=1, axis2=2)[:, None, None] * identity - strain
                stress = (first * (left - identity) + second * f @ strain @ f.transpose(0, 2, 1)) / volume
                stress += bulk * (volume - 1.0) * identity
            else:
                strain = 0.5 * (f.transpose(0, 2, 1) @ f - identity)
                second = lam * np.trace(strain, axis1=1, axis2=2)[:, None, None] * identity + 2.0 * mu * strain
                stress = f @ second @ f.transpose(0, 2, 1) / volume
    deviator = stress - np.trace(stress, axis1=1, axis2=2)[:, None, None] / 3.0 * identity
    with np.errstate(all="ignore"):
        return np.sqrt(1.5 * np.einsum("mij,mij->m", deviator, deviator))


def worst_cell(mesh: Mesh, displacement: np.ndarray, formulation: str = "full") -> tuple[int, float]:
    """The cell with the smallest det F at its integration points, and that value."""
    if formulation == "reduced":
        with np.errstate(all="ignore"):
            found = np.linalg.det(np.eye(3) + _mean_gradient(mesh, displacement))
        return _smallest(np.where(np.isfinite(found), found, -np.inf))
    _values, gradients, _weights = shape_functions(mesh.kind)
    least = np.full(mesh.cell_count, np.inf)
    moved = displacement[mesh.cells]
    for gradient in gradients:
        jacobian = np.einsum("mad,ac->mdc", mesh.nodes[mesh.cells], gradient, optimize=True)
        slope = np.einsum("mad,ac->mdc", moved - moved[:, :1], gradient, optimize=True)
        with np.errstate(all="ignore"):
            here = np.linalg.det(jacobian + slope) / np.linalg.det(jacobian)
        least = np.fmin(least, np.where(np.isfinite(here), here, -np.inf))
    return _smallest(least)


def _smallest(values: np.ndarray) -> tuple[int, float]:
    cell = int(np.argmin(values))
    return cell, float(values[cell])
