"""The distance between triangles: against dense sampling, and where they cut, touch, or lie apart by a known amount."""

import numpy as np
import pytest
from oracle import meshes

from tcontact.mesh.triangle_distance import smallest_distance, winding_number

FAR = 1e3


def samples(triangle, parts=40):
    """Points all over a triangle."""
    a, b = np.meshgrid(np.linspace(0.0, 1.0, parts), np.linspace(0.0, 1.0, parts))
    a, b = a[a + b <= 1.0], b[a + b <= 1.0]
    return triangle[0] + a[:, None] * (triangle[1] - triangle[0]) + b[:, None] * (triangle[2] - triangle[0])


def test_random_triangles_are_as_far_apart_as_their_points():
    generator = np.random.default_rng(2)
    cut = 0
    for _ in range(60):
        one, other = generator.normal(size=(2, 3, 3))
        other = other + generator.uniform(-2.0, 2.0, 3)
        here, there = samples(one), samples(other)
        least = np.linalg.norm(here[:, None] - there[None], axis=2).min()
        found = smallest_distance(one[None], other[None], FAR)
        assert found <= least + 1e-12
        assert found >= least - 0.15 * max(np.ptp(one), np.ptp(other)) * 0.5
        if least > 0.5:
            assert found == pytest.approx(least, rel=0.02)
        cut += found == 0.0
    assert 3 <= cut <= 40  # both kinds were there


@pytest.mark.parametrize("turn", [0, 3])
def test_known_distances(turn):
    """A corner over a face, two skew edges, an edge through a face, parallel faces, apart by a known amount."""
    q = np.eye(3) if turn == 0 else meshes.rotation(turn)
    floor = np.array([[-1.0, -1.0, 0.0], [3.0, -1.0, 0.0], [-1.0, 3.0, 0.0]])
    cases = [
        ([[0.1, 0.1, 0.25], [0.0, 0.0, 1.0], [0.3, 0.0, 1.0]], 0.25),  # corner over a face
        ([[0.5, -1.5, -1.0], [0.5, -1.5, 1.0], [0.5, -4.0, 0.0]], 0.5),  # edge beside an edge
        ([[0.1, 0.1, -1.0], [0.2, 0.1, 1.0], [5.0, 5.0, 8.0]], 0.0),  # edge through the face
        ([[0.0, 0.0, 0.3], [0.1, 0.0, 0.3], [0.0, 0.1, 0.3]], 0.3),  # parallel
        ([[-1.0, -1.0, 0.0], [-3.0, -1.0, 1.0], [-3.0, -1.0, 2.0]], 0.0),  # a common corner
    ]
    for corners, wanted in cases:
        found = smallest_distance((floor @ q.T)[None] + 7.0, (np.array(corners) @ q.T)[None] + 7.0, FAR)
        assert found == pytest.approx(wanted, abs=1e-12)


def test_many_triangles_of_uneven_size_are_searched_as_one_by_one():
    generator = np.random.default_rng(5)
    first = generator.uniform(0.0, 1.0, (40, 1, 3)) + 0.3 * generator.normal(size=(40, 3, 3))
    second = generator.uniform(0.0, 1.0, (60, 1, 3)) + 0.02 * generator.normal(size=(60, 3, 3)) + (0.0, 0.0, 2.2)
    wanted = min(smallest_distance(a[None], b[None], FAR) for a in first for b in second)
    assert 0.05 < wanted < 2.0
    assert smallest_distance(first, second, FAR) == pytest.approx(wanted, rel=1e-12)
    assert smallest_distance(first, second, 1.01 * wanted) == pytest.approx(wanted, rel=1e-12)
    assert smallest_distance(first, second, 0.99 * wanted) == 0.99 * wanted
    assert smallest_distance(1e6 * first, 1e6 * second, 1e9) == pytest.approx(1e6 * wanted, rel=1e-9)


def test_a_closed_surface_winds_once_around_what_is_inside():
    corners = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    surface = corners[np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])]
    assert winding_number(np.array([0.1, 0.1, 0.1]), surface) == pytest.approx(1.0)
    assert winding_number(np.array([0.5, 0.5, 0.5]), surface) == pytest.approx(0.0, abs=1e-12)
