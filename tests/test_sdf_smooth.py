"""Sampled distances in implicit steps: a gap without kinks, on which Newton's method finds the end of every step."""

import numpy as np
import pytest

import tcontact as tc
from tcontact.scene.obstacles.cubic import smooth_distance

ORIGIN, SPACING, NODES = np.array([-0.2, 0.1, 0.3]), 0.1, (6, 5, 4)


def grid():
    """Nodes [nx, ny, nz, 3]."""
    lines = [start + SPACING * np.arange(n) for start, n in zip(ORIGIN, NODES, strict=True)]
    return np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1)


def test_quadratics_are_exact_up_to_the_edge_of_the_grid():
    generator = np.random.default_rng(1)
    curved = generator.standard_normal((3, 3))
    curved, slope = curved + curved.T, np.array([1.0, -2.0, 3.0])

    def function(x):
        return 0.5 * np.einsum("...i,ij,...j->...", x, curved, x) + x @ slope

    x = ORIGIN + SPACING * generator.uniform(0.0, 1.0, (300, 3)) * (np.array(NODES) - 1)
    value, gradient, second = smooth_distance(function(grid()), ORIGIN, SPACING, x)
    assert np.abs(value - function(x)).max() < 1e-13
    assert np.abs(gradient - (x @ curved + slope)).max() < 1e-12
    assert np.abs(second - curved).max() < 1e-10


def test_derivatives_are_those_of_the_value_within_and_beyond_the_grid():
    generator = np.random.default_rng(2)
    sampled, step = generator.standard_normal(NODES), 1e-6
    x = ORIGIN + SPACING * generator.uniform(-0.5, 1.5, (500, 3)) * (np.array(NODES) - 1)
    _, gradient, second = smooth_distance(sampled, ORIGIN, SPACING, x)
    ends = [[smooth_distance(sampled, ORIGIN, SPACING, x + sign * step * e) for e in np.eye(3)] for sign in (1, -1)]
    slopes = np.stack([(up[0] - down[0]) / (2 * step) for up, down in zip(*ends, strict=True)], axis=1)
    assert np.abs(slopes - gradient).max() < 1e-6 * np.abs(gradient).max()
    within = (np.abs((x - ORIGIN) / SPACING / (np.array(NODES) - 1) - 0.5) < 0.499).all(axis=1)
    turns = np.stack([(up[1] - down[1]) / (2 * step) for up, down in zip(*ends, strict=True)], axis=2)
    assert np.median(np.abs(turns - second)[within]) < 1e-6 * np.abs(second).max()


def test_the_gradient_has_no_jump_at_the_faces_and_edges_of_the_grid():
    generator = np.random.default_rng(3)
    sampled = generator.standard_normal(NODES)
    faces = ORIGIN + SPACING * generator.integers(0, NODES, (300, 3))
    faces = faces + SPACING * generator.uniform(-0.4, 0.4, (300, 3)) * (generator.uniform(size=(300, 3)) < 0.5)
    faces = np.clip(faces, ORIGIN, ORIGIN + SPACING * (np.array(NODES) - 1))
    off = 1e-9 * generator.standard_normal((300, 3))
    one, other = (smooth_distance(sampled, ORIGIN, SPACING, faces + side * off)[1] for side in (1.0, -1.0))
    assert np.abs(one - other).max() < 1e-5


@pytest.mark.parametrize("contact", ["exact", "penalty"])
@pytest.mark.parametrize("reproject", [True, False])
def test_massless_nodes_slide_on_a_sampled_ball_as_on_a_sphere(contact, reproject):
    """With the kinks of a trilinear gap Newton's method found no end of the second step."""
    mesh = tc.box_mesh(size=(10.0, 8.0, 7.0), cells=(3, 2, 2), origin=(-5.0, -4.0, 0.05))
    spin, speed = (30.0, -20.0, 50.0), np.array([100.0, -20.0, -3e3])
    body = tc.Body(mesh, tc.NeoHookean(2.0, 0.33, 1e-9), lambda x: np.cross(spin, x) + speed, contact="zmin")
    center, radius = np.array([0.3, -0.2, -25.0]), 25.0
    sampled = tc.Sdf(
        distance=lambda x: np.linalg.norm(x - center, axis=1) - radius,
        origin=(-15.3, -15.1, -10.2), spacing=2.5, nodes=(13, 13, 8),
    )  # fmt: skip
    model = tc.MasslessContact(removal="full", penalty=36.0 if contact == "penalty" else None)
    found = []
    for wall in (sampled, tc.Sphere(center=center, radius=radius)):
        scene = tc.Scene(bodies=[body], obstacles=[wall], duration=6e-4, contact=model)
        result = tc.simulate(scene, scheme=tc.DiscreteGradient(dt=2.5e-5, reproject=reproject))
        assert result.ok, result.message
        found.append(result.history)
    smooth, exact = found
    energy, momentum = smooth["energy"], smooth["momentum"] - smooth["impulse"]
    assert np.abs(momentum - momentum[0]).max() < 1e-10 * np.abs(momentum[0]).max()
    assert np.diff(energy).max() < 1e-10 * energy[0]
    if contact == "penalty" and not reproject:
        assert np.abs(energy - energy[0]).max() < 1e-10 * energy[0]
    assert smooth["sweeps"].mean() < exact["sweeps"].mean() + 0.5
    difference = np.abs(smooth["contact_force"] - exact["contact_force"]).max()
    assert difference < 0.02 * np.abs(exact["contact_force"]).max()
