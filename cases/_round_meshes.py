"""Hex meshes of quarters of round bodies from mapped blocks: a core and a shell around it."""

from __future__ import annotations

import numpy as np

import tcontact as tc
from tcontact.mesh.mapped import between, join


def graded(length: float, first: float, even: int, growth: float) -> np.ndarray:
    """Return points from 0 to length: `even` spacings of size `first`, then each `growth` times the one before."""
    sizes = [first] * even
    while sum(sizes) < length:
        sizes.append(sizes[-1] * growth)
    points = np.concatenate([[0.0], np.cumsum(sizes)])
    if even and len(sizes) > even:  # the graded part takes up what is left over, the even one stays
        rest = points[even + 1 :] - points[even]
        points[even + 1 :] = points[even] + rest * (length - points[even]) / rest[-1]
        return points
    return points * (length / points[-1])


def quarter_bar(radius: float, length: float, cells: int) -> tc.Mesh:
    """Return the quarter x, y >= 0 of a cylinder about the z axis, from z = 0 on, with `cells` cells across its radius.

    A square core, rounded a little, and a shell of two blocks around it; the cells are about as long as wide. Face sets
    xmin, ymin (planes of symmetry), zmin, zmax and rim.
    """
    across = max(1, round(0.6 * cells))
    shares = np.linspace(0.0, 1.0, max(1, cells - across) + 1)
    height = np.linspace(0.0, length, max(1, round(length * cells / radius)) + 1)
    line = np.linspace(0.0, 1.0, across + 1)
    x, y = np.meshgrid(line, line, indexing="ij")
    core = 0.5 * radius * np.stack([x * (1.0 + 0.15 * (1.0 - y**2)), y * (1.0 + 0.15 * (1.0 - x**2))], axis=-1)
    angle = np.pi / 4 * line
    rim = radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1)  # from the x axis to the diagonal
    grids = [core]
    for inner, outer in ((core[-1], rim), (core[:, -1], rim[:, ::-1])):
        grids.append(inner[:, None] + shares[:, None] * (outer - inner)[:, None])
    blocks = []
    for grid in grids:
        flat = np.concatenate([grid, np.zeros((*grid.shape[:2], 1))], axis=-1)
        blocks.append(flat[:, :, None] + height[:, None] * np.array([0.0, 0.0, 1.0]))
    tiny = 1e-6 * radius
    return join(
        blocks,
        {
            "xmin": lambda c: c[:, 0] < tiny,
            "ymin": lambda c: c[:, 1] < tiny,
            "zmin": lambda c: c[:, 2] < tiny,
            "zmax": lambda c: c[:, 2] > length - tiny,
            "rim": lambda c: (c[:, :2].min(axis=1) > tiny) & (c[:, 2] > tiny) & (c[:, 2] < length - tiny),
        },
        radius,
    )


def quarter_ball(radius: float, finest: float, even: int, growth: float = 1.3, cap: float = 0.4) -> tc.Mesh:
    """Return the quarter x, y >= 0 of a ball about 0, fine at its lowest point: `even` cells of size `finest` [m].

    Face sets xmin, ymin (planes of symmetry) and cap, the skin within `cap` radii of the axis at the bottom.
    """
    core = 0.5 * radius
    across = graded(core, finest * core / radius, even, growth)  # cells widen on the way out to the skin
    down = graded(1.0, finest / (radius - core), even, growth)  # shares of the way from the skin to the core
    up = graded(2.0 * core, (down[-1] - down[-2]) * (radius - core), 1, 1.1) - core
    shares = np.linspace(0.0, 1.0, 5)

    def sphere(inner):
        """Return where a point of the core's surface comes out: by equal angles, spread evenly near the axis."""
        return radius * inner / np.linalg.norm(inner, axis=-1, keepdims=True)

    def grid(*axes):
        return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)

    blocks = [grid(across, across, up)]
    bottom, top = (grid(across, across, np.array([z]))[:, :, 0] for z in (-core, core))
    blocks += [between(sphere(bottom), bottom, down), between(top, sphere(top), shares)]
    for axis in (0, 1):
        face = grid(*[np.array([core]) if j == axis else across for j in (0, 1)], up)
        face = face[0] if axis == 0 else face[:, 0]
        blocks.append(between(face, sphere(face), shares))
    tiny = 1e-6 * radius
    return join(
        blocks,
        {
            "xmin": lambda c: c[:, 0] < tiny,
            "ymin": lambda c: c[:, 1] < tiny,
            "cap": lambda c: (
                (np.linalg.norm(c, axis=1) > 0.98 * radius)
                & (c[:, :2].min(axis=1) > tiny)
                & (c[:, 2] < 0)
                & (np.hypot(c[:, 0], c[:, 1]) < cap * radius)
            ),
        },
        radius,
    )
