"""hex8 (2x2x2 points), wedge6 (3x2 points) and tet4 cells in VTK order: internal force, energy, tangent, von Mises."""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

HEX_CORNERS = np.array(
    [[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]], dtype=float
)


@dataclass(frozen=True)
class Quadrature:
    """Cells and their integration points: shape [q, a], gradient dN/dX [m, q, a, 3], weight [m, q] [m^3]."""

    cells: np.ndarray
    shape: np.ndarray
    gradient: np.ndarray
    weight: np.ndarray

    def part(self, chosen):
        """Return the quadrature of the chosen cells alone."""
        return Quadrature(self.cells[chosen], self.shape, self.gradient[chosen], self.weight[chosen])


def reference_points(kind, centre=False):
    """Shape functions [q, a], their derivatives [q, a, 3] and weights [q] on the reference cell."""
    if kind == "hex8":
        points = np.zeros((1, 3)) if centre else HEX_CORNERS / np.sqrt(3)
        factor = 1 + points[:, None, :] * HEX_CORNERS
        shape = factor.prod(axis=2) / 8
        slope = np.stack([HEX_CORNERS[:, d] * np.delete(factor, d, axis=2).prod(axis=2) / 8 for d in range(3)], axis=2)
        return shape, slope, np.full(len(points), 8.0 / len(points))
    if kind == "tet4":
        slope = np.array([[-1.0, -1, -1], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
        return np.full((1, 4), 0.25), slope[None], np.array([1 / 6])
    if kind == "wedge6":
        areas = np.full((1, 3), 1 / 3) if centre else np.full((3, 3), 1 / 6) + np.eye(3) / 2
        levels = np.array([0.5]) if centre else 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3)
        within = np.array([[-1.0, -1], [1, 0], [0, 1]])
        shape, slope = [], []
        for area in areas:
            for level in levels:
                shape.append([*((1 - level) * area), *(level * area)])
                ends = ((1 - level, -1), (level, 1))
                slope.append(np.concatenate([np.column_stack([part * within, sign * area]) for part, sign in ends]))
        return np.array(shape), np.array(slope), np.full(len(shape), 0.5 / len(shape))
    raise ValueError(kind)


def quadrature(nodes, cells, kind, centre=False):
    """Quadrature of the reference state; centre=True takes the cell centre alone."""
    shape, slope, weight = reference_points(kind, centre)
    corner = nodes[cells] - nodes[cells[:, :1]]
    jacobian = np.einsum("mai,qad->mqid", corner, slope)
    determinant = np.linalg.det(jacobian)
    if determinant.min() <= 0:
        raise ValueError("inverted cell")
    gradient = np.einsum("qad,mqdi->mqai", slope, np.linalg.inv(jacobian))
    return Quadrature(cells, shape, gradient, determinant * weight)


def displacement_gradient(quad, u):
    """H = grad u [m, q, 3, 3], from displacement differences to the first node of each cell."""
    local = u[quad.cells] - u[quad.cells[:, :1]]
    return np.swapaxes(local, 1, 2)[:, None] @ quad.gradient


def cell_force(quad, law, u):
    """Internal force of each cell on its nodes [m, a, 3] [N]."""
    stress = law.stress(displacement_gradient(quad, u)) * quad.weight[..., None, None]
    return (quad.gradient @ np.swapaxes(stress, -1, -2)).sum(axis=1)


def assemble(cells, values, node_count):
    """Sum cell values [m, a, ...] into nodes [n, ...]."""
    columns = values.reshape(cells.size, -1)
    total = np.stack([np.bincount(cells.ravel(), column, node_count) for column in columns.T], axis=1)
    return total.reshape((node_count, *values.shape[2:]))


def internal_force(quad, law, u):
    """f(u) = dW/du [n, 3] [N]."""
    return assemble(quad.cells, cell_force(quad, law, u), len(u))


def energy(quad, law, u):
    """Stored elastic energy [J]."""
    return float(np.sum(law.energy_density(displacement_gradient(quad, u)) * quad.weight))


def cell_tangent(quad, law, u):
    """df/du of each cell [m, a, 3, a, 3] [N/m]."""
    moduli = law.moduli(displacement_gradient(quad, u)) * quad.weight[..., None, None, None, None]
    half = np.einsum("mqikjl,mqbl->mqikbj", moduli, quad.gradient, optimize=True)
    return np.einsum("mqak,mqikbj->maibj", quad.gradient, half, optimize=True)


def tangent(quad, law, u):
    """df/du as a sparse matrix [3n, 3n]."""
    dof = (3 * quad.cells[:, :, None] + np.arange(3)).reshape(len(quad.cells), -1)
    width = dof.shape[1]
    rows = np.repeat(dof, width, axis=1).ravel()
    columns = np.tile(dof, (1, width)).ravel()
    values = cell_tangent(quad, law, u).ravel()
    return sparse.csr_matrix((values, (rows, columns)), shape=(u.size, u.size))


def von_mises(nodes, cells, kind, law, u):
    """Von Mises norm of the Cauchy stress at the cell centres [m] [Pa]."""
    return equivalent(law.cauchy(displacement_gradient(quadrature(nodes, cells, kind, centre=True), u)[:, 0]))


def equivalent(cauchy):
    """Von Mises norm of stresses [m, 3, 3]."""
    deviator = cauchy - np.trace(cauchy, axis1=-2, axis2=-1)[:, None, None] / 3 * np.eye(3)
    return np.sqrt(1.5 * np.sum(deviator**2, axis=(-2, -1)))
