"""Cubic convolution of a sampled distance: continuous with its gradient, second derivatives beside (METHOD 4).

    g(x) = sum_abc w_a(t_x) w_b(t_y) w_c(t_z) g_abc,   t: place in the cell, a, b, c: four nodes around it

(Keys, IEEE Trans. Acoust. Speech Signal Process. 29, 1153, 1981: third order, quadratics are exact.) The gradient of a
trilinear gap jumps at the faces of the grid, and so does a force along it: Newton's method then does not converge.
Beyond the grid the distance continues linearly from the nearest point of the grid, as in `interpolation.py`.
"""

from __future__ import annotations

import numpy as np

# coefficients of 1, t, t^2, t^3 in the weights of the four nodes
POWERS = np.array([[0.0, 1.0, 0.0, 0.0], [-0.5, 0.0, 0.5, 0.0], [1.0, -2.5, 2.0, -0.5], [-0.5, 1.5, -1.5, 0.5]])


def smooth_distance(
    distance: np.ndarray, origin: np.ndarray, spacing: float, positions: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return distance [n] [m], its gradient [n, 3] and second derivatives [n, 3, 3] [1/m] at positions [n, 3].

    distance [nx, ny, nz], at least four nodes along each axis; origin: node [0, 0, 0]. Beyond the grid the second
    derivatives leave out how they change there.
    """
    scaled = (positions - origin) / spacing
    inside = np.clip(np.nan_to_num(scaled), 0.0, np.array(distance.shape) - 1.0)
    places, weights = zip(*(_along(inside[:, axis], distance.shape[axis]) for axis in range(3)), strict=True)
    x, y, z = places
    around = distance[x[:, :, None, None], y[:, None, :, None], z[:, None, None, :]]  # [n, 4, 4, 4]

    # all[n, p, q, r]: derivatives of order p along x, q along y, r along z
    wx, wy, wz = (np.swapaxes(weight, 1, 2) for weight in weights)
    part = (around @ wz[:, None]).reshape(-1, 4, 4, 3)
    part = np.swapaxes(part, 2, 3) @ wy[:, None]  # [n, a, r, q]
    every = np.moveaxis(np.moveaxis(part, 1, 3) @ wx[:, None], (1, 2, 3), (3, 2, 1))
    value = every[:, 0, 0, 0]
    gradient = np.stack([every[:, 1, 0, 0], every[:, 0, 1, 0], every[:, 0, 0, 1]], axis=1) / spacing
    xx, yy, zz = every[:, 2, 0, 0], every[:, 0, 2, 0], every[:, 0, 0, 2]
    xy, xz, yz = every[:, 1, 1, 0], every[:, 1, 0, 1], every[:, 0, 1, 1]
    second = np.stack([xx, xy, xz, xy, yy, yz, xz, yz, zz], axis=1).reshape(-1, 3, 3) / spacing**2
    beyond = np.where(scaled == inside, 0.0, spacing * (scaled - inside))
    out = beyond != 0.0
    # D(c) + grad D(c).(x - c): c moves with x along the axes in which x is within the grid
    value = value + np.einsum("ni,ni->n", gradient, beyond)
    turned = gradient + np.where(out, 0.0, np.einsum("nij,nj->ni", second, beyond))
    return value, turned, np.where(out[:, :, None] & out[:, None, :], 0.0, second)


def _along(scaled: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return four nodes [n, 4] along an axis of `count`, with weights [n, 3, 4] for value and two derivatives.

    scaled [n]: places in units of the spacing. Before the first and after the last node it continues as a quadratic.
    """
    cell = np.clip(scaled.astype(np.int64), 0, count - 2)
    t = scaled - cell
    powers = [
        np.stack([np.ones_like(t), t, t**2, t**3], axis=1),
        np.stack([0.0 * t, np.ones_like(t), 2.0 * t, 3.0 * t**2], axis=1),
        np.stack([0.0 * t, 0.0 * t, np.full_like(t, 2.0), 6.0 * t], axis=1),
    ]
    first, last = (cell == 0)[:, None], (cell == count - 2)[:, None]
    weights = []
    for power in powers:
        w = power @ POWERS
        low = np.stack([w[:, 1] + 3 * w[:, 0], w[:, 2] - 3 * w[:, 0], w[:, 3] + w[:, 0], 0.0 * t], axis=1)
        high = np.stack([0.0 * t, w[:, 0] + w[:, 3], w[:, 1] - 3 * w[:, 3], w[:, 2] + 3 * w[:, 3]], axis=1)
        weights.append(np.where(first, low, np.where(last, high, w)))
    start = np.clip(cell - 1, 0, count - 4)
    return start[:, None] + np.arange(4), np.stack(weights, axis=1)
