"""Stress of metals in cells with several points: the mean of the points, each with its own state."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from mixed_meshes import shaken

import tcontact as tc
from tcontact.cells.cell_stress import CellStress
from tcontact.cells.stress import VonMises
from tcontact.kernels.materials import LAWS

YIELD, YOUNG, POISSON = 5e6, 1e9, 0.3
SHEAR, BULK = YOUNG / (2.0 + 2.0 * POISSON), YOUNG / (3.0 - 6.0 * POISSON)
PERFECT = tc.ElastoPlastic(YOUNG, POISSON, 2000.0, tc.LinearHardening(YIELD, 0.0))
HEXES = np.array([(-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1), (-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1)])
SYMMETRIC = np.array([[0, 3, 4], [3, 1, 5], [4, 5, 2]])  # places of Cp^-1 - I in the state of a point


def points_of(kind):
    """Return weight and slopes [corner, direction] of the shape functions of every point of a cell."""
    if kind == "hex8":
        for point in HEXES / np.sqrt(3.0):
            parts = 1.0 + HEXES * point
            slopes = [HEXES[:, i] * parts[:, (i + 1) % 3] * parts[:, (i + 2) % 3] / 8.0 for i in range(3)]
            yield 1.0, np.transpose(slopes)
        return
    for t, place in product((0.5 - 0.5 / np.sqrt(3.0), 0.5 + 0.5 / np.sqrt(3.0)), range(3)):
        r, s = 1.0 / 6.0 + 0.5 * (place & 1), 1.0 / 6.0 + 0.5 * (place >> 1)
        flat, height = np.array([1.0 - r - s, r, s]), (1.0 - t, t)
        across = np.array([(-1.0, -1.0), (1.0, 0.0), (0.0, 1.0)])
        yield 1.0 / 12.0, np.vstack([np.column_stack([across * height[i], flat * (-1.0, 1.0)[i]]) for i in range(2)])


def by_points(mesh, kind, position, state, one_pressure):
    """Return the mean Cauchy stress [cells, 3, 3] of the points of every cell, and the smallest J of a point."""
    rest, now = mesh.nodes[mesh.cells], position[mesh.cells]
    eye, weights = np.eye(3), []
    stress = []
    for number, (weight, slopes) in enumerate(points_of(kind)):
        before = np.einsum("cki,kj->cij", rest, slopes)
        f = np.einsum("cki,kj->cij", now, slopes) @ np.linalg.inv(before)
        jacobian = np.linalg.det(f)
        left = f @ (state[:, number][:, SYMMETRIC] + eye) @ f.transpose(0, 2, 1)
        left -= np.trace(left, axis1=1, axis2=2)[:, None, None] / 3.0 * eye
        stress.append(SHEAR * (jacobian ** (-5.0 / 3.0))[:, None, None] * left)
        if not one_pressure:
            stress[-1] += BULK * (jacobian - 1.0)[:, None, None] * eye
        weights.append((weight * np.linalg.det(before), jacobian))
    at_rest, jacobian = np.array(weights).transpose(1, 0, 2)
    deformed, each = at_rest * jacobian, np.array(stress)
    mean = np.einsum("pc,pcij->cij", deformed / deformed.sum(axis=0), each)
    if one_pressure:
        mean += BULK * (deformed.sum(axis=0) / at_rest.sum(axis=0) - 1.0)[:, None, None] * eye
    return mean, jacobian.min()


def norm(stress):
    """Return the von Mises norm of stresses [..., 3, 3]."""
    deviator = stress - np.trace(stress, axis1=-2, axis2=-1)[..., None, None] / 3.0 * np.eye(3)
    return np.sqrt(1.5 * (deviator**2).sum(axis=(-2, -1)))


@pytest.mark.parametrize(("kind", "formulation"), [("hex8", "mean-dilatation"), ("hex8", "full"), ("wedge6", "full")])
def test_the_stress_is_the_mean_of_the_points_with_their_own_states(kind, formulation):
    """Points with very different plastic strains in deformed cells, against points computed one by one."""
    mesh = shaken(tc.box_mesh((1e-2, 1e-2, 2e-2), (2, 3, 2), kind), 0.1)
    body = tc.Body(mesh, PERFECT, formulation=formulation)
    random = np.random.default_rng(5)
    u = 0.1 * mesh.shortest_edge * random.standard_normal(mesh.nodes.shape)
    numbers = len(LAWS[PERFECT.law].state)
    state = 0.1 * random.standard_normal((mesh.cell_count, 6 if kind == "wedge6" else 8, numbers))
    mean, _least = by_points(mesh, kind, mesh.nodes + u, state, formulation == "mean-dilatation")
    exact, size = norm(mean), np.abs(mean).max()
    np.testing.assert_allclose(VonMises(body)(u, [state]), exact, rtol=0, atol=1e-12 * size)
    found = CellStress(body)(u[None], [state])[0]
    np.testing.assert_allclose(found[:, :6], mean[:, (0, 1, 2, 0, 1, 0), (0, 1, 2, 1, 2, 2)], rtol=0, atol=1e-12 * size)
    np.testing.assert_allclose(found[:, 6], exact, rtol=0, atol=1e-12 * size)


def test_without_a_state_it_is_that_of_the_start():
    """Points at rest, in cells that are only turned."""
    mesh = shaken(tc.box_mesh((1.0, 1.0, 1.0), (2, 2, 2)), 0.1)
    body = tc.Body(mesh, PERFECT, formulation="mean-dilatation")
    turned = mesh.nodes[:, [1, 2, 0]] - mesh.nodes
    assert np.abs(CellStress(body)(turned[None])).max() < 1e-14 * YOUNG
