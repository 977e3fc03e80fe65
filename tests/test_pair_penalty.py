"""A penalty between bodies on ordinary mass: rows, mirror image, conservation, stable step, files, refusals."""

from dataclasses import replace

import numpy as np
import pytest
from oracle import meshes
from pair_scenes import bar, mirror_images, oblique_cubes, soft, total, touches
from test_multi_body import renumbered
from test_pair_rows import KINDS, facing_of, summed
from test_pair_runs import rings
from test_resume import split

import tcontact as tc
from tcontact.contact.pairs.node_to_surface import BEYOND, couple_nodes
from tcontact.contact.pairs.search import close_faces
from tcontact.contact.pairs.surfaces import facings_of, surfaces_of
from tcontact.device import arrays

MOTION = meshes.rotation(5)
UP = MOTION[:, 2]


def rows_of(facing, positions):
    return couple_nodes(facing, positions, close_faces(facing, positions))


def apart(rows, positions):
    """Return the vectors from the masters to the slaves of all rows, and the normals."""
    return positions[rows.slaves] - summed(rows, positions), rows.normals(positions)


@pytest.mark.parametrize(("kind", "other"), KINDS)
@pytest.mark.parametrize("gap", [0.03, -0.03])
def test_rows_reproduce_linear_fields_at_the_point_where_a_node_meets_the_surface(kind, other, gap):
    facing, positions = facing_of(kind, other, 17.0, (0.3, 0.1), MOTION)
    positions[facing.slave.nodes] += gap * UP
    rows = rows_of(facing, positions)
    assert len(rows.slaves) == 25
    assert np.abs(summed(rows, np.ones(len(positions))) - 1.0).max() <= 1e-13
    vectors, normals = apart(rows, positions)
    assert np.abs(normals - UP).max() <= 1e-12
    assert np.abs(vectors - gap * UP).max() <= 1e-12
    assert abs(rows.area.sum() - 1.0) <= 1e-13


def test_nodes_beside_the_surface_have_no_row_but_for_a_small_share_of_a_face():
    """The slave hangs over an edge of the master, whose faces are .4 long."""
    for beside, expected in ((-0.5 * BEYOND, 25), (0.5 * BEYOND, 25), (1.5 * BEYOND, 20)):
        facing, positions = facing_of("hex8", "hex8", 0.0, (0.5 + 0.4 * beside, 0.0), MOTION)
        for gap in (0.02, -0.02):
            moved = positions.copy()
            moved[facing.slave.nodes] += gap * UP
            rows = rows_of(facing, moved)
            assert len(rows.slaves) == expected
            assert np.abs(apart(rows, moved)[0] - gap * UP).max() <= 1e-12


@pytest.mark.parametrize("kind", ["hex8", "tet4"])
def test_nodes_have_a_row_on_the_closest_face_of_a_bent_or_warped_surface(kind):
    """Between two faces, on the open side of a ridge or inside of a groove, a node projects on neither of them.

    The normal is then the direction from their common side to the node.
    """
    facing, flat = facing_of("hex8", kind, 8.0, (0.0, 0.0), np.eye(3))
    for bend in (0.3, -0.3):
        positions = flat.copy()
        middle = np.array((3.0, -2.0, 1.0))
        across = np.abs(positions[:, 0] - middle[0] - 0.2)  # 0 on a line of nodes of the master
        positions[:, 2] -= bend * across
        for gap in (0.02, -0.02, 0.06, -0.06):
            moved = positions.copy()
            moved[facing.slave.nodes] += gap * np.array((0.0, 0.0, 1.0))
            rows = rows_of(facing, moved)
            assert len(rows.slaves) == 25
            vectors, normals = apart(rows, moved)
            along = vectors - np.einsum("ri,ri->r", vectors, normals)[:, None] * normals
            assert np.abs(along).max() <= 1e-5 * abs(gap)
            assert (np.sign(np.einsum("ri,ri->r", vectors, normals)) == np.sign(gap)).mean() > 0.7
    positions = flat + 0.03 * np.random.default_rng(0).normal(size=flat.shape)
    rows = rows_of(facing, positions)
    vectors, normals = apart(rows, positions)
    along = vectors - np.einsum("ri,ri->r", vectors, normals)[:, None] * normals
    assert len(rows.slaves) > 15
    assert np.median(np.abs(along)) <= 1e-12  # but for nodes between two faces


def test_a_node_beside_the_edge_of_a_tilted_master_has_no_row_behind_the_other_face_of_the_edge():
    """A cube stands on its edge over a flat surface: rows only at the nodes below the edge, all of them open."""
    turned = tc.box_mesh((1, 1, 1), (4, 4, 4), origin=(-0.5, -0.5, -0.5)).rotated(((1, 0, 0), np.pi / 4))
    turned = turned.translated((0.0, 0.0, 0.002 - turned.nodes[:, 2].min()))
    flat = tc.box_mesh((2, 2, 1), (8, 8, 2), origin=(-1.0, -1.0, -1.0))
    bodies = [
        tc.Body(turned, soft(), contact=("ymin", "zmin"), name="up"),
        tc.Body(flat, soft(), contact="zmax", name="low"),
    ]
    pairs = [tc.Pair("up", "low", slave="low")]
    domain = tc.plan(tc.Scene(bodies, duration=1.0, contact=tc.PenaltyContact(1.0), pairs=pairs)).domains[0]
    (facing,) = facings_of(domain, surfaces_of(domain))
    rows = rows_of(facing, domain.reference)
    vectors, normals = apart(rows, domain.reference)
    assert (domain.reference[rows.slaves, 1] == 0.0).all()
    assert len(rows.slaves) == 5
    np.testing.assert_allclose(vectors, [[0.0, 0.0, -0.002]] * 5, atol=1e-12)
    np.testing.assert_allclose(normals, [[0.0, 0.0, -1.0]] * 5, atol=1e-9)


def test_a_body_against_its_mirror_image_is_a_body_against_a_plane_of_twice_the_stiffness():
    """Both go half the overlap beyond the plane of symmetry; the master's faces bend, and their normals with them."""
    one, other = mirror_images()
    scheme, stiffness = tc.CentralDifference(dt=0.05), 8.0
    alone = tc.simulate(tc.Scene([one], [tc.Plane()], 3.0, contact=tc.PenaltyContact(2.0 * stiffness)), scheme)
    both = tc.simulate(tc.Scene([one, other], duration=3.0, contact=tc.PenaltyContact(stiffness)), scheme)
    assert both.scene.body_pairs
    force, stored = alone.history["contact_force"][:, 2], alone.history["contact"]
    assert np.abs(both.pair_force["up-low"][:, 2] - force).max() <= 1e-4 * force.max()
    assert np.abs(both.history["contact"] - 2.0 * stored).max() <= 1e-4 * stored.max()
    assert stored.max() > 0.0


def cubes(**options):
    return oblique_cubes(contact=tc.PenaltyContact(5.0), **options)


def test_oblique_cubes_keep_energy_and_momentum():
    """The rows are renewed only when a slave has slipped: angular momentum is kept as far as with massless nodes."""
    result = tc.simulate(cubes(), tc.CentralDifference(cfl=0.5))
    assert result.ok
    assert np.abs(result.history["energy_error"]).max() <= 1e-2
    assert result.history["contact"].max() >= 0.01 * result.history["kinetic"][0]
    assert total(result, "momentum") <= 1e-13
    assert total(result, "angular_momentum") <= 5e-3
    assert touches(result.pair_force["up-low"][:, 2]) == 1
    force = result.contact_node_force
    count = result.scene.bodies[0].mesh.node_count
    assert np.abs(force[:count].sum(axis=0) - result.pair_force["up-low"][-1]).max() <= 1e-15
    columns = {name: result.history[f"{name}:up-low"] for name in ("pair_gap_min", "pair_rows", "pair_pressed")}
    assert columns["pair_gap_min"].min() < 0.0
    assert ((columns["pair_pressed"] > 0) == (columns["pair_gap_min"] < 0.0)).all()
    assert columns["pair_rows"].max() <= 36


def test_a_run_turned_and_shifted_is_the_same_run():
    turn, offset = meshes.rotation(12), np.array((40.0, -7.0, 3.0))
    scheme = tc.CentralDifference(dt=0.08)
    one, other = (tc.simulate(cubes(motion=motion), scheme) for motion in (None, (turn, offset)))
    assert np.abs(one.position @ turn.T + offset - other.position).max() <= 1e-10


def test_three_bars_in_a_row_pass_the_speed_on():
    """The bar in the middle is slave of one neighbour and master of the other: each row presses its own masters."""
    bodies = [bar(12, 1, 2.004, -0.02, "a"), bar(18, 2, 1.002, 0.0, "b"), bar(15, 1, 0.0, 0.0, "c")]
    pairs = [tc.Pair("a", "b", slave="a"), tc.Pair("b", "c", slave="b")]
    scene = tc.Scene(bodies, duration=5.2, pairs=pairs, contact=tc.PenaltyContact(10.0))
    result = tc.simulate(scene)
    ends = np.cumsum([body.mesh.node_count for body in bodies])
    speeds = [part[:, 2].mean() / -0.02 for part in np.split(result.velocity, ends[:-1])]
    assert np.abs(np.array(speeds) - (0.0, 0.0, 1.0)).max() <= 0.04
    assert np.abs(result.history["energy_error"]).max() <= 2e-2
    assert total(result, "momentum") <= 1e-12


def test_a_run_goes_on_from_one_that_ended_pressed():
    """Bodies overlap there by what the penalty gives way."""
    first = tc.simulate(cubes(duration=1.0), tc.CentralDifference(dt=0.05))
    assert first.history["pair_pressed:up-low"][-1] > 0
    result = tc.simulate(cubes(duration=2.0), tc.CentralDifference(dt=0.05), initial=first)
    whole = tc.simulate(cubes(duration=3.0), tc.CentralDifference(dt=0.05))
    assert result.ok
    assert np.abs(result.velocity - whole.velocity).max() <= 0.05 * np.abs(whole.velocity).max()


def test_facets_of_fitting_rings_count_as_closed_or_are_refused():
    """The nodes of the inner ring stand behind the flat faces of the outer one."""
    penalty = tc.PenaltyContact(20.0)
    with pytest.raises(tc.InputError, match="initial_gap='closed'"):
        tc.simulate(replace(rings("as-meshed"), contact=penalty))
    result = tc.simulate(replace(rings("closed"), contact=penalty))
    assert np.abs(result.pair_force["inner-outer"][0]).max() <= 1e-12
    assert result.history["pair_pressed:inner-outer"].max() > 0
    assert np.abs(result.history["energy_error"]).max() <= 1e-2


@pytest.mark.parametrize("path", ["serial", "parallel"])
def test_a_resumed_run_has_the_same_bits(tmp_path, monkeypatch, path, request):
    if path == "parallel":
        request.getfixturevalue("parallel_path")
    whole = split(monkeypatch, tmp_path, cubes(), 4, tc.CentralDifference(), 3)
    assert whole.history["pair_pressed:up-low"].max() > 0
    assert whole.history["pair_rebuilds"][-1] > 2


def test_many_rows_a_launch_and_one_row_a_launch_are_the_same_run(request):
    scheme = tc.CentralDifference(dt=0.08)
    one = tc.simulate(cubes(), scheme)
    request.getfixturevalue("parallel_path")
    other = tc.simulate(cubes(), scheme)
    assert np.abs(one.position - other.position).max() <= 1e-13


def largest_frequency(scene, rows):
    """Return the exact stable step of two bodies without contact and with all rows closed."""
    from tcontact.cells.internal_force import InternalForce

    domain = tc.plan(scene).domains[0]
    force, mass = InternalForce(domain).without_boundary(), np.repeat(domain.lumped, 3)
    stiffness = np.zeros((len(mass), len(mass)))
    for column in range(len(mass)):
        u, found = np.zeros(len(mass)), arrays.zeros(len(mass))
        u[column] = 1e-6
        force.minus_force(arrays.put(u), found)
        stiffness[:, column] = -1e6 * mass * arrays.get(found)
    areas = np.zeros(len(domain.reference))
    areas[domain.contact.nodes] = domain.contact.areas
    _, normals = apart(rows, domain.reference)
    for row, (slave, normal) in enumerate(zip(rows.slaves, normals, strict=True)):
        way = np.zeros((len(areas), 3))
        way[slave] = normal
        part = slice(rows.first[row], rows.first[row + 1])
        way[rows.masters[part]] -= rows.weights[part, None] * normal
        stiffness += scene.contact.stiffness * areas[slave] * np.outer(way, way)
    scale = np.sqrt(mass)
    return 2.0 / np.sqrt(np.linalg.eigvalsh(stiffness / scale / scale[:, None])[-1])


LIES = ((2, 2, 0.0, (0.0, 0.0), None), (2, 3, 0.5, (0.2, 0.3), None), (2, 3, 0.0, (0.45, 0.4), "up"))


@pytest.mark.parametrize(("upper", "lower", "turn", "shift", "slave"), [*LIES, (3, 2, 0.2, (0.4, 0.1), "low")])
def test_the_stable_step_is_safe_for_closed_rows_whichever_is_slave(upper, lower, turn, shift, slave):
    scene = oblique_cubes(upper, lower, law=tc.LinearElastic, contact=tc.PenaltyContact(30.0), duration=1e-3)
    above = tc.box_mesh((1, 1, 1), (upper,) * 3).rotated(((0, 0, 1), turn), about=(0.5, 0.5, 0.5))
    up = replace(scene.bodies[0], mesh=above.translated((*shift, 0.0)), velocity=(0, 0, 0))
    scene = replace(scene, bodies=[up, scene.bodies[1]], pairs=[tc.Pair("up", "low", slave=slave)])
    limit = tc.simulate(scene).dt_limit
    domain = tc.plan(scene).domains[0]
    (facing,) = facings_of(domain, surfaces_of(domain))
    rows = rows_of(facing, domain.reference)
    assert len(rows.slaves) >= 2
    exact = largest_frequency(scene, rows)
    assert 0.3 * exact <= limit <= exact


def test_what_a_penalty_between_bodies_cannot_be_is_refused_or_stops_by_name(tmp_path):
    scene = cubes()
    assert scene.body_pairs
    impulses = replace(scene, contact=tc.ImpulseContact())
    assert impulses.body_pairs == ()
    pairs = [tc.Pair("up", "low")]
    low = scene.bodies[1]
    into = replace(scene, bodies=[scene.bodies[0], replace(low, mesh=low.mesh.translated((0, 0, 0.05)))])
    with pytest.raises(tc.InputError, match=r"low.*0\.048 m inside up near"):
        tc.simulate(into, out=tmp_path / "run")
    assert not (tmp_path / "run").exists()
    with pytest.raises(tc.InputError, match="no contact between bodies"):
        tc.simulate(replace(scene, pairs=pairs), tc.Midpoint(dt=1e-2))


def test_a_scene_file_keeps_a_penalty_with_pairs(tmp_path):
    tc.save_scene(cubes(pairs=[tc.Pair("up", "low", slave="up")]), tmp_path / "scene.toml")
    scene, _ = tc.load_scene(tmp_path / "scene.toml")
    assert scene.contact == tc.PenaltyContact(5.0)
    assert scene.body_pairs[0].slave == 0
    assert "penalty load" in tc.plan(scene).describe()


def test_nodes_on_edges_of_the_master_have_rows_that_do_not_depend_on_the_frame():
    """Faces that share an edge are equally close to a node on it: rounding errors must not decide between them."""

    def forces(turn):
        """Return the force between two cubes whose nodes lie on each other, in the unturned frame."""
        below = tc.box_mesh((0.5, 0.5, 0.5), (4, 4, 4), origin=(0, 0, -0.5)).rotated(turn)
        above = tc.box_mesh((0.5, 0.5, 0.5), (2, 2, 2), origin=(0, 0, 0.01)).rotated(turn)
        bodies = [
            tc.Body(above, soft(), turn @ (0.0, 0.0, -0.05), contact="zmin", name="up"),
            tc.Body(below, soft(), contact="zmax", name="low"),
        ]
        pair = tc.Pair("up", "low", slave="up")
        scene = tc.Scene(bodies, duration=1.0, contact=tc.PenaltyContact(3.0), pairs=[pair])
        return tc.simulate(scene, tc.CentralDifference(dt=0.01)).pair_force["up-low"] @ turn

    known = forces(np.eye(3))
    assert np.abs(known).max() > 0.0
    for seed in (1, 2, 3):
        assert np.abs(forces(meshes.rotation(seed)) - known).max() <= 1e-12 * np.abs(known).max()


def fitting_blocks(kind, lower=lambda mesh: mesh):
    """Return a run of a block that falls on one with faces twice as large: its nodes lie on their edges and corners."""
    up = tc.box_mesh((1.0, 1.0, 1.0), (4, 4, 2), kind, origin=(-0.5, -0.5, 1e-4))
    low = tc.box_mesh((2.0, 2.0, 0.6), (4, 4, 2), kind, origin=(-1.0, -1.0, -0.6))
    bodies = [
        tc.Body(up, soft(), (0.0, 0.0, -0.06), contact="zmin", name="up"),
        tc.Body(lower(low), soft(), contact="zmax", name="low"),
    ]
    pairs = [tc.Pair("up", "low", slave="up")]
    return tc.simulate(
        tc.Scene(bodies, duration=3.0, contact=tc.PenaltyContact(10.0), pairs=pairs), tc.CentralDifference(dt=0.05)
    )


def test_a_symmetric_impact_stays_symmetric_where_nodes_lie_on_edges_of_the_master():
    result = fitting_blocks("hex8")
    start, force = result.scene.bodies[0].mesh.nodes, result.pair_force["up-low"]
    end = result.position[: len(start)]
    mirrored = np.array([np.abs(start * (-1.0, 1.0, 1.0) - node).max(axis=1).argmin() for node in start])
    assert np.abs(force[:, :2]).max() <= 1e-9 * np.abs(force[:, 2]).max()
    assert np.abs(end[mirrored] * (-1.0, 1.0, 1.0) - end).max() <= 1e-9 * np.abs(end - start).max()
    assert np.abs(result.history["energy_error"]).max() <= 2e-2
    assert total(result, "momentum") <= 1e-13


@pytest.mark.parametrize("kind", ["hex8", "tet4"])
def test_another_numbering_of_the_master_is_the_same_run(kind):
    """Several faces are equally close to nodes on edges and corners of the master."""

    def shuffled(mesh, seed):
        mesh = renumbered(mesh, seed)[0]
        order = np.random.default_rng(seed).permutation(len(mesh.face_sets["zmax"]))
        return tc.Mesh(mesh.nodes, mesh.cells, kind, face_sets={"zmax": mesh.face_sets["zmax"][order]})

    known = fitting_blocks(kind).pair_force["up-low"]
    for seed in (1, 2):
        other = fitting_blocks(kind, lambda mesh, seed=seed: shuffled(mesh, seed)).pair_force["up-low"]
        assert np.abs(other - known).max() <= 1e-9 * np.abs(known).max()
