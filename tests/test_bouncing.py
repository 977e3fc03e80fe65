"""A bar that bounces on a floor under gravity: several contacts, exact waves between them."""

import numpy as np
import oracle
import pytest
from oracle import meshes
from scenes import simulate

import tcontact as tc

LENGTH, YOUNG, DENSITY, PULL, DROP = 1.0, 9e5, 1000.0, 25.0, 0.11  # c = 30 m/s


def bounce(kind, axis, contact, cfl, landings, count=80, seed=6):
    """A slanted bar dropped along its axis; result, wall normal, duration."""
    turn, width = meshes.rotation(seed), LENGTH / count
    size, cells = [width] * 3, [1] * 3
    size[axis], cells[axis] = LENGTH, count
    mesh = tc.box_mesh(size, cells, kind).rotated(turn)
    normal = turn[:, axis]
    mat = tc.LinearElastic(young=YOUNG, poisson=0.0, density=DENSITY)
    fall = np.sqrt(2 * DROP / PULL)
    wave = 2 * LENGTH / np.sqrt(YOUNG / DENSITY)
    duration = fall + (landings - 1) * (2 * fall + wave) + wave + 0.2 * fall
    point = ((mesh.nodes @ normal).min() - DROP) * normal
    scene = tc.Scene(
        bodies=[tc.Body(mesh, mat, contact="xyz"[axis] + "min")],
        obstacles=[tc.Plane(point, normal)],
        duration=duration,
        gravity=-PULL * normal,
        contact=contact,
    )
    return simulate(scene, cfl=cfl), normal, duration


@pytest.mark.parametrize(("kind", "axis", "removal"), [("hex8", 1, "auto"), ("tet4", 2, "full")])
@pytest.mark.parametrize(("cfl", "bound"), [(0.9, 5e-3), (0.5, 2e-3)])
def test_energy_after_four_contacts(kind, axis, removal, cfl, bound):
    result, normal, _ = bounce(kind, axis, tc.MasslessContact(removal=removal), cfl, 4)
    force = result.history["contact_force"] @ normal
    touching = force > 1e-6 * force.max()
    quiet = np.diff(np.flatnonzero(touching)) * result.dt > 0.5 * np.sqrt(2 * DROP / PULL)
    assert 1 + quiet.sum() == 4  # contacts that long flights part
    assert result.history["energy_error"].max() <= bound


def test_impulse_against_the_method_of_characteristics():
    """The running impulse of two contacts; between them the steady flight gives nothing."""
    result, normal, duration = bounce("hex8", 0, tc.MasslessContact(), 0.9, 2)
    history = result.history
    exact = oracle.BarImpact(LENGTH, (LENGTH / 80) ** 2, YOUNG, DENSITY, 0.0, DROP)
    time, force, _, _ = oracle.characteristic_bar(exact, PULL, duration, 800)
    given = np.concatenate([[0.0], np.cumsum(force[1:] * np.diff(time))])
    error = np.abs(history["impulse"] @ normal - np.interp(history["time"], time, given)).max() / given[-1]
    assert error <= 0.03
    weight = DENSITY * LENGTH * (LENGTH / 80) ** 2 * PULL
    momentum = history["momentum"] @ normal
    assert np.allclose(
        momentum, history["impulse"] @ normal - weight * history["time"], rtol=0.0, atol=1e-8 * given[-1]
    )


def test_gravity_work_is_weight_times_the_fall_of_the_mass_centre():
    result, normal, _ = bounce("tet4", 0, tc.MasslessContact(removal="full"), 0.9, 1)
    mass = tc.plan(result.scene).bodies[0].mass
    moved = result.position - result.scene.bodies[0].mesh.nodes
    work = np.einsum("nij,j,ni->", mass, -PULL * normal, moved)
    assert result.history["external_work"][-1] == pytest.approx(work, rel=1e-10)
    assert result.history["external_work"][0] == 0.0
