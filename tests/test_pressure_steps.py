"""The stable step counts the stiffness of pressures that follow their faces; slow crushing is not taken for a shock."""

import numpy as np
import pytest
from scenes import block, material, simulate

import tcontact as tc
from tcontact.planning.pressure_rates import PressureRate

SIDES = ("xmin", "xmax", "ymin", "ymax", "zmin", "zmax")
YOUNG = 1e6


def forces(nodes, faces, pressure):
    """Forces [n, 3] of a pressure of every face, by 3 x 3 points of its bilinear surface."""
    xi, eta = np.array([-1.0, 1.0, 1.0, -1.0]), np.array([-1.0, -1.0, 1.0, 1.0])
    found, x = np.zeros_like(nodes), nodes[faces]
    places, weights = np.polynomial.legendre.leggauss(3)
    for s, over_s in zip(places, weights, strict=True):
        for t, over_t in zip(places, weights, strict=True):
            value = 0.25 * (1.0 + xi * s) * (1.0 + eta * t)
            along = np.einsum("a,fac->fc", 0.25 * xi * (1.0 + eta * t), x)
            across = np.einsum("a,fac->fc", 0.25 * eta * (1.0 + xi * s), x)
            normal = over_s * over_t * pressure[:, None] * np.cross(along, across)
            np.add.at(found, faces, -np.einsum("a,fc->fac", value, normal))
    return found


def largest_rate(plan, displacement, pressures):
    """Largest eigenvalue [1/s^2] of the symmetric part of M^-1 L, by differences of the forces."""
    mesh = plan.body.mesh
    faces = [mesh.faces_of(name) for name in pressures]
    values = np.repeat(list(pressures.values()), [len(part) for part in faces])
    faces = np.concatenate([part if part.shape[1] == 4 else part[:, [0, 1, 2, 2]] for part in faces])
    size = 3 * mesh.node_count
    stiffness = np.zeros((size, size))
    for row in range(size):
        way = np.zeros(size)
        way[row] = 1e-6
        ends = [forces(mesh.nodes + displacement + sign * way.reshape(-1, 3), faces, values) for sign in (1, -1)]
        stiffness[:, row] = (ends[1] - ends[0]).ravel() / 2e-6
    scale = 1.0 / np.sqrt(np.repeat(plan.lumped[plan.place], 3))
    return np.linalg.eigvalsh(0.5 * (stiffness + stiffness.T) * scale * scale[:, None])[-1]


@pytest.mark.parametrize("kind", ["hex8", "tet4", "wedge6"])
@pytest.mark.parametrize("sides", [SIDES, ("zmax",)])
def test_the_bound_is_above_the_stiffness_of_the_pressures_and_not_far(kind, sides):
    """Against the exact eigenvalue on a distorted block, under one pressure all round and two on parts of it."""
    mesh = block(kind, 2, shake=0.2)
    pressures = {name: 1e6 * (1.0 + number % 2) for number, name in enumerate(sides)}
    body = tc.Body(mesh, material(), loads=[tc.Load(name, pressure=value) for name, value in pressures.items()])
    plan = tc.plan(tc.Scene([body], duration=1.0)).bodies[0]
    moved = 0.01 * np.random.default_rng(2).uniform(-1.0, 1.0, mesh.nodes.shape)
    rate = PressureRate.of(plan, 1.0)
    found = rate.bound(moved[plan.node_order][rate.rows])
    exact = largest_rate(plan, moved, pressures)
    assert exact <= found <= 2.5 * exact


def test_the_largest_pressure_of_the_run_counts():
    """A number, functions of time of either sign and of place, and one that fails on the way give the same bound."""

    def failing(time):
        if time > 0.4:
            raise ValueError("no more")
        return -2e5 * time / 0.4

    mesh = block("hex8", 2, shake=0.0)
    found = []
    for given in (2e5, lambda t: -2e5 * np.sin(np.pi * t), lambda t, x: 2e5 * t * np.ones(len(x)), failing):
        body = tc.Body(mesh, material(), loads=[tc.Load("zmax", pressure=given)])
        rate = PressureRate.of(tc.plan(tc.Scene([body], duration=1.0)).bodies[0], 1.0)
        found.append(rate.bound(np.zeros((len(rate.rows), 3))))
    assert found == pytest.approx([found[0]] * 4, rel=1e-2)
    assert PressureRate.of(tc.plan(tc.Scene([tc.Body(mesh, material())], duration=1.0)).bodies[0], 1.0) is None


def pressed(share, sides=SIDES, **options):
    """A free cube under a pressure that rises slowly to a share of Young's modulus."""
    mesh = tc.box_mesh((0.1, 0.1, 0.1), (3, 3, 3))
    nodes = np.array(mesh.nodes)
    inside = ((nodes > 1e-9) & (nodes < 0.1 - 1e-9)).all(axis=1)
    nodes += np.random.default_rng(0).uniform(-0.004, 0.004, nodes.shape) * inside[:, None]
    mesh = tc.Mesh(nodes, mesh.cells, "hex8", face_sets=mesh.face_sets)
    loads = [tc.Load(side, pressure=lambda t: share * YOUNG * t / 0.3) for side in sides]
    body = tc.Body(mesh, tc.NeoHookean(young=YOUNG, poisson=0.3, density=1000.0), loads=loads)
    return tc.Scene([body], duration=0.3, damping=tc.MassDamping(100.0), **options)


@pytest.mark.parametrize("share", [3.0, -0.3])
def test_a_soft_cube_under_a_high_pressure_is_stable_at_the_default_cfl(share):
    """Three times its modulus: the step of the cells alone is 1.04 times the limit, and the run blew up."""
    result = simulate(pressed(share))
    assert result.history["energy_error"].max() <= 1e-4
    assert result.history["kinetic"].max() <= 1e-3 * result.history["elastic"].max()


def test_a_pressure_takes_little_of_the_step_in_the_usual_range():
    plain = simulate(pressed(0.0)).dt_limit
    assert 0.95 * plain < simulate(pressed(0.1)).dt_limit < plain


def test_slow_crushing_is_told_as_such():
    """A driven support pushes the top through the bottom: no viscosity is advised, but a lower cfl."""
    mesh = tc.box_mesh((0.1, 0.1, 0.1), (3, 3, 3))
    law = tc.NeoHookean(young=YOUNG, poisson=0.3, density=1000.0)
    driven = tc.Support("zmax", "xyz", displacement=lambda t: (0.0, 0.0, -0.11 * t))
    body = tc.Body(mesh, law, supports=[tc.Support("zmin", "xyz"), driven])
    result = tc.simulate(tc.Scene([body], duration=1.0, damping=tc.MassDamping(100.0)))
    assert result.reason == "inverted-cell"
    assert "no shock" in result.message
    assert "cfl" in result.message
    assert "iscosity" not in result.message
