"""Invariants of the explicit step: rigid motion, free fall, momenta (METHOD 1, 2)."""

import numpy as np
import oracle
import pytest
from oracle import meshes
from scenes import LAWS, bar_speed, block, material, simulate, thrown, twin, wall

import tcontact as tc

KINDS = ["hex8", "tet4"]
pytestmark = pytest.mark.usefixtures("parallel_path")  # every law and element; both paths: test_periodic.py


def free(body, duration, contact=None, normal=(0.0, 0.0, 1.0), gravity=None, **options):
    """Run a body with a wall far away (or none)."""
    planes = [] if contact is None else [wall(body.mesh, normal, 100.0)]
    return simulate(
        tc.Scene(bodies=[body], obstacles=planes, duration=duration, gravity=gravity, contact=contact), **options
    )


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("law", LAWS)
def test_a_translation_strains_nothing(kind, law):
    mesh, mat = block(kind, 3, turn=meshes.rotation(5)), material(law)
    c = bar_speed(mat)
    velocity = c * np.array([0.3, -0.2, 0.1])
    result = free(tc.Body(mesh, mat, velocity=velocity), 5 * 0.2 / c)
    moved = result.position - mesh.nodes
    assert np.abs(moved - result.time * velocity).max() <= 1e-12 * 0.2 * 10
    assert np.ptp(moved, axis=0).max() <= 1e-12 * 0.2
    assert np.abs(result.history["elastic"]).max() <= 1e-24 * mat.young * 0.2**3


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("law", ["neo", "svk"])
def test_a_rotation_gives_no_force(kind, law):
    """One step from the turned mesh at rest: the velocity it gains is force over mass."""
    mesh, mat = block(kind, 3), material(law)
    body = tc.Body(mesh, mat)
    start = free(body, 1e-9, dt=1e-9)
    turned = (mesh.nodes - mesh.nodes.mean(axis=0)) @ meshes.rotation(9).T
    object.__setattr__(start, "position", turned)
    object.__setattr__(start, "velocity", np.zeros_like(turned))
    dt = 0.5 * start.dt_limit
    result = simulate(tc.Scene(bodies=[body], duration=dt), dt=dt, initial=start)
    lumped = tc.plan(tc.Scene(bodies=[body], duration=dt)).bodies[0].lumped
    force = np.abs(result.velocity).max() / dt * lumped.min()
    assert force <= 1e-12 * mat.young * 0.2**2
    assert np.abs(result.history["elastic"]).max() <= 1e-24 * mat.young * 0.2**3 + 1e-14 * 2.3e7 * 0.2**3


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    ("removal", "law"), [("full", "linear"), ("normal", "neo"), ("normal", "linear"), ("full", "svk")]
)
def test_free_fall_strains_nothing(kind, removal, law):
    """Gravity acts through the redistributed mass; the massless nodes fall with the rest."""
    turn = meshes.rotation(5)
    mesh, mat = block(kind, 3, turn=turn), material(law)
    body = tc.Body(mesh, mat, contact="zmin", velocity=(0.1, 0.0, 0.0))
    pull = np.array([3.0, -7.0, 2.0])
    contact = tc.MasslessContact(removal=removal)
    result = free(body, 30 * 0.2 / bar_speed(mat), contact, turn[:, 2], pull)
    moved = result.position - mesh.nodes
    assert np.ptp(moved, axis=0).max() <= 1e-12 * 0.2
    time = result.time
    assert np.allclose(moved.mean(axis=0), [0.1 * time, 0, 0] + pull * time**2 / 2, rtol=1e-10)
    assert result.history["energy_error"].max() <= 1e-9


def momentum_defect(scene):
    """Largest change of momentum in a step that no impulse explains, over the largest momentum."""
    result = simulate(scene)
    history = result.history
    mass = scene.bodies[0].mesh.cell_volumes().sum() * scene.bodies[0].material.density
    given = history["impulse"] + history["support_impulse"] + mass * np.outer(history["time"], scene.gravity)
    assert np.abs(history["contact_force"]).max() > 0.0
    return np.abs(np.diff(history["momentum"] - given, axis=0)).max() / np.abs(history["momentum"]).max(), result


@pytest.mark.parametrize(("kind", "law", "walls", "removal"), [
    ("hex8", "neo", 2, "full"), ("tet4", "neo", 1, "normal"), ("tet4", "linear", 1, "full"), ("hex8", "svk", 1, "auto"),
])  # fmt: skip
def test_momentum_changes_by_the_impulses_in_every_step(kind, law, walls, removal):
    for tolerance, bound in ((1e-13, 1e-12), (None, 1e-8)):
        contact = tc.MasslessContact(removal=removal, tolerance=tolerance)
        defect, _ = momentum_defect(thrown(law, kind, walls=walls, contact=contact))
        assert defect <= bound


@pytest.mark.parametrize("contact", [tc.MasslessContact(removal="full", tolerance=1e-13), tc.PenaltyContact(1e9),
                                     tc.ImpulseContact()], ids=["massless", "penalty", "impulse"])  # fmt: skip
def test_momentum_with_supports_and_every_contact_model(contact):
    """Held and driven components push with support_force; its running integral is support_impulse."""
    supports = [tc.Support("ymax", "y"), tc.Support("xmax", "xz", velocity=0.01)]
    scene = thrown("neo", "hex8", turn=np.eye(3), contact=contact, supports=supports)
    defect, result = momentum_defect(scene)
    assert defect <= 1e-12
    history = result.history
    for force, impulse in (("contact_force", "impulse"), ("support_force", "support_impulse")):
        half = (history[force][1:] + history[force][:-1]) / 2 * np.diff(history["time"])[:, None]
        assert np.allclose(history[impulse][1:], np.cumsum(half, axis=0), rtol=1e-12, atol=1e-12 * np.abs(half).sum())
    assert np.abs(history["support_force"]).max() > 0.0


def spinning(kind, law, removal, cells, turns):
    """Drift of the angular momentum of a spinning body that flies past a wall."""
    turn = meshes.rotation(8)
    mesh, mat = block(kind, cells, (0.15,) * 3, turn=turn, shift=(0.05, 0.15, 0.0), shake=0.0), material(law)
    c = bar_speed(mat)
    spin = 0.12 * c / 0.15 * turn[:, 1]
    velocity = np.cross(spin, mesh.nodes - mesh.nodes.mean(axis=0)) + 0.02 * c
    body = tc.Body(mesh, mat, velocity=velocity, contact="zmin")
    contact = tc.MasslessContact(removal=removal, tolerance=1e-13)
    result = free(body, turns * 2 * np.pi / np.linalg.norm(spin), contact, turn[:, 2], cfl=0.8)
    spun = result.history["angular_momentum"]
    return np.abs(spun - spun[0]).max() / np.abs(spun).max()


@pytest.mark.parametrize(("kind", "law"), [("hex8", "neo"), ("tet4", "svk")])
def test_full_removal_keeps_the_angular_momentum_of_free_flight(kind, law):
    assert spinning(kind, law, "full", 3, 0.5) <= 1e-11


def test_normal_removal_loses_angular_momentum_like_the_square_of_the_cell_size():
    """Its mass tensors do not turn with the body: a fault of O(h^2), at least three times less at half the size."""
    coarse, fine = (spinning("hex8", "neo", "normal", cells, 0.5) for cells in (3, 6))
    assert 1e-3 < coarse < 0.3
    assert coarse >= 3.0 * fine


def test_the_ledger_is_what_its_columns_say():
    """energy = kinetic + elastic + contact + friction_work - external_work; error over max of kinetic + elastic; row 0
    and the elastic energy recomputed."""
    supports = [tc.Support("xmax", "x", velocity=-0.05)]
    penalty = tc.MasslessContact(removal="full", penalty=1e10)
    scene = thrown("neo", "tet4", turn=np.eye(3), contact=penalty, supports=supports)
    result = simulate(scene)
    h = result.history
    total = h["kinetic"] + h["elastic"] + h["contact"] + h["friction_work"] - h["external_work"]
    assert np.allclose(h["energy"], total, rtol=1e-13)
    error = np.abs(total - total[0]) / (h["kinetic"] + h["elastic"]).max()
    assert np.allclose(h["energy_error"], error, rtol=1e-9, atol=1e-14)
    assert h["contact"].max() > 0.0
    assert np.abs(h["external_work"]).max() > 1e-3 * h["kinetic"].max()
    assert h["time"][0] == h["external_work"][0] == h["energy_error"][0] == 0.0
    there = twin(scene.bodies[0])
    quad = oracle.quadrature(there.nodes, there.cells, there.kind)
    elastic = oracle.energy(quad, there.law, result.position - there.nodes)
    assert h["elastic"][-1] == pytest.approx(elastic, rel=1e-11)
