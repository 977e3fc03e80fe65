"""Obstacles from a distance function: exact distances, order of the error, what is no distance, a drop on a torus."""

import copy
import pickle
import re
import warnings

import numpy as np
import pytest
from scenes import python

import tcontact as tc
from tcontact.run.checkpoint.fingerprint import fingerprint


def torus(points, ring=0.3, tube=0.1):
    x, y, z = points.T
    return np.hypot(np.hypot(x, y) - ring, z) - tube


def torus_normal(points):
    x, y, z = points.T
    wide = np.hypot(x, y)
    away = np.stack([x - 0.3 * x / wide, y - 0.3 * y / wide, z], axis=1)
    return away / np.linalg.norm(away, axis=1)[:, None]


def ball(points):
    return np.linalg.norm(points - (0.1, 0.0, -0.2), axis=1) - 0.4


def near_torus(count=3000):
    """Points within a tenth of the tube from the surface."""
    random = np.random.default_rng(2)
    (round_, about), away = random.uniform(0, 2 * np.pi, (2, count)), random.uniform(0.09, 0.11, count)
    wide = 0.3 + away * np.cos(about)
    return np.stack([wide * np.cos(round_), wide * np.sin(round_), away * np.sin(about)], axis=1)


def test_a_sphere_is_the_sphere():
    """Gap and normal, also far beyond the grid, where the distance continues linearly from its nearest point."""
    made = tc.Sdf.from_function(ball, (-0.4, -0.5, -0.7), (0.6, 0.5, 0.3), cells=50)
    sphere = tc.Sphere((0.1, 0.0, -0.2), 0.4)
    random = np.random.default_rng(1).normal(size=(2000, 3))
    x = (
        np.array((0.1, 0.0, -0.2))
        + random / np.linalg.norm(random, axis=1)[:, None] * np.linspace(0.35, 0.48, 2000)[:, None]
    )
    assert np.abs(made.gap(x) - sphere.gap(x)).max() < 4e-4  # h^2/(8 R) 2
    assert np.abs(made.normal_at(x) - sphere.normal_at(x)).max() < 5e-3
    assert made.gap(np.array([[5.0, 0.0, -0.2]]))[0] == pytest.approx(4.5, rel=0.02)


def test_the_error_of_a_torus_falls_with_the_square_of_the_spacing():
    x = near_torus()
    errors, turns = [], []
    for cells in (40, 80):
        made = tc.Sdf.from_function(torus, (-0.5, -0.5, -0.2), (0.5, 0.5, 0.2), cells)
        assert made.spacing == 1.0 / cells
        errors.append(np.abs(made.gap(x) - torus(x)).max())
        turns.append(np.abs(made.normal_at(x) - torus_normal(x)).max())
    assert 3.0 < errors[0] / errors[1] < 5.0
    assert turns[0] / turns[1] > 2.5
    assert errors[1] < 1.0 / 80**2 / 8.0 / 0.1 * 2.0


def test_the_grid_holds_the_box():
    """With the spacing of its longest side, at least four nodes along every axis, and its middle."""
    made = tc.Sdf.from_function(lambda x: x[:, 2] - 0.01, (0.0, 0.0, -0.1), (1.0, 0.35, 0.12), cells=10, name="floor")
    assert made.name == "floor"
    assert made.nodes == (11, 5, 4)
    last = made.origin + made.spacing * (np.array(made.nodes) - 1)
    assert (made.origin <= (1e-12, 1e-12, -0.1 + 1e-12)).all()
    assert (last >= np.array((1.0, 0.35, 0.12)) - 1e-12).all()
    np.testing.assert_allclose(0.5 * (made.origin + last), (0.5, 0.175, 0.01), atol=1e-12)


def box(points):
    """The exact distance to a cube, whose gradient jumps at edges."""
    away = np.abs(points) - 0.3
    return np.linalg.norm(np.maximum(away, 0.0), axis=1) + np.minimum(away.max(axis=1), 0.0)


@pytest.mark.parametrize(
    ("function", "slope"),
    [
        (torus, None),
        (box, None),
        (lambda x: (x**2).sum(axis=1) - 0.09, "slopes of 0.5.* to 0.7"),
        (lambda x: 2.0 * torus(x), "1.98 in the"),
        (lambda x: np.linalg.norm(x * (1.0, 1.0, 2.0), axis=1) - 0.3, "slopes of 0.999 to 1.9"),
    ],
)
def test_what_is_no_distance_is_told_with_its_slopes(function, slope):
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        tc.Sdf.from_function(function, (-0.45, -0.45, -0.45), (0.45, 0.45, 0.45), cells=24)
    assert [one.category for one in seen] == ([] if slope is None else [RuntimeWarning])
    if slope is not None:
        assert re.search(slope, str(seen[0].message))


@pytest.mark.parametrize(
    ("change", "field", "remedy"),
    [
        ({"distance": lambda x: np.full(len(x), np.nan)}, "Sdf.distance", "finite numbers"),
        ({"distance": lambda x: np.where(x[:, 2] > 0.0, np.inf, torus(x))}, "Sdf.distance", "finite numbers"),
        ({"distance": lambda x: 0.5 + torus(x)}, "Sdf.distance", "none is inside"),
        ({"distance": lambda x: torus(x) - 5.0}, "Sdf.distance", "none is outside"),
        ({"distance": lambda x: 0.0 * torus(x)}, "Sdf.distance", "give a box around"),
        ({"distance": lambda x: torus(x)[:3]}, "Sdf.distance", "it returned shape"),
        ({"distance": lambda x: 1 / 0}, "Sdf.distance", "the callable failed"),
        ({"distance": np.zeros((9, 9, 9))}, "Sdf.distance", "give a function"),
        ({"high": (-0.5, 0.5, 0.2)}, "Sdf.high", "must be above"),
        ({"low": (0.0, 0.0)}, "Sdf.low", "finite numbers"),
        ({"cells": 2}, "Sdf.cells", "whole number"),
        ({"cells": 10**6}, "Sdf.nodes", "larger spacing"),
    ],
)
def test_bad_input_names_the_field(change, field, remedy):
    given = {"distance": torus, "low": (-0.5, -0.5, -0.2), "high": (0.5, 0.5, 0.2), "cells": 10} | change
    with pytest.raises(tc.InputError, match=remedy) as caught:
        tc.Sdf.from_function(**given)
    assert caught.value.field == field


def dropped(**options):
    """A soft cube of 3^3 cells above the crown of a torus."""
    mesh = tc.box_mesh((0.1, 0.1, 0.1), (3, 3, 3), origin=(0.25, -0.05, 0.101))
    ring = tc.Sdf.from_function(torus, (-0.5, -0.5, -0.2), (0.5, 0.5, 0.2), cells=64, name="ring", **options)
    cube = tc.Body(mesh, tc.NeoHookean(1e6, 0.3, 1000.0), (0.0, 0.0, -1.0), contact="zmin")
    return tc.Scene([cube], [ring], duration=0.01, contact=tc.MasslessContact(removal="full"))


def test_a_body_dropped_on_a_torus():
    """Energy and momentum are kept, and no node gets below the exact torus by more than the error of the samples."""
    scene = dropped()
    result = tc.simulate(scene)
    history = result.history
    assert result.ok
    assert history["contact_force"][:, 2].max() > 0.0
    assert np.abs(history["energy_error"]).max() < 2e-2
    given = history["momentum"] - history["momentum"][0]
    assert np.abs(given - history["impulse"]).max() < 1e-6 * np.abs(history["momentum"][0]).max()
    assert history["gap_min"].min() > -1e-6


def test_scene_files_keep_the_samples(tmp_path):
    scene = dropped(velocity=(0.0, 0.0, 0.1))
    tc.save_scene(scene, tmp_path / "scene.toml")
    (again,) = tc.load_scene(tmp_path / "scene.toml")[0].obstacles
    assert (again.grid == scene.obstacles[0].grid).all()
    assert again.parameters == scene.obstacles[0].parameters


@pytest.mark.parametrize("options", [{}, {"gradient": lambda points: np.tile((0.6, 0.0, 0.8), (len(points), 1))}])
def test_scenes_reach_other_processes(options, tmp_path):
    """Functions that have no name cannot go there; the samples do, and a run may be resumed there."""
    ring = tc.Sdf.from_function(lambda x: torus(x), (-0.5, -0.5, -0.2), (0.5, 0.5, 0.2), cells=16, **options)
    cube = tc.Body(tc.box_mesh((0.1, 0.1, 0.1), (1, 1, 1)), tc.LinearElastic(1e6, 0.3, 1000.0), contact="zmin")
    scene = tc.Scene([cube], [ring], duration=0.01)
    data = pickle.dumps(scene)
    for again in (pickle.loads(data), copy.deepcopy(scene)):
        (known,) = again.obstacles
        assert (known.grid == ring.grid).all()
        assert known.parameters == ring.parameters
        assert fingerprint(again, tc.CentralDifference()) == fingerprint(scene, tc.CentralDifference())
    (tmp_path / "scene").write_bytes(data)
    code = "import pathlib, pickle; (ring,) = pickle.loads(pathlib.Path(sys.argv[1]).read_bytes()).obstacles\n"
    done = python(code + "print(ring.gap([[0.3, 0.1, 0.02]])[0].hex())", tmp_path / "scene")
    assert done.stdout.strip() == ring.gap(np.array([[0.3, 0.1, 0.02]]))[0].hex(), done.stderr
