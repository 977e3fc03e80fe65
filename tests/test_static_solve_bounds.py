"""Bounds inside the static solve: what a sweep reports, how far a linearisation moves a node, multipliers that push."""

import numpy as np
import oracle
import pytest
from scenes import block, material, simulate, thrown, wall
from test_local_contact import problems, solve
from test_static_solve import problem, solved

import tcontact as tc


@pytest.mark.parametrize("walls", [1, 2])
def test_the_defect_of_a_sweep_is_the_residual_before_it_with_a_stiff_penalty_too(walls):
    """Four nodes of one face are a little inside a wall whose penalty is far stiffer than the body.

    In plane stress no force acts on the face: before the sweep nothing is out of balance but the penalty. The node that
    the sweep begins with therefore changes its contact force by all of that.
    """
    mesh, law = tc.box_mesh((0.3,) * 3, (3, 3, 3)), material("linear")
    faces = mesh.faces_of("zmin")
    inner = np.abs(mesh.nodes[faces].mean(axis=1) - (0.15, 0.15, 0.0)).max(axis=1) < 1e-9
    mesh = mesh.with_sets(face_sets={"middle": faces[inner]})
    overlap, stiffness = 1e-6, 1e3 * law.young / 0.1
    strain = 1e-2 * np.array([1.0, 1.0, -2.0 * law.poisson / (1.0 - law.poisson)])
    stretched = mesh.nodes * strain - (0.0, 0.0, overlap)
    scene = tc.Scene(
        [tc.Body(mesh, law, contact="middle")],
        [tc.Plane(), tc.Plane((0.0, 0.0, -1.0), (0.3, 0.1, 1.0))][:walls],
        duration=1.0,
        contact=tc.MasslessContact(removal="normal", penalty=stiffness, sweeps=1, tolerance=1.0),
    )
    _, state = solved(scene, stretched)
    stats, names = state.contact.static_solve.stats, state.contact.static_solve.names
    _, reference_force = problem(scene)[0].force(stretched)
    residual = stiffness * 0.05**2 * overlap / reference_force
    assert stats[names.SWEEPS] == 1.0
    assert residual > 0.1
    assert residual * (1.0 - 1e-6) <= stats[names.RESIDUAL] <= 1.5 * residual


def test_a_penalty_on_massless_nodes_stores_what_its_overlap_says():
    """1/2 kappa A g^2 of every node that overlaps, from the positions alone; it is what `energy` lacks without it."""
    stiffness = 10.0 * material().young / 0.06
    contact = tc.MasslessContact(removal="full", penalty=stiffness, tolerance=1e-10)
    scene = thrown("neo", "hex8", duration=0.8, speed=0.04, contact=contact, gravity=False)
    result = simulate(scene)
    body, plane = scene.bodies[0], scene.obstacles[0]
    areas = oracle.face_area_weights(np.array(body.mesh.nodes), np.array(body.contact_faces))
    overlap = np.maximum(-plane.gap(result.position), 0.0)
    stored = 0.5 * stiffness * (areas * overlap**2).sum()
    history = result.history
    assert history["contact"][-1] == pytest.approx(stored, rel=1e-6)
    assert stored > 0.01 * history["energy"][0]
    force = stiffness * (areas * overlap).sum() * plane.normal
    assert history["contact_force"][-1] == pytest.approx(force, rel=1e-6, abs=1e-6 * np.abs(force).max())


def test_a_node_that_is_far_from_equilibrium_goes_back_in_steps_that_its_tangent_is_good_for():
    """An inner contact node nearly at the other end of its cells' diagonals; an unlimited Newton step inverts them."""
    mesh = block("hex8", 3, shake=0.0)
    bottom = mesh.nodes_of("zmin")
    node = bottom[np.argmin(np.linalg.norm(mesh.nodes[bottom] - mesh.nodes[bottom].mean(axis=0), axis=1))]
    moved = np.zeros_like(mesh.nodes)
    moved[node] = 0.95 * 0.06 * np.array([0.6, 0.6, 0.6])
    scene = tc.Scene(
        [tc.Body(mesh, material("neo"), contact="zmin")],
        [wall(mesh, (0.0, 0.0, 1.0), 1e-4)],
        duration=1.0,
        contact=tc.MasslessContact(removal="full", tolerance=1e-9),
    )
    found, state = solved(scene, moved)
    assert state.contact.trouble is None
    assert np.abs(found).max() <= 1e-9 * 0.06


@pytest.mark.parametrize("slots", [2, 3])
def test_walls_that_touch_without_a_force_never_pull(slots):
    """All walls touch, one alone presses: the multipliers of the others are rounding, not less than 0."""
    free, normals, gaps, inverse, compliance = problems(3, slots, 400, 31, False)
    pressing = 10.0 ** np.random.default_rng(4).uniform(-3.0, 6.0, len(free))
    one = np.einsum("kij,kj->ki", inverse, normals[:, 0]) * pressing[:, None]
    gaps = -np.einsum("kpj,kj->kp", normals, free + one)
    found = solve(free, normals, gaps, inverse, compliance)
    assert (found >= 0.0).all()
    assert np.abs(found[:, 0] / pressing - 1.0).max() <= 1e-6
    assert (np.abs(found[:, 1:]) <= 1e-6 * pressing[:, None]).all()
