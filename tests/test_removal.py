"""Which mass the contact nodes lose (METHOD 1, 2): the choice of `auto`, supports, and contact sets nothing holds."""

import numpy as np
import oracle
import pytest
from oracle import meshes
from scenes import block, material, twin, wall

import tcontact as tc


def contact_of(mesh, normals=((0.0, 0.0, 1.0),), contact="zmin", removal="auto", supports=()):
    """The contact plan and the mass tensors of a body over planes far away."""
    scene = tc.Scene(
        bodies=[tc.Body(mesh, material(), contact=contact, supports=supports)],
        obstacles=[wall(mesh, normal, 1.0) for normal in normals],
        duration=1.0,
        contact=tc.MasslessContact(removal=removal),
    )
    planned = tc.plan(scene)
    return planned.bodies[0]


def tilted(degrees, about=(1.0, 0.4, 0.0)):
    """A wall normal that leans by that angle from z."""
    axis = np.asarray(about) / np.linalg.norm(about)
    angle = np.radians(degrees)
    return np.cos(angle) * np.array([0.0, 0.0, 1.0]) + np.sin(angle) * np.cross(axis, (0.0, 0.0, 1.0))


@pytest.mark.parametrize(("degrees", "wanted"), [(0.0, "normal"), (14.9, "normal"), (15.1, "full"), (90.0, "full")])
def test_auto_takes_normal_removal_up_to_15_degrees(degrees, wanted):
    assert contact_of(block("hex8", 3), [tilted(degrees)]).contact.removal == wanted


@pytest.mark.parametrize(
    ("normals", "contact", "wanted"),
    [
        ([(0, 0, 1), (0, 0, -1)], ["zmin", "zmax"], "normal"),  # between two parallel walls
        ([(0, 0, 1), (0, 0, 1.0)], "zmin", "normal"),
        ([(0, 0, 1), (0.05, 0, 1.0)], "zmin", "full"),  # two directions
        ([(0, 0, 1)], ["zmin", "xmin"], "full"),  # a face that looks elsewhere
        ([(0, 0, 1)], ["zmin", "zmax"], "full"),  # a face that looks away
    ],
)
def test_auto_by_walls_and_faces(normals, contact, wanted):
    assert contact_of(block("tet4", 4), normals, contact).contact.removal == wanted


def test_auto_agrees_with_the_oracle_at_random_angles():
    generator = np.random.default_rng(4)
    seen = set()
    for degrees in generator.uniform(2.0, 28.0, 12):
        normal = tilted(degrees, [*generator.normal(size=2), 0.0])
        mesh = block("tet4", 3, shake=0.0)
        there = twin(tc.Body(mesh, material(), contact="zmin"))
        inside = np.broadcast_to(mesh.nodes.mean(axis=0), (len(there.contact_faces), 3))
        wanted = oracle.choose_removal(there.nodes, there.contact_faces, inside, normal)
        assert contact_of(mesh, [normal]).contact.removal == wanted
        seen.add(wanted)
    assert seen == {"normal", "full"}


def test_massless_directions_span_the_normals_of_all_walls():
    """Normal removal: one direction per independent normal; full removal: all three."""
    turn = meshes.rotation(6)
    mesh = block("hex8", 4, turn=turn)
    for count, rank in ((1, 1), (2, 2), (3, 2)):
        normals = [turn @ n for n in ((0.0, 0.0, 1.0), (0.6, 0.0, 0.8), (-0.6, 0.0, 0.8))][:count]
        plan = contact_of(mesh, normals, removal="normal")
        assert plan.contact.block == (1 if rank == 1 else 3)
        for basis in plan.contact.basis:
            gram = basis.T @ basis
            assert np.allclose(gram, np.diag([1.0] * rank + [0.0] * (3 - rank)), atol=1e-14)
            for normal in normals:
                assert np.allclose(basis @ basis.T @ normal, normal, atol=1e-14)
    assert np.allclose(contact_of(mesh, [turn[:, 2]], removal="full").contact.basis, np.eye(3))


def test_supported_components_keep_their_mass():
    """Nodes held along x lose mass along P nu / |P nu| = z under a slanted wall, the others along nu."""
    mesh = block("hex8", 3)
    normal = np.array([0.6, 0.0, 0.8])
    plan = contact_of(mesh, [normal], removal="normal", supports=[tc.Support("xmin", "x")])
    held = np.isin(plan.node_order[plan.contact.nodes], mesh.nodes_of("xmin"))
    assert held.any()
    assert not held.all()
    assert np.allclose(plan.contact.basis[held, :, 0], [0.0, 0.0, 1.0])
    assert np.allclose(plan.contact.basis[~held, :, 0], normal)
    full = contact_of(mesh, [normal], removal="full", supports=[tc.Support("xmin", "x")])
    assert not full.contact.basis[held][:, 0].any()
    lumped = full.lumped[full.contact.nodes]
    tensors = full.tensors[: len(lumped)]
    assert np.allclose(tensors[held, 0, 0], lumped[held])  # stays on the node: mass goes along free components
    assert not tensors[~held].any()
    assert not tensors[held][:, 1:].any()


def test_nodes_that_cannot_move_along_any_normal_leave_the_contact_set():
    mesh = block("hex8", 3)
    held = [tc.Support("xmin", "z")]
    plan = contact_of(mesh, removal="normal", supports=held)
    left = plan.node_order[plan.contact.nodes]
    assert set(left) == set(mesh.nodes_of("zmin")) - set(mesh.nodes_of("xmin"))
    assert len(plan.contact.all_nodes) == len(mesh.nodes_of("zmin"))  # their gap is still watched


def single(kind, nodes, cells, contact):
    return tc.Mesh(np.array(nodes, dtype=float), cells, kind, face_sets={"touch": contact})


TET = single("tet4", [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 1, 2, 3]], [[0, 2, 1]])
HEX = tc.box_mesh((1.0, 1.0, 1.0), (1, 1, 1))


def test_full_removal_needs_three_neighbours_with_mass_that_are_not_in_line():
    """One apex, or two nodes in line, let the contact nodes turn; under normal removal their other mass holds them."""
    for mesh, contact in ((TET, "touch"), (HEX, ["zmin", "xmin"])):
        with pytest.raises(tc.InputError) as caught:
            contact_of(mesh, contact=contact, removal="full")
        assert "three" in caught.value.remedy
        assert "of body-0 around node" in caught.value.remedy
    assert contact_of(TET, contact="touch", removal="normal").contact.removal == "normal"
    assert contact_of(HEX, removal="full").contact.removal == "full"  # four corners of a square hold


def test_a_bar_too_thin_is_refused_with_a_remedy_that_is_not_there_yet():
    """Four corners of a square are not in line, but for the rounding error of a cell 1e6 times as long as wide."""
    contact_of(tc.box_mesh((1e-4, 1e-4, 0.1), (1, 1, 4)), removal="normal")
    bar = tc.box_mesh((1e-8, 1e-8, 0.1), (1, 1, 4))
    for removal in ("normal", "full"):
        with pytest.raises(tc.InputError, match="lower aspect ratio") as caught:
            contact_of(bar, removal=removal)
        assert ("removal='normal'" in caught.value.remedy) == (removal == "full")


def test_a_body_that_is_all_contact_is_refused():
    plate = tc.box_mesh((1.0, 1.0, 0.1), (4, 4, 1))
    for removal in ("normal", "full"):
        with pytest.raises(tc.InputError) as caught:
            contact_of(plate, contact=["zmin", "zmax"], removal=removal)
        assert "finer" in caught.value.remedy
        assert "contact nodes of body-0 around node 0 at (0, 0, 0)" in caught.value.remedy


def test_only_the_cluster_that_nothing_holds_is_refused():
    """Two separate bodies in one mesh, a sound cube and a thin one: the node named lies on the thin one."""
    one, two = tc.box_mesh((1.0,) * 3, (2, 2, 2)), tc.box_mesh((1.0, 1.0, 0.2), (1, 1, 1), origin=(3.0, 0.0, 0.0))
    mesh = tc.Mesh(
        np.vstack([one.nodes, two.nodes]),
        np.vstack([one.cells, two.cells + one.node_count]),
        "hex8",
        face_sets={
            "sound": one.face_sets["zmin"],
            "thin": np.vstack([two.face_sets["zmin"], two.face_sets["xmin"]]) + one.node_count,
        },
    )
    assert len(contact_of(mesh, contact="sound", removal="full").contact.nodes) == 9
    with pytest.raises(tc.InputError) as caught:
        contact_of(mesh, contact=["sound", "thin"], removal="full")
    assert f"of body-0 around node {one.node_count} at (3, 0, 0)" in caught.value.remedy
