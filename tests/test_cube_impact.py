"""Impact of cubes on a wall: restitution, mean force, edge- and corner-first energy."""

import numpy as np
import pytest
from oracle import meshes
from scenes import simulate, wall
from scipy.spatial.transform import Rotation

import tcontact as tc

SIDE, SPEED = 0.1, 10 / 3.6
SLOW = pytest.mark.slow


def cube_scene(cells, kind="hex8", law=tc.LinearElastic, removal="auto", turn=None, face="zmin", duration=3e-3):
    """A cube thrown flat; scene, wall normal, material."""
    turn = np.eye(3) if turn is None else turn
    mesh = tc.box_mesh((SIDE,) * 3, (cells,) * 3, kind).rotated(turn)
    normal = turn[:, "xyz".index(face[0])] * (1.0 if face.endswith("min") else -1.0)
    mat = law(young=1e7, poisson=0.3, density=1000.0)
    body = tc.Body(mesh, mat, velocity=-SPEED * normal, contact=face)
    contact = tc.MasslessContact(removal=removal)
    return tc.Scene(bodies=[body], obstacles=[wall(mesh, normal)], duration=duration, contact=contact), normal, mat


def flat(cells, **how):
    """Restitution, mean force over rho c_p v A from 0.25 to 1.2 ms, and the history."""
    scene, normal, mat = cube_scene(cells, **how)
    history = simulate(scene, cfl=0.8).history
    restitution = history["momentum"][-1] @ normal / (mat.density * SIDE**3 * SPEED)
    impulse = np.interp([0.25e-3, 1.2e-3], history["time"], history["impulse"] @ normal)
    mean = np.diff(impulse)[0] / 0.95e-3 / (mat.density * mat.wave_speed * SPEED * SIDE**2)
    return restitution, mean, history


@pytest.mark.parametrize(("removal", "face", "seed"), [("auto", "zmin", None), ("full", "xmax", 15)])
@pytest.mark.parametrize(("cells", "rebound", "force"), [
    (8, (0.795, 0.02), (0.82, 0.03)), pytest.param(16, (0.794, 0.006), (0.806, 0.008), marks=SLOW),
])  # fmt: skip
def test_restitution_and_mean_force_of_a_linear_cube(cells, rebound, force, removal, face, seed):
    turn = None if seed is None else meshes.rotation(seed)
    restitution, mean, history = flat(cells, removal=removal, turn=turn, face=face)
    assert restitution == pytest.approx(rebound[0], abs=rebound[1])
    assert mean == pytest.approx(force[0], abs=force[1])
    assert history["energy_error"][-1] <= 1e-2
    assert not history["contact_force"][-1].any()  # it has left


@pytest.mark.parametrize(("cells", "bound"), [(8, 5e-3), pytest.param(16, 5e-3, marks=SLOW)])
@pytest.mark.parametrize(("kind", "law"), [("hex8", tc.LinearElastic), ("tet4", tc.NeoHookean)])
def test_normal_and_full_removal_rebound_alike(cells, bound, kind, law):
    one, _, _ = flat(cells, kind=kind, law=law, removal="normal")
    two, _, _ = flat(cells, kind=kind, law=law, removal="full")
    assert abs(one / two - 1.0) <= bound


TILTS = {"edge": (45.0, 0.0), "corner": (45.0, np.degrees(np.arctan(2**-0.5)))}


@pytest.mark.parametrize("tilt", TILTS)
@pytest.mark.parametrize(("kind", "cells"), [
    ("hex8", 8), ("tet4", 6), pytest.param("hex8", 16, marks=SLOW), pytest.param("tet4", 16, marks=SLOW),
])  # fmt: skip
def test_energy_of_edge_and_corner_first_impacts(kind, cells, tilt):
    """The cube leaves the wall, with its energy, and no node of the faces that look down went through it."""
    lean = Rotation.from_euler("yx", TILTS[tilt], degrees=True).as_matrix()
    faces = ["xyz"[axis] + ("min" if lean[2, axis] > 0 else "max") for axis in range(3) if abs(lean[2, axis]) > 0.05]
    world = meshes.rotation(cells)
    mesh = tc.box_mesh((SIDE,) * 3, (cells,) * 3, kind).rotated(world @ lean)
    normal = world[:, 2]
    mat = tc.NeoHookean(young=1e7, poisson=0.3, density=1000.0)
    body = tc.Body(mesh, mat, velocity=-SPEED * normal, contact=faces)
    duration = (18 if tilt == "corner" else 10) * SIDE / mat.wave_speed
    scene = tc.Scene(
        bodies=[body], obstacles=[wall(mesh, normal, 1e-4)], duration=duration, contact=tc.MasslessContact()
    )
    assert tc.plan(scene).bodies[0].contact.removal == "full"
    history = simulate(scene, cfl=0.8).history
    assert history["energy_error"].max() <= 5e-3
    assert np.abs(history["contact_force"]).max() > 0.0
    assert not history["contact_force"][-1].any()
    assert history["gap_min"].min() >= -1e-12 * SIDE
    assert history["momentum"][-1] @ normal > 0.3 * mat.density * SIDE**3 * SPEED


def test_a_symmetric_impact_stays_symmetric():
    """A flat cube of hexes: no sideways force, momentum or spin; equal forces at mirrored nodes."""
    scene, normal, mat = cube_scene(6, law=tc.NeoHookean, removal="full", duration=1e-3)
    result = simulate(scene, cfl=0.8)
    history = result.history
    scale = np.abs(history["contact_force"]).max()
    assert np.abs(history["contact_force"][:, :2]).max() <= 1e-8 * scale
    assert np.abs(history["momentum"][:, :2]).max() <= 1e-9 * mat.density * SIDE**3 * SPEED
    force = result.contact_node_force[:, 2].reshape(7, 7, 7)[0]
    assert force.max() > 0.0
    assert np.allclose(force, force.T, rtol=1e-5, atol=1e-7 * force.max())
    assert np.allclose(force, force[::-1], rtol=1e-5, atol=1e-7 * force.max())
    assert normal @ history["impulse"][-1] > 0.0
