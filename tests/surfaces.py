"""Closed surfaces of triangles for tests, oriented outward: points [k, 3], triangles [m, 3]."""

import numpy as np


def box(size=(1.0, 0.6, 0.4)):
    """Twelve triangles about the origin."""
    points = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]) * size
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return points, np.array([[q[0], q[i], q[i + 1]] for q in quads for i in (1, 2)])


def sphere(rings=16, sectors=16, radius=0.5):
    """Rings of quads, halved, and fans at the poles: 2 (rings - 1) sectors triangles."""
    polar, turn = np.pi * np.arange(1, rings) / rings, 2 * np.pi * np.arange(sectors) / sectors
    a, b = (part.ravel() for part in np.meshgrid(polar, turn, indexing="ij"))
    around = np.stack([np.sin(a) * np.cos(b), np.sin(a) * np.sin(b), np.cos(a)], axis=1)
    points = radius * np.concatenate([[[0, 0, 1.0]], around, [[0, 0, -1.0]]])
    ids = 1 + np.arange(len(around)).reshape(rings - 1, sectors)
    after = np.roll(ids, -1, axis=1)
    top = [[0, i, j] for i, j in zip(ids[0], after[0], strict=True)]
    bottom = [[len(points) - 1, j, i] for i, j in zip(ids[-1], after[-1], strict=True)]
    quads = np.stack([ids[:-1], ids[1:], after[1:], after[:-1]], axis=-1).reshape(-1, 4)
    return points, np.concatenate([top, quads[:, [0, 1, 2]], quads[:, [0, 2, 3]], bottom])


def torus(large=0.35, small=0.15, sectors=(40, 24)):
    """About the z axis: neither convex nor a star."""
    first, second = (2 * np.pi * np.arange(n) / n for n in sectors)
    a, b = (part.ravel() for part in np.meshgrid(first, second, indexing="ij"))
    reach = large + small * np.cos(b)
    points = np.stack([reach * np.cos(a), reach * np.sin(a), small * np.sin(b)], axis=1)
    ids = np.arange(len(points)).reshape(sectors)
    next_a, next_b = np.roll(ids, -1, axis=0), np.roll(ids, -1, axis=1)
    quads = np.stack([ids, next_a, np.roll(next_a, -1, axis=1), next_b], axis=-1).reshape(-1, 4)
    return points, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


def prism(outline, caps, length=0.6):
    """A polygon [n, 2] in x and y, counter-clockwise, along z; caps: its triangles [m, 3]."""
    outline, n = np.array(outline, dtype=float), len(outline)
    points = np.concatenate([np.c_[outline, np.full(n, z)] for z in (-0.5 * length, 0.5 * length)])
    sides = [corners for i in range(n) for j in [(i + 1) % n] for corners in ([i, j, n + j], [i, n + j, n + i])]
    ends = [corners for a, b, c in caps for corners in ([a, c, b], [n + a, n + b, n + c])]
    return points, np.array(sides + ends)


def wedge(degrees):
    """A knife of length 1 whose sides meet at an angle."""
    half = np.tan(np.radians(0.5 * degrees))
    return prism([(0, 0), (1, -half), (1, half)], [(0, 1, 2)])


def finned(thickness, height, place=0.52):
    """A block of 1 x 0.4 x 0.6 with a fin across it."""
    low, high = place - 0.5 * thickness, place + 0.5 * thickness
    outline = [(0, 0), (1, 0), (1, 0.4), (high, 0.4), (high, 0.4 + height), (low, 0.4 + height), (low, 0.4), (0, 0.4)]
    return prism(outline, [(0, 6, 7), (0, 3, 6), (0, 1, 3), (1, 2, 3), (3, 4, 5), (3, 5, 6)])


def joined(*surfaces):
    """Several surfaces as one."""
    starts = np.cumsum([0, *(len(points) for points, _ in surfaces)])
    triangles = [part + start for (_, part), start in zip(surfaces, starts, strict=False)]
    return np.concatenate([points for points, _ in surfaces]), np.concatenate(triangles)


def winding_number(points, triangles, position):
    """Sum of the solid angles over 4 pi (Van Oosterom and Strackee 1983)."""
    a, b, c = (points[triangles[:, i]] - position for i in range(3))
    la, lb, lc = (np.linalg.norm(x, axis=1) for x in (a, b, c))
    top = np.einsum("ni,ni->n", a, np.cross(b, c))
    dots = (np.einsum("ni,ni->n", x, y) for x, y in ((a, b), (a, c), (b, c)))
    ab, ac, bc = dots
    return np.arctan2(top, la * lb * lc + ab * lc + ac * lb + bc * la).sum() / (2 * np.pi)


def distance(points, triangles, position):
    """Distance to the nearest triangle: its plane where the foot lies within, else its edges (three cone tests)."""
    best = np.inf
    a, b, c = (points[triangles[:, i]] for i in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    within = np.ones(len(triangles), dtype=bool)
    for start, end in ((a, b), (b, c), (c, a)):
        within &= np.einsum("ni,ni->n", np.cross(normal, end - start), position - start) >= 0
        part = np.einsum("ni,ni->n", position - start, end - start) / np.einsum("ni,ni->n", end - start, end - start)
        foot = start + np.clip(part, 0, 1)[:, None] * (end - start)
        best = min(best, np.linalg.norm(position - foot, axis=1).min())
    heights = np.abs(np.einsum("ni,ni->n", normal, position - a))[within]
    return min(best, heights.min(initial=np.inf))


def signed_distance(surface, positions):
    """Brute force [n]."""
    points, triangles = surface
    return np.array(
        [distance(points, triangles, x) * (-1 if winding_number(points, triangles, x) > 0.5 else 1) for x in positions]
    )
