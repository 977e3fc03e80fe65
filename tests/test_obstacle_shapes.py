"""Kernels of the shapes give the gaps and normals of the host's formulas."""

import numpy as np
import pytest

import tcontact as tc


def of_kernel(obstacle, positions, before=0):
    """Gap and normal in local coordinates from the kernels; `before`: numbers of other grids in front."""
    import taichi as ti

    from tcontact.kernels.contact.obstacle_shapes import box_gap_normal, grid_gap_normal
    from tcontact.kernels.language.arguments import ARRAY

    shape = obstacle.shape

    @ti.kernel
    def evaluate(parameters: ARRAY, grid: ARRAY, start: int, positions: ARRAY, out: ARRAY):
        for n in range(positions.shape[0] // 3):
            y = ti.Vector([positions[3 * n + i] for i in ti.static(range(3))])
            first = ti.Vector([parameters[i] for i in ti.static(range(3))])
            gap = 0.0
            normal = ti.Vector([0.0, 0.0, 0.0])
            if ti.static(shape == "box"):
                gap, normal, _face = box_gap_normal(y, first, 0.0)
            else:
                gap, normal = grid_gap_normal(
                    grid, start, first, parameters[3], parameters[4], parameters[5], parameters[6], y
                )
            out[4 * n] = gap
            for i in ti.static(range(3)):
                out[4 * n + 1 + i] = normal[i]

    grid = np.zeros(1) if obstacle.grid is None else np.concatenate([np.full(before, np.nan), obstacle.grid.ravel()])
    out = np.empty((len(positions), 4))
    evaluate(np.array(obstacle.parameters), grid, before, positions.ravel(), out.ravel())
    return out[:, 0], out[:, 1:]


def wavy(points):
    """Any smooth field of three coordinates."""
    return np.sin(2 * points[:, 0]) + points[:, 1] * points[:, 2] - 0.3 * points[:, 1]


@pytest.mark.parametrize(
    "obstacle",
    [
        tc.Box(size=(1.0, 0.6, 0.4)),
        tc.Sdf(wavy, origin=(-1, -0.8, -0.6), spacing=0.2, nodes=(11, 9, 7)),
    ],
    ids=lambda obstacle: obstacle.shape,
)
def test_kernel_is_the_host_formula(obstacle):
    positions = np.random.default_rng(1).uniform(-1.5, 1.5, (3000, 3))  # inside, and out beyond the grid
    gap, normal = of_kernel(obstacle, positions, before=8)
    wanted_gap, wanted_normal = obstacle.local(positions)
    assert np.abs(gap - wanted_gap).max() < 1e-14
    assert np.abs(normal - wanted_normal).max() < 1e-13


def test_numbers_that_are_none_stay_in_the_array():
    obstacle = tc.Sdf(wavy, origin=(-1, -0.8, -0.6), spacing=0.2, nodes=(11, 9, 7))
    positions = np.array([[np.nan, 0.0, 0.0], [np.inf, 0.0, 0.0], [-1e300, 0.0, 0.0], [0.0, np.nan, np.nan]])
    gap, _ = of_kernel(obstacle, positions)
    assert np.isnan(gap[[0, 3]]).all()
    assert not np.isfinite(gap[1])
