"""Held and driven components (METHOD 1): kept exactly, whatever touches them; reactions balance the rest."""

import numpy as np
import pytest
from oracle import meshes
from scenes import bar_speed, block, material, simulate, thrown

import tcontact as tc

CONTACTS = [
    tc.MasslessContact(removal="full", tolerance=1e-11),
    tc.MasslessContact(removal="normal", tolerance=1e-11),
    tc.PenaltyContact(5e8),
    tc.ImpulseContact(),
]


@pytest.mark.parametrize("kind", ["hex8", "tet4"])
@pytest.mark.parametrize("contact", CONTACTS, ids=["full", "normal", "penalty", "impulse"])
def test_prescribed_components_move_as_told_and_the_others_are_free(kind, contact):
    """Held y on one side, driven x and z on another; both sides have nodes in the contact set."""
    supports = [tc.Support("ymax", "y"), tc.Support("xmax", "xz", velocity=(0.02, -0.01))]
    scene = thrown("neo", kind, turn=np.eye(3), contact=contact, supports=supports)
    result = simulate(scene, cfl=0.4)
    body = scene.bodies[0]
    moved = result.position - body.mesh.nodes
    fixed = np.isfinite(body.prescribed)
    told = np.where(fixed, body.prescribed, 0.0)
    assert np.abs((moved - told * result.time)[fixed]).max() <= 1e-13
    assert np.array_equal(result.velocity[fixed], body.prescribed[fixed])
    assert np.abs(moved[body.mesh.nodes_of("ymax")][:, [0, 2]]).max() > 1e-4
    assert np.abs(result.history["contact_force"]).max() > 0.0
    tight = isinstance(contact, tc.MasslessContact)
    assert result.history["energy_error"].max() <= (0.01 if tight else 0.2)


def test_the_reaction_of_a_bar_pulled_slowly_is_its_stiffness():
    """One end held, the other drawn out over ten wave passages: the pulls at both ends cancel, the work is stored."""
    mesh, mat = block("hex8", (2, 2, 10), (0.1, 0.1, 1.0), shake=0.0), material("linear", poisson=0.0)
    c = bar_speed(mat)
    speed = 1e-4 * c
    stretch = np.zeros((mesh.node_count, 3))
    stretch[:, 2] = mesh.nodes[:, 2] * speed  # starts with the steady velocity field: no waves
    body = tc.Body(
        mesh, mat, velocity=stretch, supports=[tc.Support("zmin", "z"), tc.Support("zmax", "z", velocity=speed)]
    )
    scene = tc.Scene(bodies=[body], duration=10 / c)
    result = simulate(scene)
    history = result.history
    strain = speed * result.time
    assert history["elastic"][-1] == pytest.approx(mat.young * strain**2 / 2 * 0.01, rel=1e-9)
    assert history["external_work"][-1] == pytest.approx(history["elastic"][-1], rel=1e-9)
    assert np.abs(history["support_force"]).max() <= 1e-9 * mat.young * strain * 0.01  # pull at both ends, opposite


def test_a_held_plate_under_gravity_passes_its_weight_to_the_support():
    """Momentum changes by weight plus reaction; over many periods the mean reaction is the weight."""
    mesh, mat = block("hex8", (3, 3, 4), (0.2, 0.2, 0.3), shake=0.0), material("linear", young=5e6)
    scene = tc.Scene(
        bodies=[tc.Body(mesh, mat, supports=[tc.Support("zmax", "xyz")])],
        duration=40 * 0.3 / mat.wave_speed,
        gravity=(0.0, 0.0, -9.81),
    )
    history = simulate(scene).history
    weight = 9.81 * mat.density * 0.2 * 0.2 * 0.3
    change = history["momentum"] - history["momentum"][0]
    given = history["support_impulse"] + np.outer(history["time"], [0.0, 0.0, -weight])
    assert np.abs(change - given).max() <= 1e-12 * weight * history["time"][-1]
    mean = history["support_impulse"][-1, 2] / history["time"][-1]
    assert mean == pytest.approx(weight, rel=0.1)
    assert history["support_force"][0, 2] == pytest.approx(weight / 8, rel=1e-9)  # at rest only its own row is held
    assert history["energy_error"].max() <= 0.01


def test_a_contact_face_held_along_the_normal_never_moves_into_the_wall():
    """All its nodes leave the contact set; the run goes on as without contact and the gap is still told."""
    mesh, mat = block("hex8", 3), material("neo")
    body = tc.Body(mesh, mat, velocity=(0.0, 0.0, -3.0), contact="zmin", supports=[tc.Support("zmin", "z")])
    wall = tc.Plane(point=(0.0, 0.0, -1e-3))
    span = 0.5 * 0.2 / bar_speed(mat)
    scene = tc.Scene(bodies=[body], obstacles=[wall], duration=span, contact=tc.MasslessContact(removal="normal"))
    free = tc.Scene(bodies=[body], duration=span, contact=None)
    one, two = simulate(scene, dt=1e-5), simulate(free, dt=1e-5)
    assert np.abs(one.position - two.position).max() <= 1e-13
    assert not one.history["contact_force"].any()


@pytest.mark.parametrize(("travel", "warns"), [(2e-3, True), (0.5e-3, False)])
def test_a_support_that_drives_a_contact_face_into_the_wall_is_warned_of(travel, warns):
    """The static solve cannot move it out: the run goes on, and says by how much."""
    mesh, mat = block("hex8", 2, shake=0.0), material("neo")
    span = 0.5 * 0.2 / bar_speed(mat)
    speed = (0.0, 0.0, -travel / span)
    body = tc.Body(mesh, mat, velocity=speed, contact="zmin", supports=[tc.Support("zmin", "z", velocity=speed[2])])
    wall = tc.Plane(point=(0.0, 0.0, -1e-3))
    result = tc.simulate(tc.Scene(bodies=[body], obstacles=[wall], duration=span, contact=tc.MasslessContact("normal")))
    assert result.ok
    said = [text for text in result.warnings if "its support holds it there" in text]
    assert bool(said) is warns
    if warns:
        deepest = -result.history["gap_min"][-1]
        assert deepest == pytest.approx(-speed[2] * result.time - 1e-3, rel=1e-9)
        assert f"{deepest:.3g} m inside" in said[0]


@pytest.mark.parametrize("removal", ["normal", "full"])
def test_a_slanted_wall_pushes_held_nodes_along_what_is_free(removal):
    """Sliding guide: x is held on every node, a wall leaning in x and z can only push along z what x lets it."""
    mesh, mat = block("hex8", 3, shake=0.1), material("neo")
    normal = np.array([0.6, 0.0, 0.8])
    names = {"all": np.arange(mesh.node_count)}
    mesh = mesh.with_sets(node_sets=names)
    body = tc.Body(mesh, mat, velocity=(0.0, 0.0, -4.0), contact=["zmin", "xmin"], supports=[tc.Support("all", "x")])
    low = (mesh.nodes @ normal).min()
    scene = tc.Scene(
        bodies=[body],
        obstacles=[tc.Plane(point=(low - 1e-4) * normal, normal=normal)],
        duration=2 * 0.2 / bar_speed(mat),
        contact=tc.MasslessContact(removal=removal, tolerance=1e-11),
    )
    history = simulate(scene).history
    force = history["contact_force"]
    assert force[:, 2].max() > 0.0
    assert np.allclose(
        force[:, 0], 0.75 * force[:, 2], rtol=1e-12, atol=0.0
    )  # lambda nu itself, along the wall's normal
    assert np.allclose(history["momentum"][:, 0], 0.0, atol=1e-14)
    assert history["gap_min"].min() >= -1e-12
    change = np.diff(history["momentum"] - history["impulse"] - history["support_impulse"], axis=0)
    assert np.abs(change).max() <= 1e-10 * np.abs(history["momentum"]).max()


def test_supports_on_turned_bodies_are_along_the_axes_of_space():
    mesh, mat = block("tet4", 2, turn=meshes.rotation(1)), material("neo")
    body = tc.Body(mesh, mat, velocity=(1.0, 2.0, 3.0), supports=[tc.Support("zmax", "y", velocity=0.5)])
    result = simulate(tc.Scene(bodies=[body], duration=1e-3))
    nodes = mesh.nodes_of("zmax")
    assert np.allclose(result.position[nodes, 1] - mesh.nodes[nodes, 1], 0.5 * result.time, rtol=1e-12)


def test_a_run_from_an_end_state_leaves_that_state_alone():
    """Supports overwrite velocities of the new run, never of the result it starts from."""
    mesh, mat = block("hex8", (2, 2, 2), (0.1, 0.1, 0.1), shake=0.0), material("linear")
    flying = tc.Body(mesh, mat, velocity=(1.0, 2.0, 3.0))
    first = simulate(tc.Scene(bodies=[flying], duration=1e-5, contact=None))
    before = first.velocity.copy()
    held = tc.Body(mesh, mat, supports=[tc.Support("zmin", "xyz")])
    simulate(tc.Scene(bodies=[held], duration=1e-5, contact=None), initial=first)
    assert np.array_equal(first.velocity, before)
