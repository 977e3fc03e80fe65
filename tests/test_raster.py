"""Triangles in the raster of pictures: coverage, what hides what, depths and colours along a triangle."""

import numpy as np
import pytest

from tcontact.device import runtime
from tcontact.show.render.raster import Raster
from tcontact.show.render.triangles import Triangles


def _raster(corners, value=None, table=None, size=(40, 30), colours=None):
    """Draw triangles [n,3,3] (x, y, w); returns depth and the codes of the pixels [height,width]."""
    runtime.start()
    width, height = size
    corners = np.asarray(corners, dtype=np.float64)
    scene = Triangles.plain(corners, 0 if table is None else np.asarray(table), 0.0 if value is None else value)
    colours = np.full(3 * 768, 200, np.float32) if colours is None else colours
    depth, pixel = np.zeros(width * height, np.float32), np.zeros(width * height, np.int32)
    place = slice(0, height), slice(0, width)
    Raster().draw(scene, width, place, 1, 0.0, colours, np.zeros_like(depth), depth, pixel)
    return depth.reshape(height, width), pixel.reshape(height, width)


def test_a_triangle_covers_the_pixel_centres_inside_it():
    _, pixel = _raster([[(2.0, 3.0, 1.0), (14.0, 3.0, 1.0), (2.0, 9.0, 1.0)]])
    row, col = np.mgrid[0:30, 0:40] + 0.5
    inside = (col > 2) & (row > 3) & ((col - 2) / 12 + (row - 3) / 6 < 1)
    np.testing.assert_array_equal(pixel != 0, inside)


@pytest.mark.parametrize("seed", range(3))
def test_a_net_of_triangles_has_no_holes_and_no_overlaps(seed):
    rng = np.random.default_rng(seed)
    n = 8
    # corners on pixel centres and in between: the ties are what this is about
    x, y = np.meshgrid(np.linspace(0, 40, n + 1), np.linspace(0, 30, n + 1))
    x[1:-1, 1:-1] += rng.integers(-3, 4, (n - 1, n - 1)) / 2
    y[1:-1, 1:-1] += rng.integers(-2, 3, (n - 1, n - 1)) / 2
    ids = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    quads = np.stack([ids[:-1, :-1], ids[:-1, 1:], ids[1:, 1:], ids[1:, :-1]], -1).reshape(-1, 4)
    corners = np.stack([x.ravel(), y.ravel(), np.ones(x.size)], 1)[
        np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 3, 2]]])
    ]
    times = sum((_raster(one[None])[1] != 0).astype(int) for one in corners)
    np.testing.assert_array_equal(times, np.ones((30, 40), int))
    assert (_raster(corners)[1] != 0).all()


def test_the_nearer_surface_wins_whatever_the_order():
    far = [(0.0, 0.0, 0.5), (80.0, 0.0, 0.5), (0.0, 60.0, 0.5)]
    near = [(0.0, 0.0, 0.5001), (80.0, 0.0, 0.5001), (0.0, 60.0, 0.5001)]
    for order, winner in (([far, near], 1), ([near, far], 0)):
        depth, pixel = _raster(order, table=[0, 1])
        assert (pixel >> 24 == 1 + winner).all()
        np.testing.assert_allclose(depth, 0.5001, rtol=1e-6)
    assert (_raster([far, far], table=[1, 0])[1] >> 24 == 2).all()  # equal depth: the first one stays


def test_depth_and_colour_run_linearly_along_a_triangle():
    colours = np.repeat(np.arange(256), 3).astype(np.float32)
    corners = [[(0.0, 0.0, 1.0), (80.0, 0.0, 1.0), (0.0, 60.0, 1.0)]]
    _, pixel = _raster(corners, value=np.array([[0.0, 2.0, 0.0]]), colours=colours)
    expected = np.round(255 * (np.arange(40) + 0.5) / 40)
    np.testing.assert_allclose(pixel[0] & 255, expected, atol=0.51)
    # a corner four times nearer: in the middle of the screen edge the surface point lies one fifth along it
    corners[0][0] = (0.0, 0.0, 4.0)
    _, pixel = _raster(corners, value=np.array([[0.0, 1.0, 0.0]]), colours=colours)
    s = (np.arange(40) + 0.5) / 80
    middle = 0.5 / 60
    np.testing.assert_allclose(pixel[0] & 255, 255 * s / (4 * (1 - s - middle) + s + middle), atol=0.51)


def test_values_at_and_beyond_the_range_take_the_end_colours():
    colours = np.repeat(np.arange(256), 3).astype(np.float32)
    corners = [[(0.0, 0.0, 1.0), (80.0, 0.0, 1.0), (0.0, 60.0, 1.0)]]
    for value, shade in ((-3.0, 0), (0.0, 0), (1.0, 255), (7.0, 255)):
        assert (_raster(corners, value=value, colours=colours)[1] & 255 == shade).all()
