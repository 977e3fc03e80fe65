"""Functions that return one array of their own at every call give the run of functions that return new ones."""

import functools

import numpy as np
import pytest

import tcontact as tc
from tcontact.run.checkpoint.fingerprint import _samples

RATE = 300.0  # of the functions [1/s]


def fresh(function):
    """The function itself, which returns new values at every call."""
    return function


class Reused:
    """A function that writes its values into an array made at the first call and returns that array."""

    kind = float

    def __init__(self, function):
        functools.update_wrapper(self, function)  # what it may be called with is told by its parameters
        self.function, self.values = function, None

    def __call__(self, *arguments):
        found = np.asarray(self.function(*arguments), dtype=self.kind)
        if self.values is None:
            self.values = np.zeros_like(found)
        self.values[...] = found
        return self.values


class ReusedComplex(Reused):
    """A function that writes complex values into an array of its own and returns that array."""

    kind = complex


def wave(*size):
    """A vector function of time."""
    return lambda time: np.array(size) * np.sin(RATE * time)


def body(**options):
    """A small block, whose steps go by several to a launch."""
    mesh = tc.box_mesh((0.1, 0.1, 0.1), (2, 2, 2))
    return tc.Body(mesh, tc.NeoHookean(young=1e6, poisson=0.3, density=1000.0), **options)


def plane(made):
    """A wall that swings below the block."""
    velocity, spin = made(wave(0.0, 0.0, 1.0)), made(wave(0.0, 1.0, 0.0))
    return tc.Plane(point=(0.0, 0.0, -0.001), normal=(0.0, 0.0, 1.0), velocity=velocity, angular_velocity=spin)


def rigid(made):
    """A driven part."""
    return tc.RigidPart("zmin", driven=True, velocity=made(wave(0.0, 0.3, 0.0)), angular_velocity=made(wave(0, 0, 10)))


SCENES = {
    "gravity": lambda made: ([body()], {"gravity": made(wave(0.0, 0.0, -1000.0))}),
    "traction": lambda made: ([body(loads=[tc.Load("zmax", traction=made(wave(0.0, 0.0, 1e4)))])], {}),
    "force": lambda made: ([body(loads=[tc.Load("zmax", force=made(wave(0.0, 0.0, 100.0)))])], {}),
    "pressure": lambda made: (
        [body(loads=[tc.Load("zmax", pressure=made(lambda t, x: 1e4 * np.sin(RATE * t) * (1.0 + x[:, 0])))])], {},
    ),
    "own-force": lambda made: (
        [body(loads=[tc.Load("zmax", force=made(lambda x, v, t: np.sin(RATE * t) - 3.0 * v))])], {},
    ),
    "displacement": lambda made: (
        [body(supports=[tc.Support("zmin", "xyz", displacement=made(wave(0.0, 1e-3, 0.0)))])], {},
    ),
    "velocity": lambda made: ([body(supports=[tc.Support("zmin", "xyz", velocity=made(wave(0.0, 0.3, 0.0)))])], {}),
    "rigid-part": lambda made: ([body(rigid_parts=[rigid(made)])], {}),
    "obstacle": lambda made: ([body(contact="zmin")], {"obstacles": [plane(made)]}),
    "start": lambda made: ([body(velocity=made(lambda x: 0.1 * x), displacement=made(lambda x: 0.01 * x))], {}),
}  # fmt: skip


@pytest.mark.parametrize("name", SCENES)
def test_a_run_does_not_depend_on_the_array_that_a_function_returns(name):
    """The bits of both runs are equal, however many steps a launch takes."""
    results = []
    for made in (fresh, Reused):
        bodies, options = SCENES[name](made)
        scene = tc.Scene(bodies, duration=0.01, **options)
        results.append(tc.simulate(scene, scheme=tc.CentralDifference(dt=2e-4)))
    one, other = results
    assert one.ok
    assert other.ok
    assert np.abs(one.position - one.scene.bodies[0].mesh.nodes).max() > 1e-6
    assert np.array_equal(one.position, other.position)
    for column, values in one.history.items():
        assert np.array_equal(values, other.history[column]), column


def test_a_distance_and_its_gradient_may_share_an_array():
    """A grid keeps the values of a callable and not the array in which they came."""
    points = np.zeros((0, 4))

    def filled(x):
        nonlocal points
        points = points if len(points) else np.zeros((len(x), 4))
        points[:, 1:] = x / np.linalg.norm(x, axis=1)[:, None]
        points[:, 0] = np.linalg.norm(x, axis=1) - 0.1
        return points

    def sampled(values):
        options = {"cells": 12, "gradient": lambda x: values(x)[:, 1:]}
        return tc.Sdf.from_function(lambda x: values(x)[:, 0], (-0.2003,) * 3, (0.2,) * 3, **options).grid

    assert np.array_equal(sampled(lambda x: filled(x).copy()), sampled(filled))


def test_samples_that_identify_a_run_are_those_of_every_time():
    """Complex values, which no run takes, are copied like all others before the next call."""
    times = np.linspace(0.0, 1.0, 5)
    wanted, found = (_samples(made(lambda time: [1j * time]), "f", times) for made in (fresh, ReusedComplex))
    assert np.array_equal(wanted, found)
