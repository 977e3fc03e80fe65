"""Mass-proportional damping: exact decay, ledger, momentum, settling to rest, and nothing at all when absent."""

import dataclasses

import numpy as np
import pytest
from scenes import bar_speed, block, material, simulate, thrown, wall

import tcontact as tc

LENGTH = 0.2


def damped(scene, rate):
    return dataclasses.replace(scene, damping=tc.MassDamping(rate))


def change(history, impulse):
    """Largest deviation of the momentum from the impulses, over the largest momentum."""
    momentum = history["momentum"] - history["momentum"][0]
    return np.abs(momentum - impulse).max() / np.abs(history["momentum"]).max()


@pytest.mark.parametrize("removal", ["full", "normal"])
def test_a_rigid_body_decays_exponentially_to_second_order(removal):
    """v = v0 exp(-rate t) on ordinary, tensor-mass and massless nodes alike, without strain; the ledger closes."""
    mesh, mat = block("hex8", 3), material("neo")
    velocity, rate = np.array([3.0, -2.0, 1.0]), 40.0
    body = tc.Body(mesh, mat, velocity=velocity, contact="zmin")
    scene = tc.Scene(
        [body], [wall(mesh, (0, 0, 1), 100.0)], 0.02, contact=tc.MasslessContact(removal), damping=tc.MassDamping(rate)
    )
    errors = []
    for dt in (1e-4, 5e-5):
        result = simulate(scene, dt=dt)
        history = result.history
        exact = np.exp(-rate * history["time"])
        planned = tc.plan(scene).bodies[0]
        mass = planned.lumped.sum()
        massive = np.setdiff1d(np.arange(mesh.node_count), planned.node_order[planned.contact.nodes])
        moved = result.position - mesh.nodes
        assert np.ptp(moved, axis=0).max() <= 1e-11 * LENGTH
        assert np.ptp(result.velocity[massive], axis=0).max() <= 1e-9
        assert result.velocity[massive[0]] == pytest.approx(velocity * exact[-1], rel=1e-5)
        assert history["elastic"].max() <= 1e-18 * history["kinetic"][0]
        work = history["kinetic"][0] * (1.0 - exact**2)
        decay = np.abs(history["momentum"] / (mass * velocity) - exact[:, None]).max()
        errors.append([
            decay, history["energy_error"].max(), np.abs(history["damping_work"] - work).max() / work[-1],
            np.abs(moved - velocity / rate * (1.0 - exact[-1])).max(),
        ])  # fmt: skip
        assert change(history, history["damping_impulse"]) <= 1e-12
    coarse, fine = np.array(errors)
    assert (fine <= 1e-5).all()
    assert (coarse >= 3.9 * fine).all()


@pytest.mark.parametrize("contact", [tc.MasslessContact(removal="full", tolerance=1e-13), tc.PenaltyContact(1e9),
                                     tc.ImpulseContact()], ids=["massless", "penalty", "impulse"])  # fmt: skip
def test_momentum_with_supports_and_every_contact_model(contact, parallel_path):
    """Driven supports feel the damping too: change of momentum = all impulses, row by row."""
    supports = [tc.Support("ymax", "y"), tc.Support("xmax", "xz", velocity=0.01)]
    scene = damped(thrown("neo", turn=np.eye(3), contact=contact, supports=supports), 60.0)
    result = simulate(scene)
    history = result.history
    mass = tc.plan(scene).bodies[0].lumped.sum()
    gravity = mass * np.outer(history["time"], scene.gravity)
    given = history["impulse"] + history["support_impulse"] + gravity
    assert change(history, given + history["damping_impulse"]) <= 1e-12
    assert change(history, given) > 1e-3
    assert np.abs(history["contact_force"]).max() > 0.0


@pytest.mark.parametrize(("kind", "contact"), [("hex8", tc.MasslessContact()), ("tet4", tc.PenaltyContact(1e9))])
def test_an_impact_with_damping_keeps_the_ledger(kind, contact):
    """What the ledger misses with damping is no more than without."""
    scene = thrown("neo", kind, walls=1, contact=contact, duration=2.0)
    plain, slowed = (simulate(one, cfl=0.5) for one in (scene, damped(scene, 40.0)))
    assert plain.history["contact_force"].any()
    assert slowed.history["damping_work"][-1] > 0.1 * slowed.history["kinetic"][0]
    assert (np.diff(slowed.history["damping_work"]) >= 0.0).all()
    assert slowed.history["energy_error"].max() <= max(1.5 * plain.history["energy_error"].max(), 1e-3)
    assert slowed.dt_limit == plain.dt_limit
    h = slowed.history
    total = h["kinetic"] + h["elastic"] + h["contact"] + h["damping_work"] - h["external_work"]
    assert h["energy"] == pytest.approx(total, rel=1e-13)


def test_a_block_settles_under_its_weight():
    """Dropped on the wall it ends at rest, carried by exactly its weight; the energy of the ledger stays."""
    mesh, mat = tc.box_mesh((0.1, 0.1, 0.1), (3, 3, 3)), tc.NeoHookean(2e5, 0.3, 1000.0)
    pull = 9.81
    body = tc.Body(mesh, mat, contact="zmin")
    floor = tc.Plane(point=(0.0, 0.0, -1e-4))
    slowest = np.pi / 2 * bar_speed(mat) / 0.1
    scene = tc.Scene([body], [floor], 30.0 / slowest, gravity=(0, 0, -pull), damping=tc.MassDamping(1.5 * slowest))
    result = simulate(scene, cfl=0.3)
    history, weight = result.history, 1000.0 * 0.1**3 * pull
    late = history["time"] > 0.9 * result.time
    assert history["contact_force"][late, 2] == pytest.approx(weight, rel=1e-4)
    assert history["kinetic"][-1] <= 1e-8 * history["kinetic"].max()
    assert history["energy_error"].max() <= 1e-2
    lost = history["external_work"][-1] - history["elastic"][-1]
    assert history["damping_work"][-1] == pytest.approx(lost, rel=1e-2)
    centre = (result.position - mesh.nodes)[:, 2].mean()
    sag = 1000.0 * pull * 0.1**2 / (2.0 * 2e5)
    assert -centre - 1e-4 == pytest.approx(2 / 3 * sag, rel=0.2)


def test_overdamped_motion_stays_stable():
    """rate = 1/dt: central damping is stable at the step of the body without it."""
    scene = thrown("neo", contact=tc.MasslessContact(), duration=2.0, speed=0.1, gap=0.001)
    limit = simulate(dataclasses.replace(scene, duration=1e-6)).dt_limit
    result = simulate(damped(scene, 1.0 / limit), cfl=0.95)
    kinetic = result.history["kinetic"]
    assert kinetic[-1] < 0.01 * kinetic[0]
    assert (result.history["kinetic"] + result.history["elastic"]).max() <= 1.05 * kinetic[0]


def test_absent_it_leaves_nothing_behind():
    """No column, no option of a kernel, no term."""
    scene = thrown(duration=0.1, contact=tc.MasslessContact())
    without, with_it = tc.plan(scene), tc.plan(damped(scene, 1.0))
    assert without.columns == ()
    assert without.bodies[0].options == {}
    assert "damp" not in without.describe()
    assert "mass-damping" in with_it.terms
    assert "damping of the boundary nodes" in with_it.describe()
    assert not {"damping_work", "damping_impulse"} & set(simulate(scene).history)
    assert with_it.columns == ("damping_work", "damping_impulse")


@pytest.mark.parametrize("rate", [0.0, -1.0, float("nan"), "much", None, True])
def test_wrong_rates_are_refused(rate):
    with pytest.raises(tc.InputError, match=r"MassDamping\.rate"):
        tc.MassDamping(rate)


@pytest.mark.parametrize("damping", [0.1, "mass", tc.Plane()])
def test_wrong_damping_is_refused(damping):
    with pytest.raises(tc.InputError, match=r"Scene\.damping"):
        tc.Scene([tc.Body(block(), material())], duration=1.0, damping=damping)
