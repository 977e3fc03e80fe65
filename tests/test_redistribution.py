"""Mass redistribution (METHOD 1, paper 4.2): nothing is lost, contact nodes have none, the others only gain."""

import numpy as np
import oracle
import pytest
from oracle import meshes
from scenes import block, material, twin, twin_planes, wall

import tcontact as tc

CASES = [
    ("hex8", "full", 1),
    ("hex8", "normal", 1),
    ("tet4", "full", 1),
    ("tet4", "normal", 1),
    ("hex8", "normal", 2),
    ("tet4", "full", 3),
]


def scene_of(mesh, contact="zmin", removal="full", depth=1, normals=((0.0, 0.0, 1.0),), turn=None, **body):
    turn = np.eye(3) if turn is None else turn
    return tc.Scene(
        bodies=[tc.Body(mesh, material(), contact=contact, **body)],
        obstacles=[wall(mesh, turn @ normal, 1.0) for normal in normals],
        duration=1.0,
        gravity=(1.0, -2.0, 3.0),
        contact=tc.MasslessContact(removal=removal, depth=depth),
    )


def masses(scene):
    """Mass tensors [n, 3, 3] after redistribution and ordinary lumped masses [n]."""
    body = tc.plan(scene).bodies[0]
    lumped = np.empty(len(body.lumped))
    lumped[body.node_order] = body.lumped
    return body.mass, lumped


@pytest.mark.parametrize(("kind", "removal", "depth"), CASES)
def test_total_mass_stays_and_every_other_node_only_gains(kind, removal, depth):
    turn = meshes.rotation(depth)
    mesh = block(kind, 4, turn=turn)
    tensors, lumped = masses(scene_of(mesh, removal=removal, depth=depth, turn=turn))
    total = material().density * mesh.cell_volumes().sum()
    assert np.abs(tensors.sum(axis=0) - total * np.eye(3)).max() <= 1e-12 * total
    inner = np.setdiff1d(np.arange(mesh.node_count), mesh.nodes_of("zmin"))
    gain = np.linalg.eigvalsh(tensors[inner] - lumped[inner, None, None] * np.eye(3))
    assert gain.min() >= -1e-14 * lumped.max()
    assert (gain.max(axis=1) > 1e-9 * lumped.max()).sum() >= 25 * depth  # every layer behind the face receives


@pytest.mark.parametrize("kind", ["hex8", "tet4"])
def test_removed_components_are_exactly_zero(kind):
    mesh = block(kind, 3)
    tensors, lumped = masses(scene_of(mesh, removal="full"))
    nodes = mesh.nodes_of("zmin")
    assert not tensors[nodes].any()
    tensors, _ = masses(scene_of(mesh, removal="normal"))
    assert not tensors[nodes][:, 2].any()
    assert not tensors[nodes][:, :, 2].any()
    assert np.allclose(tensors[nodes][:, 0, 0], lumped[nodes], rtol=1e-14)
    turn = meshes.rotation(9)
    tensors, lumped = masses(scene_of(block(kind, 3, turn=turn), removal="normal", turn=turn))
    assert np.abs(tensors[nodes] @ turn[:, 2]).max() <= 1e-15 * lumped.max()


@pytest.mark.parametrize("removal", ["normal", "full"])
def test_centre_of_mass_of_a_cube_moves_by_half_a_cell_squared_over_its_length(removal):
    """h^2 / (2 L) = 7.8125e-3 L for 8 cells."""
    mesh = tc.box_mesh((0.37,) * 3, (8, 8, 8), origin=(1.0, 2.0, -0.3))
    tensors, _ = masses(scene_of(mesh, removal=removal))
    weight = tensors[:, 2, 2]
    shift = weight @ mesh.nodes / weight.sum() - mesh.nodes.mean(axis=0)
    assert np.abs(shift - [0.0, 0.0, 7.8125e-3 * 0.37]).max() <= 1e-9 * 0.37


def test_whole_skin_loses_the_inertia_that_method_names():
    """50 % on 4^3 and 16 % on 8^3 hexes: why the contact set is only what can touch."""
    for cells, low, high in ((4, 0.45, 0.55), (8, 0.13, 0.20)):
        mesh = tc.box_mesh((1.0,) * 3, (cells,) * 3, origin=(-0.5,) * 3)
        skin = ["xmin", "xmax", "ymin", "ymax", "zmin", "zmax"]
        tensors, lumped = masses(scene_of(mesh, contact=skin))
        square = np.sum(mesh.nodes**2, axis=1)
        loss = 1.0 - tensors[:, 0, 0] @ square / (lumped @ square)
        assert low < loss < high


def test_weights_of_one_cell_are_inverse_distances():
    size = np.array([1.0, 2.0, 3.0])
    mesh = tc.box_mesh(size, (1, 1, 1))
    tensors, lumped = masses(scene_of(mesh, removal="full"))
    reach = [3.0, np.hypot(1, 3), np.hypot(2, 3), np.sqrt(14)]  # above, along x, along y, across
    weight = 1.0 / np.array(reach)
    weight /= weight.sum()
    assert weight.sum() == pytest.approx(1.0)
    assert np.allclose(tensors[4:], 2.0 * lumped[0] * np.eye(3), rtol=1e-14)  # by symmetry each doubles
    mesh = block("hex8", (1, 1, 1), shake=0.0).with_sets(node_sets={"corner": [0]})
    with pytest.raises(tc.InputError):
        scene_of(mesh, contact="corner")  # a node is no face
    nodes = np.array(tc.box_mesh(size, (1, 1, 1)).nodes)
    nodes[0, 2] -= 0.5  # now the four corners of the face hand on different amounts
    mesh = tc.Mesh(nodes, tc.box_mesh(size, (1, 1, 1)).cells, "hex8", face_sets={"zmin": [[0, 2, 3, 1]]})
    tensors, lumped = masses(scene_of(mesh, removal="full"))
    wanted = lumped[4:].copy()
    for giver in range(4):
        near = 1.0 / np.linalg.norm(nodes[4:] - nodes[giver], axis=1)
        wanted += lumped[giver] * near / near.sum()
    assert np.allclose(tensors[4:, 1, 1], wanted, rtol=1e-13)


def test_weights_inside_every_layer_are_inverse_distances():
    """A bent and tapered column of three cells: each of the four donors hands a third of its mass to every layer."""
    box = tc.box_mesh((0.2, 0.3, 0.4), (1, 1, 3))
    x, y, z = box.nodes.T
    mesh = tc.Mesh(np.stack([x + z**2, y * (1.0 + z), z], axis=1), box.cells, "hex8", face_sets=box.face_sets)
    tensors, lumped = masses(scene_of(mesh, removal="full", depth=3))
    level = np.rint(z / (0.4 / 3)).astype(int)
    for number in (1, 2, 3):
        layer = np.flatnonzero(level == number)
        wanted = lumped[layer].copy()
        for giver in np.flatnonzero(level == 0):
            near = 1.0 / np.linalg.norm(mesh.nodes[layer] - mesh.nodes[giver], axis=1)
            wanted += lumped[giver] / 3.0 * near / near.sum()
        assert np.allclose(tensors[layer, 1, 1], wanted, rtol=1e-13)


def reference(scene):
    """Tensors [n, 3, 3] by the oracle."""
    body = scene.bodies[0]
    there = twin(body)
    quad = oracle.quadrature(there.nodes, there.cells, there.kind)
    cell_mass = oracle.lumped_cell_mass(quad, there.density)
    normals = [plane.unit for plane in twin_planes(scene)]
    model, touching = scene.contact, np.unique(there.contact_faces)
    free = ~np.isfinite(body.prescribed)
    return oracle.redistribute(
        there.nodes, there.cells, cell_mass, touching, model.removal, normals, model.depth, free
    ).tensor


@pytest.mark.parametrize("kind", ["hex8", "tet4"])
@pytest.mark.parametrize("removal", ["normal", "full"])
@pytest.mark.parametrize("walls", [1, 2])
def test_same_tensors_as_the_oracle(kind, removal, walls):
    """Two walls: contact faces round an edge, whose corner tets have no node outside K."""
    turn = meshes.rotation(3)
    mesh = block(kind, 4, turn=turn)
    normals = [(0.0, 0.0, 1.0), (0.6, 0.0, 0.8)][:walls]
    scene = scene_of(mesh, ["zmin", "xmin"][:walls], removal, 1, normals, turn)
    tensors, lumped = masses(scene)
    assert np.abs(tensors - reference(scene)).max() <= 1e-12 * lumped.max()


@pytest.mark.parametrize(("kind", "removal"), [("hex8", "normal"), ("tet4", "full")])
@pytest.mark.parametrize("depth", [1, 2, 3, 9])
def test_layers_behind_the_face_get_equal_shares(kind, removal, depth):
    """4 cells deep: 9 layers are not there, the 4 that are take a quarter each."""
    mesh = block(kind, 4, shake=0.0)
    tensors, lumped = masses(scene_of(mesh, removal=removal, depth=depth))
    layer = np.rint(mesh.nodes[:, 2] / (0.18 / 4)).astype(int)
    gained = np.bincount(layer, tensors[:, 2, 2] - lumped, 5)
    removed = lumped[layer == 0].sum()
    share = np.zeros(5)
    share[1 : 1 + depth] = removed / min(depth, 4)
    share[0] = -removed
    assert np.allclose(gained, share, rtol=0.0, atol=1e-13 * removed)


@pytest.mark.parametrize("kind", ["hex8", "tet4"])
def test_supported_components_receive_nothing_that_can_go_elsewhere(kind):
    """K and its neighbours on the side x = 0 are held along x; normal removal along a slanted wall needs x and z."""
    mesh = block(kind, 3)
    held = [tc.Support("xmin", "x")]
    scene = scene_of(mesh, removal="normal", normals=[(0.6, 0.0, 0.8)], supports=held)
    tensors, lumped = masses(scene)
    assert np.abs(tensors - reference(scene)).max() <= 1e-12 * lumped.max()
    side = np.setdiff1d(mesh.nodes_of("xmin"), mesh.nodes_of("zmin"))
    assert np.abs(tensors[side, 0, 0] - lumped[side]).max() <= 1e-13 * lumped.max()
    total = lumped.sum()
    assert np.abs(tensors.sum(axis=0) - total * np.eye(3)).max() <= 1e-12 * total


def test_gravity_acts_through_the_same_tensors():
    """F = M g, so that free fall strains nothing; the sum is the weight."""
    turn = meshes.rotation(5)
    scene = scene_of(block("tet4", 3, turn=turn), removal="normal", turn=turn)
    body = tc.plan(scene).bodies[0]
    assert np.allclose(body.loads, body.tensors @ (1.0, -2.0, 3.0), rtol=1e-14, atol=0.0)
    acceleration = np.einsum("sij,sj->si", body.inverses, body.loads)
    normal = turn[:, 2]
    contact = len(body.contact.nodes)
    fall = np.array([1.0, -2.0, 3.0])
    assert np.allclose(acceleration[contact:], fall, rtol=1e-12)
    assert np.allclose(acceleration[:contact], fall - normal * (normal @ fall), rtol=1e-12, atol=1e-12)
