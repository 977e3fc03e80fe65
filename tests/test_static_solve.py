"""The projected static solve of the massless nodes against the oracle's dense active set (METHOD 2, paper 15-17)."""

import numpy as np
import oracle
import pytest
from oracle import meshes
from scenes import block, material, simulate, state_of, thrown, twin, twin_planes, wall

import tcontact as tc


def solved(scene, displacement):
    """Displacement [n, 3] and the contact term after the static solve of the start from that displacement."""
    plan = tc.plan(scene).bodies[0]
    state = state_of(scene, plan, displacement)
    state.begin_contact(1e-6)
    return state.views[0].displacement(), state


def problem(scene):
    """The oracle's static problem of the same scene, points on its planes and the loads [n, 3]."""
    body, model = scene.bodies[0], scene.contact
    there = twin(body)
    quad = oracle.quadrature(there.nodes, there.cells, there.kind)
    planes = twin_planes(scene)
    normals = np.array([plane.unit for plane in planes])
    free = ~np.isfinite(body.prescribed)
    masses = oracle.lumped_cell_mass(quad, there.density)
    touching = np.unique(there.contact_faces)
    spread = oracle.redistribute(there.nodes, there.cells, masses, touching, model.removal, normals, 1, free)
    area = oracle.face_area_weights(there.nodes, there.contact_faces)
    static = oracle.StaticContact(quad, there.law, spread.contact, spread.basis, normals, free, area, model.penalty)
    gravity = np.zeros(3) if scene.gravity is None else np.asarray(scene.gravity)
    return static, np.array([plane.point for plane in planes]), spread.tensor @ gravity


def pressed(mesh, normal, depth, seed=2):
    """A displacement that pushes the body into the wall, with a little noise."""
    noise = np.random.default_rng(seed).uniform(-0.02, 0.02, mesh.nodes.shape)
    height = mesh.nodes @ normal
    share = (height - height.min()) / np.ptp(height)
    return depth * (noise - np.outer(1.0 - 0.6 * share, normal))


CASES = [
    ("hex8", "neo", "full", 1, None),
    ("tet4", "neo", "full", 2, None),
    ("hex8", "svk", "normal", 1, None),
    ("tet4", "linear", "normal", 1, None),
    ("hex8", "linear", "full", 3, None),
    ("tet4", "svk", "full", 1, 40.0),
    ("hex8", "neo", "full", 2, 1e3),
    ("hex8", "linear", "normal", 2, None),
    ("wedge6", "neo", "full", 2, None),
]


@pytest.mark.parametrize(("kind", "law", "removal", "walls", "penalty"), CASES)
def test_same_equilibrium_as_the_oracle(kind, law, removal, walls, penalty):
    turn = meshes.rotation(walls + 3)
    mesh, mat = block(kind, 3, turn=turn), material(law)
    normals = [turn @ n for n in ((0, 0, 1.0), (0.6, 0, 0.8), (0, 0.8, 0.6))][:walls]
    scene = tc.Scene(
        bodies=[tc.Body(mesh, mat, contact=["zmin", "xmin", "ymin"][:walls])],
        obstacles=[wall(mesh, normal, 1e-4) for normal in normals],
        duration=1.0,
        gravity=(30.0, -20.0, 10.0),
        contact=tc.MasslessContact(
            removal=removal, penalty=penalty and penalty * mat.young / 0.06, tolerance=1e-12, sweeps=20
        ),
    )
    start = pressed(mesh, normals[0], 3e-3)
    found, state = solved(scene, start)
    assert state.contact.trouble is None
    static, points, loads = problem(scene)
    wanted, table, _, _ = static.solve(np.array(mesh.nodes), start, points, loads)
    assert (table > 0).any()
    assert np.abs(found - wanted).max() <= 1e-10 * 0.2
    assert np.abs(wanted - start).max() >= 1e-4  # it had work to do


@pytest.mark.parametrize(("kind", "removal", "walls", "law"), [
    ("hex8", "full", 2, "neo"), ("tet4", "normal", 1, "neo"), ("tet4", "full", 1, "svk"), ("hex8", "full", 2, "linear"),
    ("hex8", "normal", 1, "linear"),
])  # fmt: skip
def test_balance_in_mid_contact(kind, removal, walls, law):
    """f_K(x) = lambda nu recomputed from the results alone; lambda >= 0, no overlap; history tells the same."""
    contact = tc.MasslessContact(removal=removal, tolerance=1e-10)
    scene = thrown(law, kind, walls=walls, duration=1.2, speed=0.04, contact=contact, gravity=False)
    result = simulate(scene)
    static, points, _ = problem(scene)
    nodes, moved = scene.bodies[0].mesh.nodes, static.contact
    force, scale = static.force(result.position - nodes)
    load = result.contact_node_force
    off = np.einsum("kic,ki->kc", static.basis, force - load[moved])
    assert np.abs(off).max() <= 1e-8 * scale
    multipliers = np.linalg.lstsq(static.normals.T, load[moved].T, rcond=None)[0]
    assert multipliers.min() >= -1e-12 * scale
    assert (multipliers > 1e-6 * scale).any()
    gap = np.einsum("kpi,pi->kp", result.position[moved][:, None] - points, static.normals)
    assert gap.min() >= -1e-12 * 0.2
    assert gap.min() == pytest.approx(result.history["gap_min"][-1], abs=1e-12 * 0.2)
    pushing = (multipliers > 1e-9 * scale).T
    assert np.abs(gap[pushing]).max() <= 1e-12 * 0.2  # who pushes touches
    assert not np.delete(load, moved, axis=0).any()
    assert np.allclose(load.sum(axis=0), result.history["contact_force"][-1], rtol=1e-12, atol=1e-12 * scale)


@pytest.mark.parametrize("kind", ["hex8", "tet4"])
def test_static_residual_is_the_largest_unbalanced_component_over_the_reference_force(kind):
    """Seen best where it is large: one sweep, loose tolerance. F_ref: largest sum over cells of |f_cell,k|."""
    contact = tc.MasslessContact(removal="full", tolerance=1.0, sweeps=1)
    scene = thrown("neo", kind, duration=0.8, contact=contact, gravity=False)
    result = simulate(scene)
    static, _, _ = problem(scene)
    force, scale = static.force(result.position - scene.bodies[0].mesh.nodes)
    off = np.abs(force - result.contact_node_force[static.contact]).max() / scale
    assert off > 1e-6
    assert result.history["static_residual"][-1] == pytest.approx(off, rel=0.02)


def cold(kind, count, sweeps):
    """Residual after a fixed number of sweeps of a linear body pressed unevenly into the wall."""
    mesh = tc.box_mesh((0.1,) * 3, (count,) * 3, kind)
    scene = tc.Scene(
        bodies=[tc.Body(mesh, material("linear", poisson=0.3), contact="zmin")],
        obstacles=[tc.Plane()],
        duration=1.0,
        contact=tc.MasslessContact(removal="full", sweeps=sweeps, tolerance=1.0),
    )
    start = np.zeros((mesh.node_count, 3))
    x, y, z = (mesh.nodes / 0.1).T
    inner = z > 0.0
    start[inner, 2] = -1e-4 * (1.0 + 0.8 * np.sin(5.0 * x) * np.cos(4.0 * y))[inner]
    start[inner, 0] = 5e-5 * (y * z)[inner]
    _, state = solved(scene, start)
    stats = state.contact.static_solve.stats
    assert int(stats[2]) == sweeps
    return float(stats[1])


@pytest.mark.parametrize(("kind", "sweeps", "sizes"), [
    ("hex8", 25, (8, 16)), ("tet4", 50, (8, 16)),
    pytest.param("hex8", 25, (24, 32), marks=pytest.mark.slow), pytest.param("tet4", 50, (24,), marks=pytest.mark.slow),
])  # fmt: skip
def test_cold_sweeps_do_not_grow_with_the_mesh(kind, sweeps, sizes):
    """K_KK is well conditioned whatever the mesh size, because J is held."""
    assert max(cold(kind, size, sweeps) for size in sizes) <= 1e-8
    assert cold(kind, 8, 3) > 1e-5  # it is the sweeps that do it


def test_sweeps_are_a_minimum_and_go_on_until_the_tolerance():
    scene = thrown(
        "linear", "hex8", duration=0.8, contact=tc.MasslessContact(removal="full", sweeps=2, tolerance=1e-11)
    )
    result = simulate(scene)
    sweeps = result.history["sweeps"]
    assert sweeps.min() >= 2
    assert sweeps.max() > 12
    assert result.history["static_residual"].max() <= 2e-11


def test_a_wall_named_twice_changes_nothing():
    once = thrown("linear", "hex8", duration=0.8, contact=tc.MasslessContact(removal="full"))
    twice = tc.Scene(
        bodies=once.bodies,
        obstacles=once.obstacles * 2,
        duration=once.duration,
        gravity=once.gravity,
        contact=once.contact,
    )
    one, two = simulate(once), simulate(twice)
    assert np.abs(one.position - two.position).max() <= 1e-9


@pytest.mark.parametrize("walls", [1, 2])
def test_more_than_three_walls_act_on_the_nodes_near_them(walls):
    """Only three walls can hold a node at once; those that are far away, listed first, change nothing."""
    scene = thrown("linear", "hex8", walls=walls, duration=0.8, contact=tc.MasslessContact(removal="full"))
    far = [tc.Plane(point=9.0 * n, normal=-n) for n in np.eye(3)]
    more = tc.Scene(
        bodies=scene.bodies,
        obstacles=[*far, *scene.obstacles],
        duration=scene.duration,
        gravity=scene.gravity,
        contact=scene.contact,
    )
    few, many = simulate(scene), simulate(more)
    assert np.abs(few.history["contact_force"]).max() > 0.0
    assert np.abs(few.position - many.position).max() <= 1e-7 * 0.2


def test_a_body_in_equilibrium_makes_no_sweeps():
    """Its residual is exactly 0 from the second step on; the first one has no tangent to rely on."""
    scene = thrown(turn=np.eye(3), speed=0.0, shake=0.0, gravity=False, contact=tc.MasslessContact(removal="full"))
    result = simulate(scene)
    assert result.history["sweeps"].max() > 0.0
    assert not result.history["sweeps"][2:].any()
    assert not result.history["static_residual"].any()
    assert np.array_equal(result.position, scene.bodies[0].mesh.nodes)
