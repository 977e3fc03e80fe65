"""What must not matter: other bodies, the numbering of nodes, units, and where a scene stands in space."""

from dataclasses import replace

import mesh_files
import numpy as np
import pytest
from oracle import meshes
from scenes import block, material, simulate, thrown

import tcontact as tc
from tcontact.mesh.files import content as mesh_file

COLUMNS = ("kinetic", "elastic", "contact_force", "momentum", "external_work", "gap_min")


def renumbered(mesh, seed):
    """Return the mesh with shuffled nodes and cells, and the old number of every new node."""
    generator = np.random.default_rng(seed)
    order = generator.permutation(mesh.node_count)
    place = np.argsort(order)
    cells = place[mesh.cells][generator.permutation(mesh.cell_count)]
    sets = {name: place[faces] for name, faces in mesh.face_sets.items()}
    return tc.Mesh(mesh.nodes[order], cells, mesh.kind, face_sets=sets), order


def scaled(history, name):
    return history[name] / (np.abs(history[name]).max() or 1.0)


def two_blocks():
    """Two different bodies far apart over one floor, and the scenes of each alone."""
    soft, hard = material("neo"), material("linear", young=9e7, density=2000.0)
    first = block("hex8", 3).rotated(((0.0, 0.0, 1.0), 0.4))
    bodies = [
        tc.Body(first, soft, velocity=(0.0, 1.0, -5.0), contact="zmin", name="one"),
        tc.Body(block("tet4", 2, shift=(0.7, 0, 0)), hard, velocity=(0.0, 0.0, -8.0), contact="zmin", name="two"),
    ]
    floor = tc.Plane(point=(0.0, 0.0, -1e-4))
    common = {
        "obstacles": [floor],
        "duration": 2e-3,
        "gravity": (0, 0, -9.81),
        "contact": tc.MasslessContact(removal="full"),
    }
    together = tc.Scene(bodies=bodies, **common)
    return together, [tc.Scene(bodies=[body], **common) for body in bodies]


def within(found, wanted, bound=1e-13):
    """Equal up to the rounding errors of sums in another order."""
    return np.abs(found - wanted).max() <= bound * np.abs(wanted).max()


def test_two_bodies_in_a_scene_are_two_runs():
    together, alone = two_blocks()
    limits = [simulate(scene).dt_limit for scene in alone]
    both = simulate(together)
    assert both.dt_limit == pytest.approx(min(limits), rel=1e-14)
    dt = 0.5 * min(limits)
    both = simulate(together, dt=dt)
    singles = [simulate(scene, dt=dt) for scene in alone]
    assert both.position.shape == (64 + 27, 3)
    for name, single in zip(("one", "two"), singles, strict=True):
        rows, start = both.nodes_of(name), single.scene.bodies[0].mesh.nodes
        assert within(both.position[rows] - start, single.position - start)
        assert within(both.velocity[rows], single.velocity)
        assert within(both.contact_node_force[rows], single.contact_node_force)
        assert np.abs(single.history["contact_force"]).max() > 0.0
    for name in ("kinetic", "elastic", "contact_force", "momentum", "angular_momentum", "contact_nodes"):
        assert within(both.history[name], singles[0].history[name] + singles[1].history[name]), name
    for name, worst, bound in (
        ("gap_min", np.minimum, 1e-13),
        ("static_residual", np.maximum, 1e-6),
        ("sweeps", np.maximum, 0),
    ):
        assert within(both.history[name], worst(*(single.history[name] for single in singles)), bound), name
    with pytest.raises(tc.InputError, match="one"):
        both.nodes_of("three")


def test_the_step_of_a_scene_is_that_of_its_stiffest_body():
    together, alone = two_blocks()
    limits = [simulate(scene).dt_limit for scene in alone]
    assert simulate(together).dt == pytest.approx(0.9 * min(limits), rel=1e-14)
    assert max(limits) > 1.2 * min(limits)


def test_overlapping_bodies_raise_a_named_warning():
    body = tc.Body(block(cells=1), material(), name="a")
    other = tc.Body(block(cells=1, shift=(0.1, 0, 0)), material(), name="b")
    with pytest.warns(tc.OverlapWarning, match=r"a \(.*\) and b \(.*\) overlap"):
        tc.Scene(bodies=[body, other], duration=1.0, contact=None)


@pytest.mark.parametrize(("kind", "removal"), [("hex8", "full"), ("tet4", "normal")])
def test_numbering_does_not_matter_and_results_keep_the_users(kind, removal):
    contact = tc.MasslessContact(removal=removal, tolerance=1e-12)
    scene = thrown("neo", kind, cells=4, contact=contact, duration=1.2)
    body = scene.bodies[0]
    mesh, order = renumbered(body.mesh, 8)
    other = replace(scene, bodies=[replace(body, mesh=mesh)])
    one = simulate(scene, dt=1e-5)
    two = simulate(other, dt=1e-5)
    assert np.abs(two.position - one.position[order]).max() <= 1e-9 * 0.2
    force = np.abs(one.contact_node_force).max()
    assert force > 0.0
    assert np.abs(two.contact_node_force - one.contact_node_force[order]).max() <= 1e-7 * force
    for name in COLUMNS:
        assert np.abs(scaled(two.history, name) - scaled(one.history, name)).max() <= 1e-8, name


def test_results_come_back_in_the_users_order():
    """A body in flight moves every node by the same way from where the user put it."""
    mesh, _ = renumbered(block("tet4", 3), 3)
    velocity = np.array([1.0, 2.0, 3.0])
    result = simulate(tc.Scene(bodies=[tc.Body(mesh, material(), velocity=velocity)], duration=1e-3, contact=None))
    assert np.allclose(result.position, mesh.nodes + result.time * velocity, rtol=0.0, atol=1e-14)
    speeds = np.random.default_rng(1).normal(size=mesh.nodes.shape)
    body = tc.Body(mesh, material("linear"), velocity=speeds)
    result = simulate(tc.Scene(bodies=[body], duration=1e-12, contact=None), dt=1e-12)
    assert np.allclose(result.velocity, speeds, atol=1e-5)


@pytest.mark.parametrize("contact", [tc.MasslessContact(removal="full", tolerance=1e-12), tc.PenaltyContact(3e8)],
                         ids=["massless", "penalty"])  # fmt: skip
def test_units_do_not_matter(contact):
    """A scene in millimetres and tonnes gives the same numbers as in metres and kilograms."""
    length, mass = 1e3, 1e-3
    scene = thrown("neo", "hex8", contact=contact)
    body, plane = scene.bodies[0], scene.obstacles[0]
    mat = body.material
    other = tc.Scene(
        bodies=[
            tc.Body(
                body.mesh.scaled(length),
                tc.NeoHookean(mat.young * mass / length, mat.poisson, mat.density * mass / length**3),
                velocity=np.asarray(body.velocity) * length,
                contact=body.contact,
            )
        ],
        obstacles=[tc.Plane(plane.point * length, plane.normal)],
        duration=scene.duration,
        gravity=np.asarray(scene.gravity) * length,
        contact=contact if isinstance(contact, tc.MasslessContact) else tc.PenaltyContact(3e8 * mass / length**2),
    )
    one, two = simulate(scene), simulate(other)
    assert two.steps == one.steps
    assert two.dt_limit == pytest.approx(one.dt_limit, rel=1e-6)
    dt = one.dt
    one, two = simulate(scene, dt=dt), simulate(other, dt=dt)
    assert np.abs(two.position / length - one.position).max() <= 1e-9 * 0.2
    force = two.history["contact_force"] / (mass * length)
    assert np.abs(force - one.history["contact_force"]).max() <= 1e-8 * np.abs(force).max()
    energy = two.history["energy"] / (mass * length**2)
    assert np.allclose(energy, one.history["energy"], rtol=1e-10)


@pytest.mark.parametrize(("kind", "removal"), [("hex8", "normal"), ("tet4", "full")])
def test_a_turned_and_moved_scene_gives_turned_and_moved_results(kind, removal):
    contact = tc.MasslessContact(removal=removal, tolerance=1e-12)
    scene = thrown("neo", kind, contact=contact)
    turn, shift = meshes.rotation(77), np.array([0.3, -0.2, 0.5])
    body, plane = scene.bodies[0], scene.obstacles[0]
    other = tc.Scene(
        bodies=[replace(body, mesh=body.mesh.rotated(turn).translated(shift), velocity=turn @ body.velocity)],
        obstacles=[tc.Plane(turn @ plane.point + shift, turn @ plane.normal)],
        duration=scene.duration,
        gravity=turn @ scene.gravity,
        contact=contact,
    )
    dt = 0.8 * simulate(replace(scene, duration=1e-6)).dt_limit
    one, two = simulate(scene, dt=dt), simulate(other, dt=dt)
    assert np.abs(one.history["contact_force"]).max() > 0.0
    assert np.abs(two.position - (one.position @ turn.T + shift)).max() <= 1e-9 * 0.2
    force = one.history["contact_force"] @ turn.T
    assert np.abs(two.history["contact_force"] - force).max() <= 1e-7 * np.abs(force).max()
    for name in ("kinetic", "elastic", "gap_min"):
        assert np.abs(scaled(two.history, name) - scaled(one.history, name)).max() <= 1e-8, name


def mixed_file(path):
    """A gmsh file of one hex and one tet apart, each kind a physical volume with a surface of its own."""
    points = [(x, y, z) for z in (0.0, 1.0) for x, y in ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))]
    points += [(3.0, 0.0, 0.0), (4.0, 0.0, 0.0), (3.0, 1.0, 0.0), (3.0, 0.0, 1.0)]
    names = {(2, 1): "under", (2, 2): "tet side", (3, 3): "block", (3, 4): "wedge"}
    blocks = [
        ("quad", 1, [1], [[0, 3, 2, 1]]),
        ("triangle", 2, [1], [[8, 10, 9]]),
        ("triangle", 3, [2], [[8, 9, 11]]),
        ("hex8", 1, [3], [list(range(8))]),
        ("tet4", 2, [4], [[8, 9, 10, 11]]),
    ]
    mesh_files.write_gmsh41(path, np.array(points), range(1, 13), blocks, names, False)
    return path


def test_a_file_with_both_kinds_gives_a_body_of_each(tmp_path):
    file = mixed_file(tmp_path / "both.msh")
    assert [kind for kind, _ in tc.read_mesh(file).blocks] == ["hex8", "tet4"]
    with pytest.warns(mesh_file.MeshWarning, match="left out"):
        hexes, tets = tc.read_mesh(file, kind="hex8"), tc.read_mesh(file, kind="tet4")
    assert (hexes.cell_count, tets.cell_count) == (1, 1)
    assert {*hexes.face_sets} == {"under"}
    assert {*tets.face_sets} == {"under", "tet side"}
    bodies = [
        tc.Body(mesh, material("neo", density=density), contact="under", velocity=(0, 0, -1.0))
        for mesh, density in ((hexes, 1000.0), (tets, 3000.0))
    ]
    scene = tc.Scene(bodies, [tc.Plane(point=(0, 0, -1e-4))], 1e-3, contact=tc.PenaltyContact(1e9))
    result = simulate(scene)
    assert result.position.shape == (12, 3)
    assert result.history["contact_nodes"].max() == 7
